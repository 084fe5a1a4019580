// SPDX-License-Identifier: MIT
// The section GRND of a world file: the ground, and where the tile of its root lies in TILE; then, of a
// curved basis or where a georeference is known, those. REGN: where the patches of a world with a ground
// stand in it. IMAG: its imagery, and where the root's image tile lies. For world_reader.cpp,
// world_writer.cpp and world_layout.cpp alone; docs/formats.md has the offsets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "terrain/file/world_file.h"

namespace karst::core::ground_section {

inline constexpr std::size_t kBytes = 64;
inline constexpr std::size_t kEarthBytes = 192;  // of the second part
inline constexpr std::size_t kMostBytes = kBytes + kEarthBytes;

inline bool has_earth(const WorldGround& ground) {
  return ground.info.basis.is_curved() || ground.earth.exists();
}
inline std::size_t section_bytes(const WorldGround& ground) {
  return has_earth(ground) ? kMostBytes : kBytes;
}
inline constexpr std::size_t kImageryBytes = 32;

struct Fault {
  const char* what = nullptr;  // null: none
  std::size_t offset = 0;      // bytes from the section's start
};

// Of a ground that exists: fields out of their range, or a root that does not lie in the tiles.
Fault check(const WorldGround& ground);
// ground is untouched on a fault; its tile_crc always. section: kBytes or kMostBytes. tile_bytes: of TILE.
// voxel_m: the world's.
Fault decode(std::span<const std::byte> section, std::uint64_t tile_bytes, double voxel_m,
             WorldGround& ground);
// out: section_bytes().
void encode(const WorldGround& ground, std::span<std::byte> out);

// Of REGN, which is there where a world has a ground and patches.
inline constexpr std::size_t kRegionBytes = 16;  // of one, whose octree the header tells of
inline constexpr std::size_t kRegionEntry = 48;  // of each of several, and of a ground that can be dug
inline constexpr std::size_t kMostRegionBytes = kMostRegions * kRegionEntry;
constexpr std::size_t region_bytes(std::size_t regions, bool can_be_dug) {
  return regions == 1 && !can_be_dug ? kRegionBytes : regions * kRegionEntry;
}

// After check(): steps that are those of no region, or patches that are none.
Fault check_regions(const WorldInfo& world, const GroundInfo& ground);
// Places the regions. ground: of GRND. section: empty where the world has no REGN.
Fault decode_regions(std::span<const std::byte> section, const WorldInfo& world, GroundInfo& ground);
// out: region_bytes() of them.
void encode_regions(const GroundInfo& ground, std::span<std::byte> out);

// The same of imagery that exists, over a ground that was checked. decode_imagery() leaves the rest of
// ground as it is.
Fault check_imagery(const WorldGround& ground);
Fault decode_imagery(std::span<const std::byte, kImageryBytes> section, WorldGround& ground);
void encode_imagery(const WorldGround& ground, std::span<std::byte, kImageryBytes> out);

}  // namespace karst::core::ground_section
