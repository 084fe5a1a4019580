// SPDX-License-Identifier: MIT
// Reads a .karst file piece by piece, so that neither the file nor its heights need to fit memory. Each piece
// is checked when it is read: the header and its fields, a section against its checksum and its rules, a
// group of heights against its own checksum; verify() checks all of the file. Files in memory are read alike,
// by ByteSource::of.
//
// corrupt: the bytes contradict themselves; unsupported: another version, or a required section of unknown
// kind; io ("file", value: offset of the first byte that was asked for): the source cannot read.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/field/octree.h"
#include "terrain/file/byte_source.h"
#include "terrain/file/materials/material_section.h"
#include "terrain/file/world_file.h"
#include "terrain/file/world_layout.h"
#include "terrain/isosurface/field_blocks.h"

namespace karst::core {

class WorldReader {
 public:
  // Checks the header, materials, lights, surroundings and the ground, but no tile. The source is borrowed
  // for the reader's life. info() and the others are empty after a failure.
  Status open(const ByteSource& source);
  // The same file through another source; what open() has read and checked is not read again.
  // invalid_argument ("file") where its length or its header's checksum differs. Precondition: open()
  // succeeded.
  Status go_on(const ByteSource& source);
  // Of sources the length alone is kept.
  void forget_source() { source_ = {source_.bytes}; }
  // Of the header, which holds those of all sections.
  std::uint32_t head_crc() const { return head_crc_; }
  const WorldInfo& info() const { return info_; }
  const MaterialSet& materials() const { return materials_; }
  // materials().blend_map, for a world that is painted: as it is then.
  BlendMap& painted_map() { return materials_.blend_map; }
  std::span<const PointLight> lights() const { return std::span(lights_).first(light_count_); }
  const Surroundings& surroundings() const { return surroundings_; }
  bool has_overrides() const;
  const GroundInfo& ground() const { return ground_.info; }  // does not exist where the world has none
  // Of a ground that lies where a function says: that, whose limits are those of the file.
  Status lend(const BasisFunction& function);
  const Georeference& earth() const { return ground_.earth; }
  const TilePlace& root_tile() const { return ground_.root; }
  std::uint64_t tile_bytes() const { return ground_.tile_bytes; }
  const ImageryInfo& imagery() const { return ground_.imagery; }  // the same
  const TilePlace& root_image() const { return ground_.image_root; }

  // Reads all of the file, through a small buffer: all that the functions below check, and the checksums of
  // sections of unknown kind; but not the octree's nodes, whose check takes memory, and of tiles
  // the section's checksum alone. Precondition: open()
  // succeeded.
  Status verify() const;

  // Replaces the octree's contents, depth included. The octree is empty on failure. limit_reached
  // ("max_octets", value: info.octets) where its pool is smaller; corrupt where the section's nodes do not
  // make a tree of info.octets octets, fully collapsed, filled only inside the extent.
  // room: working memory of octree_room(info.octets) bytes.
  Status read_octree(std::span<std::byte> room, Octree& tree) const { return read_octrees(room, {&tree, 1}); }
  // The same of all regions. Precondition: as many as info.regions.
  Status read_octrees(std::span<std::byte> room, std::span<Octree> trees) const;
  static std::size_t octree_room(std::uint32_t octets, std::uint32_t trees = 1);

  // mask: (patches + 7) / 8 bytes. The others: as long as world_file.h says.
  Status read_keys(std::span<PatchKey> keys) const;
  Status read_mask(std::span<std::byte> mask) const;
  Status read_level_errors(std::span<std::uint16_t> values) const;
  Status read_bounds(std::span<PatchBounds> bounds) const;
  Status read_cones(std::span<NormalCone> cones) const;
  Status read_shading_cones(std::span<NormalCone> cones) const;
  Status read_height_crcs(std::span<std::uint32_t> crcs) const;  // height_groups(height_blocks)

