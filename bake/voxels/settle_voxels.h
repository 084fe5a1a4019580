// SPDX-License-Identifier: MIT
// Takes away what is one voxel wide, as settle_tops does for columns: tips and pits, and voxels that touch
// only across an edge or a corner. There the smoothed gradient that vertices move along turns against the
// surface. The heights that are fitted afterwards bring back as much of the shape as the voxels around can
// carry.
#pragma once

#include <glm/vec3.hpp>

#include <cstdint>
#include <span>

namespace karst::bake {

struct SettleVoxels {
  glm::ivec3 extent{0};
  // The solid's value at voxel centres, index (z * extent.y + y) * extent.x + x: filled where above 0. In and
  // out: voxels that change get the smallest value of the other sign. What is least sure, nearest to 0,
  // changes first.
  std::span<float> values;

  // Outside of the extent the nearest voxel counts, and air above the top layer, which stays air.
  // Returns the number of voxels that changed.
  std::uint64_t run() const;
};

}  // namespace karst::bake
