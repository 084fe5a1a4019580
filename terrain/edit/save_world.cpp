// SPDX-License-Identifier: MIT
// All sections are gone through twice, as in world_writer.cpp: for their checksums, and to be written.
#include "terrain/edit/save_world.h"

#include <algorithm>
#include <array>
#include <cstring>

#include <glm/common.hpp>

#include "terrain/base/checksum.h"
#include "terrain/file/fields/field_section.h"
#include "terrain/file/ground_section.h"
#include "terrain/file/materials/material_section.h"
#include "terrain/file/octree_section.h"
#include "terrain/file/world_layout.h"

namespace karst::core {

using namespace world_layout;

namespace {

Status put(const ByteSink& sink, std::span<const std::byte> bytes) {
  if (bytes.empty() || sink.write(sink.context, bytes)) return {};
  return {StatusCode::limit_reached, "the bytes cannot be written", "sink"};
}

// Small values on their way to a sink.
class Buffer {
 public:
  explicit Buffer(const ByteSink& sink) : sink_(sink) {}
  template <class T>
  void add(const T& value) {
    if (used_ + sizeof value > room_.size()) flush();
    std::memcpy(room_.data() + used_, &value, sizeof value);
    used_ += sizeof value;
  }
  Status finish() {
    flush();
    return status_;
  }

 private:
  void flush() {
    if (status_.ok()) status_ = put(sink_, std::span(room_).first(used_));
    used_ = 0;
  }

  const ByteSink& sink_;
  std::array<std::byte, 4096> room_;
  std::size_t used_ = 0;
  Status status_;
};

class Saver {
 public:
  Saver(const SaveWorld& job, std::span<PatchId> order)
      : world_(*job.world), reader_(job.world->reader()), tiles_(job.tiles), order_(order) {
    const std::span<const std::uint8_t> overrides = world_.material_overrides();
    has_overrides_ = std::ranges::any_of(overrides, [](std::uint8_t material) { return material != 0; });
  }

  // Counts what there is and puts patches into the order of their keys.
  void count() {
    info_ = reader_.info();
    ground_.info = reader_.ground();
    ground_.earth = reader_.earth();
    ground_.root = reader_.root_tile();
    ground_.tile_bytes = reader_.tile_bytes();
    ground_.imagery = reader_.imagery();
    ground_.image_root = reader_.root_image();
    if (tiles_ != nullptr) {
      ground_.root = tiles_->root;
      ground_.tile_bytes = tiles_->kept + tiles_->bytes;
      ground_.info.low = tiles_->low;
      ground_.info.high = tiles_->high;
    }
    take_regions();
    info_.octets = info_.volumes = info_.patches = info_.height_blocks = 0;
    for (std::size_t n = 0; n < world_.parts().size(); ++n) count_part(n);
    order_ = order_.first(info_.patches);
    std::sort(order_.begin(), order_.end(), [&](PatchId a, PatchId b) { return key(a) < key(b); });
  }

  Status run(const ByteSink& sink) {
    SectionPlaces places;
    const std::uint64_t bytes = lay_out_sections(places);
    for (const WorldSection section : writing_order()) {
      SectionPlace& place = places[static_cast<std::size_t>(section)];
      if (!place.present) continue;
      if (const Status status = checksum(section, place.crc); !status.ok()) return status;
    }
    std::array<std::byte, kMostHead> room;
    std::uint64_t end = store_head(info_, places, bytes, room);
    if (const Status status = put(sink, std::span(room).first(static_cast<std::size_t>(end))); !status.ok())
      return status;
    for (const WorldSection section : writing_order()) {
      const SectionPlace& place = places[static_cast<std::size_t>(section)];
      if (!place.present) continue;
      static constexpr std::array<std::byte, kWorldSectionAlignment> kZeros{};
      Status status = put(sink, std::span(kZeros).first(static_cast<std::size_t>(place.offset - end)));
      if (status.ok()) status = put_section(section, sink);
      if (!status.ok()) return status;
      end = place.offset + place.bytes;
    }
    return {};
  }

