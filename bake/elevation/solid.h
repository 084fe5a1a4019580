// SPDX-License-Identifier: MIT
// What is baked: a solid in world metres, and the grid of voxels that it is baked into.
#pragma once

#include <glm/vec3.hpp>

#include "platform/base/error.h"

namespace karst::bake {

// A solid as a continuous function of the place. Stateless after construction; called from several threads,
// tens of millions of times.
class Solid {
 public:
  virtual ~Solid() = default;
  // Positive inside, negative outside, zero on the surface; near it about the distance to it. All in metres.
  virtual double value_m(glm::dvec3 position_m) const = 0;
};

struct Box {
  glm::dvec3 min{0.0}, max{0.0};
};

// Where a world's voxels lie. The content fills [0.5, extent - 0.5] voxels in x and z (half of the outermost
// voxels: the surface ends there), and at least kLayersBelow voxels lie below it and one layer of air above.
struct WorldGrid {
  double voxel_m = 1;
  glm::dvec3 origin_m{0.0};  // of the octree's minimum corner
  glm::ivec3 extent{0};      // voxels
  int depth = 0;             // of the octree

  static constexpr int kLayersBelow = 2;

  // The grid whose content is centred in the box in x and z, and as large as fits: its sides are cut to whole
  // voxels. An error that names --voxel where the box takes more voxels than an octree has, or less than one.
  static Error around(const Box& content_m, double voxel_m, WorldGrid& grid);

  glm::dvec3 to_m(glm::dvec3 position_voxels) const { return origin_m + voxel_m * position_voxels; }
};

}  // namespace karst::bake
