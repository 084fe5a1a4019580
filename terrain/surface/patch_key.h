// SPDX-License-Identifier: MIT
// What a patch is called for good: the region it belongs to, the corner its intersection volume is centred on
// and its number among the patches of that volume's case. An edit elsewhere changes none of these, whereas a
// patch's number in an extraction of everything changes with every voxel.
//
// Keys sort in the order in which extraction makes patches: by region, then along the octree's order in space
// (Morton's: x + 2y + 4z an octant, from the coarsest bit down), then by case patch.
#pragma once

#include <compare>
#include <cstdint>

#include <glm/vec3.hpp>

#include "terrain/surface/patch.h"

namespace karst::core {

class PatchKey {
 public:
  static constexpr int kCornerBits = 10;  // an axis; corners are 0..2^kMaxDepth
  static constexpr int kCaseBits = 3;
  static constexpr int kRegionBits = 16;
  static constexpr int kBits = kRegionBits + 3 * kCornerBits + kCaseBits;  // those above are 0

  constexpr PatchKey() = default;

  // Preconditions: region < 2^16, corner within 0..1023 on every axis, case_patch < 8.
  static constexpr PatchKey make(std::uint32_t region, std::uint32_t x, std::uint32_t y, std::uint32_t z,
                                 std::uint32_t case_patch) {
    const std::uint64_t morton = spread(x) | spread(y) << 1 | spread(z) << 2;
    return PatchKey(std::uint64_t{region} << kRegionShift | morton << kCaseBits | case_patch);
  }
  static constexpr PatchKey from_bits(std::uint64_t bits) { return PatchKey(bits); }

  constexpr std::uint64_t bits() const { return bits_; }
  constexpr std::uint32_t region() const { return static_cast<std::uint32_t>(bits_ >> kRegionShift); }
  constexpr std::uint32_t case_patch() const {
    return static_cast<std::uint32_t>(bits_ & ((1u << kCaseBits) - 1));
  }
  // Voxels from the octree's minimum corner.
  glm::ivec3 corner() const {
    const std::uint64_t morton = bits_ >> kCaseBits;
    return {gather(morton), gather(morton >> 1), gather(morton >> 2)};
  }
  // The first patch of the same volume.
  constexpr PatchKey of_volume() const { return PatchKey(bits_ - case_patch()); }
  // The same in the first region, which a table of one part goes by.
  constexpr PatchKey in_part() const { return PatchKey(bits_ & ((std::uint64_t{1} << kRegionShift) - 1)); }

  friend constexpr auto operator<=>(PatchKey, PatchKey) = default;

 private:
  static constexpr int kRegionShift = 3 * kCornerBits + kCaseBits;

  explicit constexpr PatchKey(std::uint64_t bits) : bits_(bits) {}

  // Bit b of the value at bit 3b, and back.
  static constexpr std::uint64_t spread(std::uint32_t value) {
    std::uint64_t bits = value & 0x3ffu;
    bits = (bits | bits << 16) & 0x030000ffu;
    bits = (bits | bits << 8) & 0x0300f00fu;
    bits = (bits | bits << 4) & 0x030c30c3u;
    return (bits | bits << 2) & 0x09249249u;
  }
  static constexpr std::int32_t gather(std::uint64_t bits) {
    bits &= 0x09249249u;
    bits = (bits | bits >> 2) & 0x030c30c3u;
    bits = (bits | bits >> 4) & 0x0300f00fu;
    bits = (bits | bits >> 8) & 0x030000ffu;
    return static_cast<std::int32_t>((bits | bits >> 16) & 0x3ffu);
  }

  std::uint64_t bits_ = 0;
};
static_assert(sizeof(PatchKey) == 8);

// region: its number among the world's.
inline PatchKey key_of(const Volume& volume, std::uint32_t case_patch, std::uint32_t region = 0) {
  return PatchKey::make(region, volume.corner[0], volume.corner[1], volume.corner[2], case_patch);
}
inline PatchKey key_of(const Surface& surface, PatchId id, std::uint32_t region = 0) {
  return key_of(surface.volume_of(id), surface.patches[id].case_patch, region);
}

}  // namespace karst::core