  // Whether the surfaces, one a region as extraction makes them, have exactly the patches of the file: then
  // the file's n-th is their n-th, because both ascend by key. corrupt ("patch keys", at the first that
  // differs) where they are not the same set. Needs no memory.
  Status match_keys(std::span<const Surface> surfaces) const;
  Status match_keys(const Surface& surface) const { return match_keys({&surface, 1}); }

  // Materials of patches: one byte a patch, all 0 where the world has no overrides.
  Status read_overrides(std::span<std::uint8_t> overrides) const;

  // Layers [first, first + count) of one level of an array, as they lie in the file, each checked against its
  // checksum. out: count x texture_image_bytes(). Precondition: they are there.
  Status read_textures(TextureArray array, int level, std::uint32_t first, std::uint32_t count,
                       std::span<std::byte> out) const;

  // Rows [first, first + count) of materials().blend_map, each checked against its checksum. out: count x
  // width x kBlendTexelBytes. Precondition: they are there.
  Status read_blend_rows(std::uint32_t first, std::uint32_t count, std::span<std::byte> out) const;

  // surroundings().rim_points of them.
  Status read_rim(std::span<glm::ivec3> rim) const;

  // The bytes of a tile, which are not checked: decode_tile() or check_image_tile() does. corrupt ("tiles")
  // where the place is not in the section. out: place.bytes.
  Status read_tile(const TilePlace& place, std::span<std::byte> out) const;

  // Does not exist where the world has none.
  const FieldInfo& field() const { return field_; }
  // Resets out and fills it. limit_reached naming the Config field; nothing is in it on failure.
  // Precondition: field().exists().
  Status read_field(FieldBlocks& out) const;

  // A section as it lies in the file, checked against its checksum: what does not match was written by then.
  // Precondition: it is there. limit_reached ("sink") where the sink does not take it.
  bool has_section(WorldSection section) const { return place_of(section).present; }
  std::uint64_t section_bytes(WorldSection section) const { return place_of(section).bytes; }
  std::uint32_t section_crc(WorldSection section) const { return place_of(section).crc; }
  Status copy_section(WorldSection section, const ByteSink& sink) const;

  // One group: its crc from read_height_crcs; out: samples of the group's blocks, the last group may be
  // short.
  Status read_heights(std::uint32_t group, std::uint32_t crc, std::span<std::int16_t> out) const;

 private:
  const world_layout::SectionPlace& place_of(WorldSection section) const {
    return table_.places[static_cast<std::size_t>(section)];
  }
  // corrupt, naming the section, `offset` bytes from its start.
  Status corrupt_section(WorldSection section, const char* what, std::uint64_t offset) const;
  Status read_bytes(std::uint64_t offset, std::span<std::byte> out) const;
  // A section as a whole, checked against its checksum.
  Status read_section(WorldSection section, std::span<std::byte> out) const;
  // The same, and against its rules.
  Status read_checked(WorldSection section, std::span<std::byte> out) const;
  template <class Visit>
  Status for_each_piece(std::uint64_t offset, std::uint64_t bytes, const Visit& visit) const;
  Status read_materials();
  Status read_blend_map();
  Status read_lights();
  Status read_surroundings(glm::ivec3 extent);
  Status read_ground(double voxel_m);
  Status read_regions(const WorldInfo& info);
  Status read_imagery();
  Status verify_section(WorldSection section) const;
  Status verify_groups() const;
  Status verify_images() const;
  Status verify_blend_rows() const;
  Status verify_rim() const;
  Status read_field_header();
  Status check_field_region();
  Status decode_field(FieldBlocks* out) const;

  ByteSource source_;
  std::uint32_t head_crc_ = 0;
  WorldInfo info_;
  world_layout::Table table_;
  MaterialSet materials_;
  std::array<std::uint32_t, material_section::kMostImages> image_crcs_{};
  std::array<PointLight, kMostLights> lights_{};
  std::size_t light_count_ = 0;
  Surroundings surroundings_;
  WorldGround ground_;
  FieldInfo field_;
};

}  // namespace karst::core
