// SPDX-License-Identifier: MIT
// Materials in JSON.
#include "bake/materials/material_json.h"
#include "tests/fuzz/run/fuzz_target.h"

#include <cmath>

namespace karst {

void fuzz_one(std::span<const std::byte> input) {
  static const std::string name = "materials.json";
  bake::MaterialFile file;
  const Error error = bake::parse_material_file(as_text(input), name, file);
  must_be_short(error);
  if (!error.ok()) return;
  must(file.materials.size() <= std::size_t{core::kMostMaterials} &&
       file.paint.size() <= bake::MaterialFile::kMostBoxes);
  for (const bake::MaterialSpec& spec : file.materials) {
    must(!spec.name.empty() && spec.name.size() <= 15);
    must(spec.sample.empty() != spec.albedo.empty());
    must(std::isfinite(spec.relief) && std::isfinite(spec.roughness_value));
  }
  must(!file.lights || file.lights->size() <= std::size_t{core::kMostLights});
  if (file.blend_map) must(!file.blend_map->image.empty() && file.blend_map->materials.size() <= 4);
}

}  // namespace karst
