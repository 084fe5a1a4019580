// SPDX-License-Identifier: MIT
// What is around the ground of a world: water up to a level, the plain that the world stands on, and the rim
// where the ground ends. Plain values as they lie in the world file (docs/formats.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <glm/vec3.hpp>

namespace karst::core {

inline constexpr std::uint32_t kHasWater = 1;  // of Surroundings::flags

// Heights are voxels from the octree's minimum corner.
struct Surroundings {
  std::uint32_t flags = 0;
  float water_level = 0;         // of still water; all of the world that is lower is under it
  float plain_level = 0;         // of the ground around the world: its rim's lowest point
  std::uint32_t rim_points = 0;  // 0: not known; then there is no plain and no wall around the world

  bool has_water() const { return (flags & kHasWater) != 0; }
};
static_assert(sizeof(Surroundings) == 16 && std::is_trivially_copyable_v<Surroundings>);

// The rim is a closed line of points on the ground's border, lattice steps within +-kMostRimSteps, clockwise
// seen from above, four a voxel.
inline constexpr std::int32_t kMostRimSteps = 1 << 23;
inline constexpr std::size_t kRimPointBytes = sizeof(glm::ivec3);
constexpr std::uint32_t most_rim_points(glm::ivec3 extent) {
  return 8 * static_cast<std::uint32_t>(extent.x + extent.z);
}

}  // namespace karst::core
