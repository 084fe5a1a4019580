// SPDX-License-Identifier: MIT
// Surface extraction (K 3.4): from the octree to intersection volumes, patches and their adjacency.
//
// Work follows the surface: the traversal visits pairs, quadruples and octuples of octree nodes and stops
// where all of them are leaves of one kind, so the inside of large voxels costs nothing (K 3.4.2.1). K closes
// the sides of the terrain and then removes patches that lie wholly in a side or the bottom (3.4.2.2); here
// volumes centred on sides and bottom are not visited at all, which leaves the same visible surface and no
// rim that bends down at the edge of an elevation model.
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/field/octree.h"
#include "terrain/surface/patch.h"

namespace karst::core {

struct ExtractSurface {
  // Inputs.
  const Octree* octree = nullptr;
  // Voxels in use; x, z in 2..size, y in 1..size-1. Corners 1..extent.x-1 and so on are visited.
  glm::ivec3 extent{};
  bool mirrors = false;  // what is beyond: VoxelReader; of regions (terrain/ground/ground.h)
  // Only volumes centred on corners low..high, both included, are made; their patches have no
  // neighbours beyond. The default is everything.
  glm::ivec3 low{0};
  glm::ivec3 high{1 << kMaxDepth};

  // Outputs, borrowed: filled from the start.
  std::span<Volume> volumes;
  std::span<Patch> patches;

  // Scratch, borrowed: an open-addressing table of corners, see scratch_size().
  std::span<std::uint32_t> scratch;

  struct Result {
    std::uint32_t volumes = 0;
    std::uint32_t patches = 0;
  };

  // Entries of scratch for max_volumes volumes: a power of two, at most 2/3 full.
  static std::size_t scratch_size(std::size_t max_volumes);

  // The volumes and patches that run() would make, without storing any; for sizing memory.
  Status count(Result& result) const;

  Status validate() const;
  // limit_reached ("max_volumes", "max_patches", "max_scratch") when a span is too short; the outputs then
  // hold no surface. Patches come out with height_block = kNoHeights.
  Status run(Result& result) const;
};

}  // namespace karst::core
