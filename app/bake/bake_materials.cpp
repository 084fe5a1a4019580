// SPDX-License-Identifier: MIT
#include "app/bake/bake_materials.h"

#include "app/bake/parallel.h"
#include "app/bake/sample_materials.h"
#include "app/bake/texture_pyramid.h"

#include <algorithm>

namespace karst::bake {

BakedMaterials BakeMaterials::run() const {
  BakedMaterials baked;
  const std::vector<Material> materials = default_materials(relief);
  baked.set.count = static_cast<std::uint32_t>(materials.size());
  baked.set.side = static_cast<std::uint32_t>(side);
  baked.set.format = format;
  std::copy(materials.begin(), materials.end(), baked.set.materials);
  std::vector<MaterialImage> images(materials.size());
  parallel_chunks(images.size(), 1, threads, [&](std::size_t k, std::size_t, int) {
    images[k] = make_sample_material(materials[k].name, side);
  });
  baked.textures = MakeTextures{images, threads}.run(baked.set);
  return baked;
}

}  // namespace karst::bake
