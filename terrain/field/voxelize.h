// SPDX-License-Identifier: MIT
// Filling an octree: from column heights, from a function of the voxel, and editing a box of it by a
// function. All three build nodes bottom-up, so that no octet is taken that the result does not need. Voxel
// (x, y, z) covers [x, x+1) x [y, y+1) x [z, z+1), in voxels from the octree's minimum corner; its centre
// decides.
#pragma once

#include "karst/status.h"
#include "terrain/field/octree.h"

#include <glm/vec3.hpp>

#include <cstdint>
#include <span>

namespace karst::core {

// A borrowed function of a voxel and whether it is filled now. The callable must outlive it; a lambda passed
// in the same full expression as run() does, a named one is safer.
class VoxelFunction {
 public:
  constexpr VoxelFunction() = default;
  // F: bool(glm::ivec3 voxel, bool filled_now) const.
  template <class F>
  explicit VoxelFunction(const F& f)
      : call_([](const void* context, glm::ivec3 v, bool now) -> bool {
          return (*static_cast<const F*>(context))(v, now);
        }),
        context_(&f) {}

  bool exists() const { return call_ != nullptr; }
  bool operator()(glm::ivec3 v, bool now) const { return call_(context_, v, now); }

 private:
  bool (*call_)(const void* context, glm::ivec3 v, bool now) = nullptr;
  const void* context_ = nullptr;
};

// Fills each column up to a height. Voxel (x, y, z) becomes filled where y + 0.5 < top(x, z) and y <
// extent.y; all else becomes empty. The work follows the surface: each node compares its height range with
// its columns' minimum and maximum.
struct VoxelizeHeights {
  glm::ivec3 extent{0};         // voxels; each axis in 1..the octree's size
  std::span<const float> tops;  // extent.x * extent.z column tops, index z * extent.x + x, voxels from the
                                // octree's minimum y; NaN is a hole (empty column), infinities are clamped

  // invalid_argument: "extent" or "tops" (not extent.x * extent.z long).
  Status validate() const;
  // Replaces the octree's contents. limit_reached ("max_octets", value: octets that are needed) leaves it
  // empty.
  Status run(Octree& tree) const;
  // Octets that run takes in an octree of this depth; 0 where validate() fails or extent exceeds its size.
  std::uint32_t count_octets(int depth) const;
};

// Fills by a function, called once for every voxel of the extent with filled_now = false.
struct VoxelizePredicate {
  glm::ivec3 extent{0};  // voxels; each axis in 1..the octree's size; voxels beyond become empty
  VoxelFunction filled;

  // invalid_argument: "extent" or "filled" (absent).
  Status validate() const;
  // Replaces the octree's contents. limit_reached ("max_octets") leaves it empty.
  Status run(Octree& tree) const;
};

// Changes a box of the octree: each voxel in it becomes what the function says, called once a voxel.
struct EditVoxels {
  glm::ivec3 box_min{0};  // voxels; the box is half-open and clipped to [0, extent), and may be empty
  glm::ivec3 box_max{0};
  glm::ivec3 extent{0};  // voxels; each axis in 1..the octree's size
  VoxelFunction filled;

  // invalid_argument: "extent" or "filled" (absent).
  Status validate() const;
  // limit_reached ("max_octets"): the octree is valid, and part of the box has its new value.
  Status run(Octree& tree) const;
};

}  // namespace karst::core
