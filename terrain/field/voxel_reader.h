// SPDX-License-Identifier: MIT
// Reads whether voxels are filled, at any integer position: beyond the extent in x and z the nearest voxel
// inside answers, below 0 everything is filled, from extent.y upwards everything is empty. So the surface
// goes straight through the sides of the world, and none is made on its bottom. Or, beyond the extent in x
// and z, the voxel answers that is as far inside: the mirror about the centres of the outermost voxels, where
// the surface ends. Then no gradient there has a component across the side, and the rim stays in its plane.
#pragma once

#include "terrain/field/octree.h"

#include <glm/vec3.hpp>

#include <cstdint>

namespace karst::core {

class VoxelReader {
 public:
  static constexpr int kMaxRow = 32;

  // tree: borrowed. extent: voxels, each axis in 1..tree.size().
  VoxelReader(const Octree& tree, glm::ivec3 extent, bool mirrors = false)
      : tree_(&tree), extent_(extent), mirrors_(mirrors) {}

  const Octree& tree() const { return *tree_; }
  glm::ivec3 extent() const { return extent_; }

  bool filled(glm::ivec3 v) const;

  // Bit i is voxel (x0 + i, y, z), for i < count; higher bits are 0. count in 0..kMaxRow. One descent for the
  // whole row, which does not enter the inside of large leaves.
  std::uint32_t read_row(std::int32_t x0, std::int32_t y, std::int32_t z, int count) const;

 private:
  std::uint32_t read_mirrored_row(std::int32_t x0, std::int32_t y, std::int32_t z, int count) const;

  const Octree* tree_;
  glm::ivec3 extent_;
  bool mirrors_;
};

}  // namespace karst::core
