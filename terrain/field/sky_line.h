// SPDX-License-Identifier: MIT
// Where there is open sky, by column of voxels: the way to tell caves from open ground without shadows.
//
// The top of a column is the height above which it is empty. Light comes into a cave from the side, so what
// counts is the sky-line: the least, over the columns around, of the column's top plus kSkySlope times its
// distance. A point as high as the sky-line or higher is in the open; in a cave it lies the deeper below, the
// farther the mouth is.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "terrain/base/lattice.h"
#include "terrain/field/octree.h"

namespace karst::core {

inline constexpr float kSkySlope = 1.6f;      // voxels of height a voxel of distance
inline constexpr std::int32_t kSkyReach = 6;  // voxels; columns farther away do not count

// The rows of the sky-line, z = 0, 1, ...
class SkyLine {
 public:
  // octree: borrowed; extent: voxels in use, inside the octree.
  SkyLine(const Octree& octree, glm::ivec3 extent);
  // Writes the next row, extent.x values in voxels; to be called extent.z times.
  void next(std::span<float> out);

 private:
  static constexpr std::int32_t kRows = 2 * kSkyReach + 1;

  void read_row(std::int32_t z);

  const Octree* octree_;
  glm::ivec3 extent_;
  std::int32_t z_ = 0;
  std::array<std::int16_t, 1 << kMaxDepth> tops_[kRows];  // by row modulo kRows
  float rise_[kSkyReach + 1][kSkyReach + 1];              // kSkySlope times distance, by |dz| and |dx|
};

}  // namespace karst::core
