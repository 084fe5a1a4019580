// SPDX-License-Identifier: MIT
// The flights that benchmarks take over any world, made from its size and the height of its ground.
//
//   low       a loop three quarters of a voxel above the highest ground around, looking ahead
//   oblique   a loop above the summits, looking down and across: the camera of an air photograph
//   high      a loop far above, looking at the middle: all of the world in view
//   teleport  unrelated places and directions, so that nothing of a frame is of use to the next
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <glm/vec2.hpp>

#include "terrain/view/camera.h"
#include "terrain/view/frustum.h"

namespace karst::bench {
using core::CameraSettings;
using core::LatticeBox;

// Height of the ground by column of voxels, in voxels: what boxes of patches reach up to. Of large worlds
// columns are squares of 2^shift voxels a side.
class GroundHeights {
 public:
  static constexpr int kMostColumns = 1 << 22;

  // extent: voxels along x and z.
  explicit GroundHeights(glm::ivec2 extent);
  int shift() const { return shift_; }
  // Raises the columns under a box, which is in lattice steps.
  void add(const LatticeBox& box);
  // The greatest height within so many voxels of a place; 0 where nothing was added.
  double highest(double x, double z, int reach) const;

 private:
  int shift_ = 0;
  glm::ivec2 extent_;  // columns
  std::vector<float> heights_;
};

inline constexpr std::string_view kStandardPaths[] = {"low", "oblique", "high", "teleport"};

// name: of kStandardPaths. box: of the world, lattice steps. Position, yaw and pitch of each frame are set,
// nothing else. frames: at least 1; a loop closes.
std::vector<CameraSettings> make_standard_path(std::string_view name, const GroundHeights& ground,
                                               const LatticeBox& box, int frames);

}  // namespace karst::bench
