// SPDX-License-Identifier: MIT
// Reads a .karst file piece by piece, so that neither the file nor its heights need to fit memory. Each piece
// is checked when it is read: the header and its fields, a section against its checksum, a group of heights
// against its own. Errors are those of world_file.h; unreadable bytes are corrupt, too, naming "file".
#pragma once

#include <cstdint>
#include <span>

#include "terrain/base/status.h"
#include "terrain/voxel/octree.h"
#include "terrain/world/byte_source.h"
#include "terrain/world/world_file.h"

namespace karst {

class WorldReader {
 public:
  // Checks the header. The source is borrowed for the reader's life. info() is empty after a failure.
  Status open(const ByteSource& source);
  const WorldInfo& info() const { return info_; }

  // As karst::read_octree. room: working memory of octree_room(info.octets) bytes.
  Status read_octree(std::span<std::byte> room, Octree& tree) const;
  static std::size_t octree_room(std::uint32_t octets);

  // mask: (patches + 7) / 8 bytes. The others: as long as world_file.h says.
  Status read_mask(std::span<std::byte> mask) const;
  Status read_level_errors(std::span<std::uint16_t> values) const;
  Status read_bounds(std::span<PatchBounds> bounds) const;
  Status read_cones(std::span<NormalCone> cones) const;
  Status read_height_crcs(std::span<std::uint32_t> crcs) const;  // height_groups(height_blocks)

  // One group: its crc from read_height_crcs; out: samples of the group's blocks, the last group may be
  // short.
  Status read_heights(std::uint32_t group, std::uint32_t crc, std::span<std::int16_t> out) const;

 private:
  Status read_section(WorldSection section, std::span<std::byte> out) const;

  ByteSource source_;
  WorldInfo info_;
  WorldSections sections_;
};

}  // namespace karst
