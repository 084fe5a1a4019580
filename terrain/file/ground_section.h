// SPDX-License-Identifier: MIT
// The section GRND of a world file: the ground, and where the tile of its root lies in TILE; REGN: where the
// patches of a world with a ground stand in it; and IMAG: its imagery, and where the root's image tile lies.
// For world_reader.cpp, world_writer.cpp and world_layout.cpp alone; docs/formats.md has the offsets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "terrain/file/world_file.h"

namespace karst::core::ground_section {

inline constexpr std::size_t kBytes = 64;
inline constexpr std::size_t kImageryBytes = 32;

struct Fault {
  const char* what = nullptr;  // null: none
  std::size_t offset = 0;      // bytes from the section's start
};

// Of a ground that exists: fields out of their range, or a root that does not lie in the tiles.
Fault check(const WorldGround& ground);
// ground is untouched on a fault; its tile_crc always. tile_bytes: of TILE.
Fault decode(std::span<const std::byte, kBytes> section, std::uint64_t tile_bytes, WorldGround& ground);
void encode(const WorldGround& ground, std::span<std::byte, kBytes> out);

// Of REGN, which is there where a world has a ground and patches.
inline constexpr std::size_t kRegionBytes = 16;

// After check(): steps that are those of no region, or patches that are none.
Fault check_region(const WorldInfo& world, const GroundInfo& ground);
// Places the region. ground: of GRND. section: empty where the world has no REGN.
Fault decode_region(std::span<const std::byte> section, const WorldInfo& world, GroundInfo& ground);
// out: kRegionBytes.
void encode_region(const GroundInfo& ground, std::span<std::byte> out);

// The same of imagery that exists, over a ground that was checked. decode_imagery() leaves the rest of
// ground as it is.
Fault check_imagery(const WorldGround& ground);
Fault decode_imagery(std::span<const std::byte, kImageryBytes> section, WorldGround& ground);
void encode_imagery(const WorldGround& ground, std::span<std::byte, kImageryBytes> out);

}  // namespace karst::core::ground_section