 private:
  const Surface& surface(std::size_t part) const { return world_.parts()[part].surface; }
  const Patch& patch(PatchId id) const {
    const WorldPart& part = world_.part_of(id);
    return part.surface.patches[id - part.first];
  }
  PatchKey key(PatchId id) const {
    const std::size_t n = world_.part_number(id);
    return key_of(surface(n), id - world_.parts()[n].first, static_cast<std::uint32_t>(n));
  }

  // Those that edits have made, too.
  void take_regions() {
    const GroundInfo& now = world_.ground();
    if (!now.can_be_dug || now.region_count == 0) return;
    ground_.info.region_count = now.region_count;
    ground_.info.region_list = now.region_list;
    info_.regions = static_cast<std::uint32_t>(now.region_count);
    info_.extent = glm::ivec3(0);
    info_.depth = 0;
    for (const GroundRegion& region : now.regions()) {
      info_.extent = glm::max(info_.extent, region.extent);
      info_.depth = std::max(info_.depth, region.depth);
    }
  }

  void count_part(std::size_t n) {
    const WorldPart& part = world_.parts()[n];
    const auto octets = part.octree == nullptr ? 0 : part.octree->octets_used();
    std::uint32_t volumes = 0, patches = 0;
    for (const Volume& volume : part.surface.volumes) volumes += volume.patch_count != 0;
    for (PatchId id = 0; id < part.surface.patches.size(); ++id) {
      const Patch& own = part.surface.patches[id];
      if (own.volume == kNoVolume) continue;
      order_[info_.patches + patches++] = part.first + id;
      info_.height_blocks += own.height_block != kNoHeights;
    }
    info_.octets += octets;
    info_.volumes += volumes;
    info_.patches += patches;
    if (n >= ground_.info.regions().size()) return;
    GroundRegion& region = ground_.info.region_list[n];
    region.octets = octets;
    region.volumes = volumes;
    region.patches = patches;
    region.rim_edges = static_cast<std::uint32_t>(part.rim->edges().size());
  }

  // The file's, and what painting adds.
  bool has_section(WorldSection section) const {
    if (reader_.has_section(section)) return true;
    if (section == WorldSection::overrides) return has_overrides_;
    if (section == WorldSection::region) return ground_.info.region_count > 0;
    if (section == WorldSection::field) return world_.field().exists();
    if (section != WorldSection::blend_map || !world_.is_paintable()) return false;
    return std::ranges::any_of(map().materials, [](std::uint8_t material) { return material != 0; });
  }
  const BlendMap& map() const { return world_.materials().blend_map; }

  std::uint64_t bytes_of(WorldSection section) const {
    if (kind_of(section).bytes != nullptr) return kind_of(section).bytes(info_);
    if (section == WorldSection::tiles) return ground_.tile_bytes;
    if (section == WorldSection::region)
      return ground_section::region_bytes(info_.regions, ground_.info.can_be_dug);
    if (section == WorldSection::field)
      return field_section::section_bytes(field_section::info_of(world_.field()));
    if (section == WorldSection::blend_map) return material_section::blend_section_bytes(map());
    return reader_.section_bytes(section);
  }

  std::uint64_t lay_out_sections(SectionPlaces& places) const {
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < kWorldSectionKinds; ++i) count += has_section(static_cast<WorldSection>(i));
    std::uint64_t end = kHeaderBytes + count * kEntryBytes;
    std::uint64_t entry = kHeaderBytes;
    for (const WorldSection section : writing_order()) {
      if (!has_section(section)) continue;
      SectionPlace& place = places[static_cast<std::size_t>(section)];
      place.present = true;
      place.entry = entry;
      entry += kEntryBytes;
      place.offset = align_up(end);
      place.bytes = bytes_of(section);
      end = place.offset + place.bytes;
    }
    return end;
  }

