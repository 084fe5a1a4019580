// SPDX-License-Identifier: MIT
// The voxel index (K 3.3.1): names any voxel of an octree, leaf or internal, in 31 bits, and carries whether
// it is filled in the 32nd. From the most significant bit: 4 bits level (0 is the root), 9 bits each x, y and
// z, fill. The first (most significant) bit of a field chooses the child of the root, the next one the child
// below, and so on; a voxel of level l uses the first l bits.
//
// Departure from K: bits below a voxel's level are always 0, so that equal voxels have equal indices. K's
// parent only decrements the level and leaves them.
#pragma once

#include "terrain/base/check.h"
#include "terrain/base/lattice.h"

#include <glm/vec3.hpp>

#include <cstdint>

namespace karst::core {

class VoxelIndex {
 public:
  static constexpr int kAxisBits = kMaxDepth;  // bits an axis; also the deepest level

  // The root, empty.
  constexpr VoxelIndex() = default;

  // The voxel of a level (0..9) that holds the finest voxel v of an octree of that depth (level..9).
  // Precondition: v in [0, 2^depth) on every axis.
  static constexpr VoxelIndex of(int level, glm::ivec3 v, int depth = kMaxDepth, bool fill = false) {
    KARST_ASSERT(0 <= level && level <= depth && depth <= kMaxDepth);
    KARST_ASSERT(v.x >> depth == 0 && v.y >> depth == 0 && v.z >> depth == 0);
    const int shift = kAxisBits - depth;
    return {level, field_of(v.x, shift), field_of(v.y, shift), field_of(v.z, shift), fill};
  }

  // From the four fields as K writes them (figures 3.2, 3.3). Bits below the level are cleared.
  constexpr VoxelIndex(int level, std::uint32_t x, std::uint32_t y, std::uint32_t z, bool fill)
      : bits_(static_cast<std::uint32_t>(level) << kLevelShift | (x & used_bits(level)) << kXShift |
              (y & used_bits(level)) << kYShift | (z & used_bits(level)) << kZShift | (fill ? 1u : 0u)) {}

  constexpr std::uint32_t bits() const { return bits_; }
  constexpr int level() const { return static_cast<int>(bits_ >> kLevelShift); }
  constexpr std::uint32_t x() const { return bits_ >> kXShift & kAxisMask; }
  constexpr std::uint32_t y() const { return bits_ >> kYShift & kAxisMask; }
  constexpr std::uint32_t z() const { return bits_ >> kZShift & kAxisMask; }
  constexpr bool filled() const { return (bits_ & 1u) != 0; }
  constexpr VoxelIndex with_fill(bool fill) const { return {level(), x(), y(), z(), fill}; }

  // The voxel that contains this one, same fill bit. Precondition: level() > 0.
  constexpr VoxelIndex parent() const {
    KARST_ASSERT(level() > 0);
    return {level() - 1, x(), y(), z(), filled()};
  }

  // Child in octant x + 2y + 4z, same fill bit. Precondition: level() < 9.
  constexpr VoxelIndex child(int octant) const {
    KARST_ASSERT(level() < kAxisBits);
    const auto o = static_cast<std::uint32_t>(octant);
    const int shift = kAxisBits - 1 - level();
    return {level() + 1, x() | (o & 1u) << shift, y() | (o >> 1 & 1u) << shift, z() | (o >> 2 & 1u) << shift,
            filled()};
  }

  // Which octant of its parent this voxel is. Precondition: level() > 0.
  constexpr int octant() const {
    KARST_ASSERT(level() > 0);
    const int shift = kAxisBits - level();
    return static_cast<int>((x() >> shift & 1u) | (y() >> shift & 1u) << 1 | (z() >> shift & 1u) << 2);
  }

  // One of the 26 neighbours of the same level; step is -1, 0 or 1 an axis. The fill bit of the result is 0.
  // Returns false, and leaves result, where the neighbour would lie outside the octree.
  constexpr bool neighbour(glm::ivec3 step, VoxelIndex& result) const {
    const std::int32_t one = std::int32_t{1} << (kAxisBits - level());
    const std::int32_t nx = static_cast<std::int32_t>(x()) + step.x * one;
    const std::int32_t ny = static_cast<std::int32_t>(y()) + step.y * one;
    const std::int32_t nz = static_cast<std::int32_t>(z()) + step.z * one;
    if (!inside(nx) || !inside(ny) || !inside(nz)) return false;
    result = {level(), static_cast<std::uint32_t>(nx), static_cast<std::uint32_t>(ny),
              static_cast<std::uint32_t>(nz), false};
    return true;
  }

  // In an octree of a depth (level()..9), in its finest voxels: edge (K equation 3.4) and minimum corner.
  constexpr std::int32_t size(int depth) const { return std::int32_t{1} << (depth - level()); }
  constexpr glm::ivec3 min_corner(int depth) const {
    const int shift = kAxisBits - depth;
    return {static_cast<std::int32_t>(x() >> shift), static_cast<std::int32_t>(y() >> shift),
            static_cast<std::int32_t>(z() >> shift)};
  }
  // K's position, the voxel's centre (equation 3.5), from the octree's minimum corner and doubled, so that it
  // is exact in integers: half voxels.
  constexpr glm::ivec3 centre_half_voxels(int depth) const {
    const glm::ivec3 corner = min_corner(depth);
    const std::int32_t edge = size(depth);
    return {2 * corner.x + edge, 2 * corner.y + edge, 2 * corner.z + edge};
  }

  friend constexpr bool operator==(VoxelIndex, VoxelIndex) = default;

 private:
  static constexpr int kZShift = 1;
  static constexpr int kYShift = kZShift + kAxisBits;
  static constexpr int kXShift = kYShift + kAxisBits;
  static constexpr int kLevelShift = kXShift + kAxisBits;
  static constexpr std::uint32_t kAxisMask = (1u << kAxisBits) - 1;

  static constexpr std::uint32_t used_bits(int level) { return kAxisMask & ~(kAxisMask >> level); }
  static constexpr std::uint32_t field_of(std::int32_t v, int shift) {
    return static_cast<std::uint32_t>(v) << shift;
  }
  static constexpr bool inside(std::int32_t v) { return v >= 0 && v <= static_cast<std::int32_t>(kAxisMask); }

  std::uint32_t bits_ = 0;
};
static_assert(sizeof(VoxelIndex) == 4);

}  // namespace karst::core
