// SPDX-License-Identifier: MIT
// The section GRND of a world file: the ground, and where the tile of its root lies in TILE. For
// world_reader.cpp, world_writer.cpp and world_layout.cpp alone; docs/formats.md has the offsets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "terrain/file/world_file.h"

namespace karst::core::ground_section {

inline constexpr std::size_t kBytes = 64;
// Of a world with patches, which are in the ground's region.
inline constexpr std::size_t kBytesWithRegion = 80;
constexpr std::size_t bytes_of(const WorldInfo& world) {
  return world.patches > 0 ? kBytesWithRegion : kBytes;
}

struct Fault {
  const char* what = nullptr;  // null: none
  std::size_t offset = 0;      // bytes from the section's start
};

// Of a ground that exists: fields out of their range, or a root that does not lie in the tiles.
Fault check(const WorldInfo& world, const WorldGround& ground);
// section: bytes_of(world). ground is untouched on a fault; its tile_crc always. tile_bytes: of TILE.
Fault decode(std::span<const std::byte> section, const WorldInfo& world, std::uint64_t tile_bytes,
             WorldGround& ground);
void encode(const WorldGround& ground, std::span<std::byte> out);

}  // namespace karst::core::ground_section
