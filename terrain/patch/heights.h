// SPDX-License-Identifier: MIT
// Heights of patches: 16-bit displacement along W (displacement.h), one block of (2^level + 1)^2 samples a
// patch, row by row (index j * side + i). Unit: lattice steps. Vertices that patches share hold the same
// value in each of them (shared_vertices.h); heights.h only says where values are.
#pragma once

#include <cstdint>
#include <span>

#include "terrain/base/lattice.h"

namespace karst::core {

// |height| limit in lattice steps. A vertex lies within half a voxel of its origin before displacement and
// |W| <= 1, so positions stay inside int16 (4 voxels) with 0.1 voxel to spare.
inline constexpr std::int32_t kMaxHeight = 28'000;

// Blocks come from a file in groups of this many; each group has a checksum (world_file.h).
inline constexpr std::uint32_t kHeightGroup = 8;

struct Heights {
  int level = 0;                          // of the blocks, 1..kMaxLevel
  std::span<const std::int16_t> samples;  // blocks x patch_vertices(level)
  // Empty: block b is the b-th of samples. Else by group: samples holds group g as its groups[g]-th; only
  // blocks that are held may be asked for (height_cache.h).
  std::span<const std::uint32_t> groups = {};

  const std::int16_t* block(std::uint32_t index) const {
    if (!groups.empty()) index = groups[index / kHeightGroup] * kHeightGroup + index % kHeightGroup;
    return samples.data() + std::size_t{index} * static_cast<std::size_t>(patch_vertices(level));
  }
};

}  // namespace karst::core
