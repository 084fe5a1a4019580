// SPDX-License-Identifier: MIT
// Where the procedural materials lie by default: rules that suit a world's relief. A material file
// (material_json.h) replaces them.
#pragma once

#include "terrain/shading/materials.h"

#include <string_view>
#include <vector>

namespace karst::bake {
using namespace core;

struct WorldRelief {
  std::string_view sample = {};  // empty: an elevation image
  float low = 0, high = 0;       // of the ground, voxels from the octree's minimum corner
  double voxel_m = 1;
};

// Named as the procedural materials (sample_materials.h) and in order; averages are not set.
std::vector<Material> default_materials(const WorldRelief& relief);

// One of them with the rules that it has there, or, where it has none, with no limits. Precondition:
// is_sample_material(name).
Material default_material(std::string_view name, const WorldRelief& relief);

}  // namespace karst::bake
