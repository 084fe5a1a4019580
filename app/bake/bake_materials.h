// SPDX-License-Identifier: MIT
// What the ground of a baked world is made of: images, rules, textures.
#pragma once

#include "app/bake/material_rules.h"
#include "terrain/world/world_file.h"

#include <cstddef>
#include <vector>

namespace karst::bake {

inline constexpr int kDefaultMaterialSide = 256;

struct BakedMaterials {
  MaterialSet set;
  std::vector<std::byte> textures;
  std::vector<std::uint8_t> overrides;
  std::vector<PointLight> lights;

  WorldMaterials view() const { return {set, textures, overrides, lights}; }
};

struct BakeMaterials {
  int side = kDefaultMaterialSide;  // texels: a power of two, 16..1024
  TextureFormat format = TextureFormat::rgba8;
  int threads = 1;
  WorldRelief relief;

  BakedMaterials run() const;
};

}  // namespace karst::bake
