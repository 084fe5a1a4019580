// SPDX-License-Identifier: MIT
// Images of materials and of painted weights as karst-bake reads them: by a child with limits.
#include "bake/materials/material_files.h"
#include "tests/fuzz/run/fuzz_target.h"
#include "tests/fuzz/run/image_place.h"

#include <array>

namespace karst {

void fuzz_one(std::span<const std::byte> input) {
  static const ImagePlace place;
  bake::MaterialSpec spec;
  spec.albedo = place.write("image", input);
  bake::MaterialImage image(16);
  bake::TexelBudget budget(std::array{spec.albedo, spec.albedo});
  Error error = bake::read_material_image(spec, "", 16, budget, image);
  must_be_short(error);
  if (error.ok()) {
    must(image.side == 16 && image.albedo.size() == 256);
    for (const glm::vec3& colour : image.albedo) must(colour.r >= 0 && colour.g >= 0 && colour.b >= 0);
  }
  bake::BlendMap map;
  std::vector<std::byte> texels;
  error = bake::read_blend_map(spec.albedo, 1, budget, map, texels);
  must_be_short(error);
  if (!error.ok()) return;
  must(map.width >= 1 && map.depth >= 1);
  must(texels.size() == std::size_t{map.width} * map.depth * core::kBlendTexelBytes);
}

}  // namespace karst
