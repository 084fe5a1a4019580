// SPDX-License-Identifier: MIT
// The gradient of the smoothed occupancy at voxel centres: the direction W along which heights displace
// (design 4.4). Occupancy is smoothed by 1-2-1 along each axis (sigma about 0.7 voxel) and differenced
// centrally, all in integers, so the eight gradients of an intersection volume are exact.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

#include "terrain/field/voxel_reader.h"

namespace karst::core {

// Largest |component|: the kernel [1 2 0 -2 -1] (x) [1 2 1] (x) [1 2 1] adds up to 3 * 4 * 4 on one side.
inline constexpr int kMaxGradient = 48;

// Occupancy around a voxel corner: row [z][y] holds in bit x the voxel at corner - 3 + (x, y, z), all 0..5.
struct Neighbourhood {
  std::uint32_t row[6][6];
};

// Reads neighbourhoods. Corners asked for in Morton order share most of what they read: a block of 8^3
// corners is read at once, as 13 x 13 rows of 13 voxels, instead of 36 rows of 6 for each of its corners.
class NeighbourhoodReader {
 public:
  explicit NeighbourhoodReader(const VoxelReader& reader) : reader_(reader) {}

  Neighbourhood read(glm::ivec3 corner);

 private:
  static constexpr int kBlock = 8;          // corners a side
  static constexpr int kRows = kBlock + 5;  // voxels a side that they look at

  void read_block(glm::ivec3 block);

  VoxelReader reader_;
  glm::ivec3 block_{-1};              // minimum corner of the block in rows_; -1: none
  std::uint32_t rows_[kRows][kRows];  // [z][y], bit x
};

// Gradients at the eight voxel centres around the corner, by octant, pointing from filled to empty.
void corner_gradients(const Neighbourhood& n, std::int8_t (&gradient)[8][3]);

}  // namespace karst::core