  Status checksum(WorldSection section, std::uint32_t& crc) const {
    crc = 0;
    if (is_copied(section)) {
      crc = reader_.section_crc(section);
      return {};
    }
    const auto add = [&](std::span<const std::byte> bytes) {
      crc = crc32c(bytes, crc);
      return true;
    };
    if (section != WorldSection::tiles) return put_section(section, ByteSink::to(add));
    crc = tiles_ == nullptr ? reader_.section_crc(section) : tiles_->crc;
    return {};
  }

  bool is_copied(WorldSection section) const {
    switch (section) {
      case WorldSection::materials:
      case WorldSection::textures:
      case WorldSection::lights:
      case WorldSection::surroundings:
      case WorldSection::imagery:
        return true;
      case WorldSection::blend_map:
        return !world_.is_paintable();
      default:
        return false;
    }
  }

  template <class Value>
  Status put_each(const ByteSink& sink, const Value& value) const {
    Buffer buffer(sink);
    for (const PatchId id : order_) buffer.add(value(id));
    return buffer.finish();
  }

  Status put_mask(const ByteSink& sink) const {
    Buffer buffer(sink);
    for (std::size_t first = 0; first < order_.size(); first += 8) {
      unsigned bits = 0;
      for (std::size_t n = first; n < std::min(first + 8, order_.size()); ++n)
        bits |= static_cast<unsigned>(patch(order_[n]).height_block != kNoHeights) << (n - first);
      buffer.add(static_cast<std::byte>(bits));
    }
    return buffer.finish();
  }

  // Calls visit(block) for the blocks of heights in the order of the file.
  template <class Visit>
  Status for_each_block(const Visit& visit) const {
    const Heights heights = world_.heights();
    const auto count = static_cast<std::size_t>(patch_vertices(info_.level));
    for (const PatchId id : order_) {
      const std::uint32_t block = patch(id).height_block;
      if (block == kNoHeights) continue;
      if (const Status status = visit(std::as_bytes(std::span(heights.block(block), count))); !status.ok())
        return status;
    }
    return {};
  }

  Status put_sample_crcs(const ByteSink& sink) const {
    std::uint32_t crc = 0, blocks = 0;
    Buffer buffer(sink);
    const Status status = for_each_block([&](std::span<const std::byte> block) -> Status {
      crc = crc32c(block, crc);
      if (++blocks % kHeightGroup != 0) return {};
      buffer.add(crc);
      crc = 0;
      return {};
    });
    if (blocks % kHeightGroup != 0) buffer.add(crc);
    const Status put_all = buffer.finish();
    return status.ok() ? put_all : status;
  }

  Status put_level_errors(const ByteSink& sink) const {
    const std::size_t values = level_error_values(info_.level);
    const std::span<const std::uint16_t> all = world_.all_level_errors().values;
    Buffer buffer(sink);
    for (const PatchId id : order_) {
      for (const std::uint16_t value : all.subspan(id * values, values)) buffer.add(value);
    }
    return buffer.finish();
  }

  Status put_octrees(const ByteSink& sink) const {
    for (std::size_t n = 0; n < world_.parts().size(); ++n) {
      const WorldPart& part = world_.parts()[n];
      const std::uint32_t octets = part.octree->octets_used();
      const glm::ivec3 extent = world_.parts().size() == 1 ? info_.extent : part.extent;
      if (const Status status = encode_octree(*part.octree, octets, extent, sink); !status.ok())
        return status;
    }
    return {};
  }

  Status put_ground(const ByteSink& sink) const {
    std::array<std::byte, ground_section::kMostBytes> room;
    const auto bytes = std::span(room).first(ground_section::section_bytes(ground_));
    ground_section::encode(ground_, bytes);
    return put(sink, bytes);
  }

