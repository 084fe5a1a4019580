// SPDX-License-Identifier: MIT
// Places for lights in caves: where the air under rock is widest.
#pragma once

#include "terrain/field/octree.h"
#include "terrain/shading/materials.h"

#include <glm/vec3.hpp>

#include <vector>

namespace karst::bake {
using namespace core;

struct PlaceCaveLights {
  const Octree* octree = nullptr;
  glm::ivec3 extent{0};
  int most = 5;             // 0..kMostLights
  float least_room = 1.5f;  // voxels from rock, in all directions
  float apart = 9;          // voxels between two lights

  // The widest first. Fewer where there are not so many places.
  std::vector<PointLight> run() const;
};

}  // namespace karst::bake