  Status put_regions(const ByteSink& sink) const {
    std::array<std::byte, ground_section::kMostRegionBytes> room;
    const auto bytes =
        std::span(room).first(ground_section::region_bytes(info_.regions, ground_.info.can_be_dug));
    ground_section::encode_regions(ground_.info, bytes);
    return put(sink, bytes);
  }

  Status put_blend_map(const ByteSink& sink) const {
    std::array<std::byte, material_section::kBlendHeaderBytes> header;
    material_section::encode_blend_header(map(), header);
    const std::size_t row = map().width * kBlendTexelBytes;
    Buffer buffer(sink);
    for (const std::byte byte : header) buffer.add(byte);
    for (std::uint32_t z = 0; z < map().depth; ++z)
      buffer.add(crc32c(world_.painted_texels().subspan(z * row, row)));
    const Status status = buffer.finish();
    return status.ok() ? put(sink, world_.painted_texels()) : status;
  }

  Status put_tiles(const ByteSink& sink) const {
    std::uint64_t left = tiles_ == nullptr ? ground_.tile_bytes : tiles_->kept;
    const auto kept = [&](std::span<const std::byte> piece) {
      piece = piece.first(static_cast<std::size_t>(std::min<std::uint64_t>(left, piece.size())));
      left -= piece.size();
      return piece.empty() || sink.write(sink.context, piece);
    };
    const Status status = reader_.copy_section(WorldSection::tiles, ByteSink::to(kept));
    return !status.ok() || tiles_ == nullptr ? status : tiles_->put(tiles_->context, sink);
  }

  Status put_section(WorldSection section, const ByteSink& sink) const {
    const auto of_part = [&](PatchId id, auto member) {
      const WorldPart& part = world_.part_of(id);
      return (part.*member)[id - part.first];
    };
    switch (section) {
      case WorldSection::octree:
        return put_octrees(sink);
      case WorldSection::keys:
        return put_each(sink, [&](PatchId id) { return key(id).bits(); });
      case WorldSection::mask:
        return put_mask(sink);
      case WorldSection::samples:
        return for_each_block([&](std::span<const std::byte> block) { return put(sink, block); });
      case WorldSection::sample_crcs:
        return put_sample_crcs(sink);
      case WorldSection::level_errors:
        return put_level_errors(sink);
      case WorldSection::bounds:
        return put_each(sink, [&](PatchId id) { return of_part(id, &WorldPart::bounds); });
      case WorldSection::cones:
        return put_each(sink, [&](PatchId id) { return of_part(id, &WorldPart::cones); });
      case WorldSection::shading_cones:
        return put_each(sink, [&](PatchId id) { return of_part(id, &WorldPart::shading_cones); });
      case WorldSection::blend_map:
        return is_copied(section) ? reader_.copy_section(section, sink) : put_blend_map(sink);
      case WorldSection::overrides:
        return put_each(sink, [&](PatchId id) { return world_.material_overrides()[id]; });
      case WorldSection::ground:
        return put_ground(sink);
      case WorldSection::region:
        return put_regions(sink);
      case WorldSection::tiles:
        return put_tiles(sink);
      case WorldSection::field:
        return field_section::encode(world_.field(), sink.context, sink.write);
      default:
        return reader_.copy_section(section, sink);
    }
  }

  const World& world_;
  const WorldReader& reader_;
  const AddedTiles* tiles_;
  std::span<PatchId> order_;
  WorldInfo info_;
  WorldGround ground_;
  bool has_overrides_ = false;
};

}  // namespace

Status SaveWorld::run(const ByteSink& sink) const {
  if (world->patch_count() > 0 && !world->holds_all_heights())
    return {StatusCode::invalid_argument, "it does not hold all its heights", "world"};
  std::size_t patches = 0;
  for (const WorldPart& part : world->parts()) patches += part.surface.patches.size();
  if (room.size() < patches) return {StatusCode::invalid_argument, "too short", "room", patches};
  Saver saver(*this, room);
  saver.count();
  return saver.run(sink);
}

}  // namespace karst::core
