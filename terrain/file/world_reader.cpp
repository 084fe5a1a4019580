// SPDX-License-Identifier: MIT
#include "terrain/file/world_reader.h"

#include <algorithm>
#include <array>
#include <utility>

#include "terrain/base/check.h"
#include "terrain/base/checksum.h"
#include "terrain/file/fields/field_section.h"
#include "terrain/file/ground_section.h"
#include "terrain/file/octree_section.h"
#include "terrain/file/world_layout.h"

namespace karst::core {

using namespace world_layout;

namespace {

// Bytes that are read at a time where nothing needs them all.
constexpr std::size_t kBuffer = 512 * SectionCheck::kPiece;

Status unreadable(std::uint64_t offset) {
  return {StatusCode::io, "the file cannot be read", "file", offset};
}

Status wrong_length(WorldSection section) {
  return {StatusCode::invalid_argument, "the room does not fit the section", kind_of(section).name};
}

}  // namespace

Status WorldReader::corrupt_section(WorldSection section, const char* what, std::uint64_t offset) const {
  return corrupt(what, {kind_of(section).name, place_of(section).offset + offset});
}

Status WorldReader::read_bytes(std::uint64_t offset, std::span<std::byte> out) const {
  return source_.read(source_.context, offset, out) ? Status() : unreadable(offset);
}

// Calls visit(bytes), which returns whether to go on, for pieces of the file.
template <class Visit>
Status WorldReader::for_each_piece(std::uint64_t offset, std::uint64_t bytes, const Visit& visit) const {
  std::array<std::byte, kBuffer> buffer;
  while (bytes > 0) {
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(bytes, buffer.size()));
    const std::span<std::byte> piece = std::span(buffer).first(count);
    if (const Status status = read_bytes(offset, piece); !status.ok()) return status;
    if (!visit(std::span<const std::byte>(piece))) return {};
    offset += count;
    bytes -= count;
  }
  return {};
}

Status WorldReader::lend(const BasisFunction& function) {
  BasisFunction& own = ground_.info.basis.function;
  const double turn_rad = own.turn_rad, sagitta_m = own.sagitta_m;
  own = function;
  own.turn_rad = turn_rad;
  own.sagitta_m = sagitta_m;
  return ground_.info.basis.finish();
}

Status WorldReader::open(const ByteSource& source) {
  *this = {};
  source_ = source;
  std::array<std::byte, kMostHead> bytes;
  const std::span<std::byte> head =
      std::span(bytes).first(static_cast<std::size_t>(std::min<std::uint64_t>(source.bytes, bytes.size())));
  WorldInfo info;
  Status status = read_bytes(0, head);
  if (status.ok()) status = read_head(head, source.bytes, info, table_);
  for (std::size_t i = 0; status.ok() && i < table_.count; ++i) {
    const Entry& entry = table_.entries[i];
    std::array<std::byte, kWorldSectionAlignment> room;
    const std::span<std::byte> gap =
        std::span(room).first(static_cast<std::size_t>(entry.offset - entry.gap));
    status = read_bytes(entry.gap, gap);
    if (status.ok() && !all_zero(gap))
      status = corrupt("bytes between sections are not 0", {"padding", entry.gap});
  }
  if (status.ok()) status = read_materials();
  if (status.ok()) status = read_blend_map();
  if (status.ok()) status = read_lights();
  if (status.ok()) status = read_surroundings(info.extent);
  if (status.ok()) status = read_ground(info.voxel_size_m);
  if (status.ok()) status = read_regions(info);
  if (status.ok()) status = read_field_header();
  if (status.ok()) status = check_field_region();
  if (!status.ok()) {
    *this = {};
    return status;
  }
  info_ = info;
  head_crc_ = load<std::uint32_t>(head, kHeaderCrc.offset);
  return {};
}

Status WorldReader::go_on(const ByteSource& source) {
  const auto other = [] {
    return Status(StatusCode::invalid_argument, "not the file whose head was read", "file");
  };
  if (source.bytes != source_.bytes) return other();
  source_ = source;
  std::uint32_t crc = 0;
  const Status status = read_bytes(kHeaderCrc.offset, std::as_writable_bytes(std::span(&crc, 1)));
  if (!status.ok()) return status;
  return crc == head_crc_ ? Status() : other();
}

Status WorldReader::read_materials() {
  const SectionPlace& section = place_of(WorldSection::materials);
  if (!section.present) return {};
  std::array<std::byte, material_section::kMostBytes> room;
  const std::span<std::byte> bytes = std::span(room).first(static_cast<std::size_t>(section.bytes));
  if (const Status status = read_section(WorldSection::materials, bytes); !status.ok()) return status;
  const auto fault = material_section::decode(bytes, materials_, image_crcs_);
  if (fault.what != nullptr) return corrupt_section(WorldSection::materials, fault.what, fault.offset);
  if (place_of(WorldSection::textures).bytes == texture_bytes(materials_)) return {};
  return corrupt_section(WorldSection::textures, "the section's length does not fit the materials", 0);
}

// Its header: what follows has checksums of its own.
Status WorldReader::read_blend_map() {
  const SectionPlace& section = place_of(WorldSection::blend_map);
  if (!section.present) return {};
  std::array<std::byte, material_section::kBlendHeaderBytes> header;
  if (const Status status = read_bytes(section.offset, header); !status.ok()) return status;
  const auto fault = material_section::decode_blend_map(header, materials_.count, materials_.blend_map);
  if (fault.what != nullptr) return corrupt_section(WorldSection::blend_map, fault.what, fault.offset);
  if (section.bytes == material_section::blend_section_bytes(materials_.blend_map)) return {};
  return corrupt_section(WorldSection::blend_map, "the section's length does not fit its texels", 0);
}

Status WorldReader::read_blend_rows(std::uint32_t first, std::uint32_t count,
                                    std::span<std::byte> out) const {
  const BlendMap& map = materials_.blend_map;
  KARST_ASSERT(first <= map.depth && count <= map.depth - first);
  const std::size_t row = map.width * kBlendTexelBytes;
  if (out.size() != row * count) return wrong_length(WorldSection::blend_map);
  const std::uint64_t crcs = material_section::kBlendHeaderBytes;
  const std::uint64_t rows = crcs + map.depth * sizeof(std::uint32_t) + std::uint64_t{first} * row;
  const std::uint64_t start = place_of(WorldSection::blend_map).offset;
  if (const Status status = read_bytes(start + rows, out); !status.ok()) return status;
  for (std::uint32_t k = 0; k < count; ++k) {
    std::uint32_t stated = 0;
    const std::uint64_t at = crcs + (first + k) * sizeof stated;
    const Status status = read_bytes(start + at, std::as_writable_bytes(std::span(&stated, 1)));
    if (!status.ok()) return status;
    if (crc32c(out.subspan(k * row, row)) == stated) continue;
    return corrupt_section(WorldSection::blend_map, "a row does not match its checksum", rows + k * row);
  }
  return {};
}

Status WorldReader::verify_blend_rows() const {
  std::array<std::byte, kMostBlendSide * kBlendTexelBytes> room;
  const BlendMap& map = materials_.blend_map;
  for (std::uint32_t row = 0; row < map.depth; ++row) {
    const Status status = read_blend_rows(row, 1, std::span(room).first(map.width * kBlendTexelBytes));
    if (!status.ok()) return status;
  }
  return {};
}

Status WorldReader::read_lights() {
  const SectionPlace& section = place_of(WorldSection::lights);
  light_count_ = static_cast<std::size_t>(section.bytes) / sizeof(PointLight);
  if (!section.present) return {};
  const std::span<PointLight> lights = std::span(lights_).first(light_count_);
  if (const Status status = read_section(WorldSection::lights, std::as_writable_bytes(lights)); !status.ok())
    return status;
  const auto fault = material_section::check_lights(lights);
  return fault.what == nullptr ? Status() : corrupt_section(WorldSection::lights, fault.what, fault.offset);
}

// Its head, and all of its points against their ranges: verify() and read_rim() have the checksum.
Status WorldReader::read_surroundings(glm::ivec3 extent) {
  const SectionPlace& section = place_of(WorldSection::surroundings);
  if (!section.present) return {};
  const auto head = std::as_writable_bytes(std::span(&surroundings_, 1));
  if (const Status status = read_bytes(section.offset, head); !status.ok()) return status;
  const auto fault = material_section::check_surroundings(surroundings_, extent);
  if (fault.what != nullptr) return corrupt_section(WorldSection::surroundings, fault.what, fault.offset);
  if (section.bytes == head.size() + surroundings_.rim_points * kRimPointBytes) return {};
  return corrupt_section(WorldSection::surroundings, "the section's length does not fit its points", 12);
}

Status WorldReader::read_ground(double voxel_m) {
  if (!place_of(WorldSection::ground).present) return {};
  std::array<std::byte, ground_section::kMostBytes> room;
  const auto bytes = std::span(room).first(static_cast<std::size_t>(place_of(WorldSection::ground).bytes));
  if (const Status status = read_section(WorldSection::ground, bytes); !status.ok()) return status;
  const SectionPlace& tiles = place_of(WorldSection::tiles);
  ground_.tile_crc = tiles.crc;
  const auto fault = ground_section::decode(bytes, tiles.bytes, voxel_m, ground_);
  if (fault.what != nullptr) return corrupt_section(WorldSection::ground, fault.what, fault.offset);
  return read_imagery();
}

Status WorldReader::read_imagery() {
  if (!place_of(WorldSection::imagery).present) return {};
  std::array<std::byte, ground_section::kImageryBytes> bytes;
  if (const Status status = read_section(WorldSection::imagery, bytes); !status.ok()) return status;
  const auto fault = ground_section::decode_imagery(bytes, ground_);
  if (fault.what == nullptr) return {};
  return corrupt_section(WorldSection::imagery, fault.what, fault.offset);
}

Status WorldReader::read_regions(const WorldInfo& info) {
  if (!ground_.info.exists()) return {};
  std::array<std::byte, ground_section::kMostRegionBytes> room;
  std::span<std::byte> bytes;
  if (place_of(WorldSection::region).present) {
    bytes = std::span(room).first(ground_section::region_bytes(info.regions, ground_.info.can_be_dug));
    if (place_of(WorldSection::region).bytes != bytes.size())
      return corrupt_section(WorldSection::region, "it has another number of bytes than its regions take", 0);
    if (const Status status = read_section(WorldSection::region, bytes); !status.ok()) return status;
  }
  const auto fault = ground_section::decode_regions(bytes, info, ground_.info);
  return fault.what == nullptr ? Status() : corrupt_section(WorldSection::region, fault.what, fault.offset);
}

// Without its checksum, which is of all of it.
Status WorldReader::read_field_header() {
  const SectionPlace& section = place_of(WorldSection::field);
  if (!section.present) return {};
  std::array<std::byte, field_section::kHeaderBytes> header;
  if (const Status status = read_bytes(section.offset, header); !status.ok()) return status;
  const auto fault = field_section::decode_header(header, field_);
  if (fault.what != nullptr) return corrupt_section(WorldSection::field, fault.what, fault.offset);
  if (section.bytes == field_section::section_bytes(field_)) return {};
  return corrupt_section(WorldSection::field, "the section's length does not fit its blocks", 0);
}

// A region without patches is the field's, whose sides are the region's.
Status WorldReader::check_field_region() {
  const GroundInfo& ground = ground_.info;
  const GroundRegion* found = nullptr;
  for (const GroundRegion& region : ground.regions()) {
    if (!region.is_field()) continue;
    if (found != nullptr)
      return corrupt_section(WorldSection::region, "two regions have no patches, and there is one field", 0);
    found = &region;
  }
  if (found == nullptr) return {};
  if (!field_.exists())
    return corrupt_section(WorldSection::region, "there is a region, but no patches and no field", 0);
  field_.in_region = true;
  const glm::ivec3 drawn = field_.drawn_steps();
  const auto width = [&](int axis) { return std::int64_t{found->extent[axis] - 1} * kStepsPerVoxel; };
  if (field_.corner != glm::ivec3(0) || drawn.x != width(0) || drawn.z != width(2) ||
      drawn.y > std::int64_t{found->extent.y} * kStepsPerVoxel + (std::int64_t{16} << field_.cell_log2))
    return corrupt_section(WorldSection::field, "its blocks do not fill its region", 0);
  return {};
}

Status WorldReader::decode_field(FieldBlocks* out) const {
  const SectionPlace& section = place_of(WorldSection::field);
  field_section::Decode decode(field_, materials().count, out);
  field_section::Fault fault;
  std::uint32_t crc = 0;
  std::size_t skip = field_section::kHeaderBytes;
  const Status status = for_each_piece(section.offset, section.bytes, [&](std::span<const std::byte> piece) {
    crc = crc32c(piece, crc);
    fault = decode.feed(piece.subspan(std::exchange(skip, 0)));
    return fault.what == nullptr;
  });
  if (!status.ok()) return status;
  if (fault.what == nullptr) fault = decode.finish();
  if (fault.what != nullptr) return corrupt_section(WorldSection::field, fault.what, fault.offset);
  if (crc == section.crc) return {};
  return corrupt("a section does not match its checksum", {"section crc", section.entry + kEntryCrc});
}

Status WorldReader::read_field(FieldBlocks& out) const {
  KARST_ASSERT(field_.exists());
  Status status = out.reset(field_);
  if (status.ok()) status = decode_field(&out);
  if (!status.ok()) out.clear();
  return status;
}

Status WorldReader::read_tile(const TilePlace& place, std::span<std::byte> out) const {
  const SectionPlace& tiles = place_of(WorldSection::tiles);
  if (place.offset > tiles.bytes || place.bytes > tiles.bytes - place.offset)
    return corrupt_section(WorldSection::tiles, "a tile does not lie in the section", 0);
  if (out.size() != place.bytes) return wrong_length(WorldSection::tiles);
  return read_bytes(tiles.offset + place.offset, out);
}

Status WorldReader::read_rim(std::span<glm::ivec3> rim) const {
  const SectionPlace& section = place_of(WorldSection::surroundings);
  if (rim.size() != surroundings_.rim_points) return wrong_length(WorldSection::surroundings);
  if (rim.empty()) return {};
  const auto bytes = std::as_writable_bytes(rim);
  if (const Status status = read_bytes(section.offset + sizeof(Surroundings), bytes); !status.ok())
    return status;
  if (crc32c(bytes, crc32c(std::as_bytes(std::span(&surroundings_, 1)))) != section.crc)
    return corrupt("a section does not match its checksum", {"section crc", section.entry + kEntryCrc});
  const auto fault = material_section::check_rim(bytes);
  return fault.what == nullptr ? Status()
                               : corrupt_section(WorldSection::surroundings, fault.what, fault.offset);
}

bool WorldReader::has_overrides() const {
  return place_of(WorldSection::overrides).present;
}

Status WorldReader::verify() const {
  for (std::size_t i = 0; i < table_.count; ++i) {
    const Entry& entry = table_.entries[i];
    std::uint32_t crc = 0;
    const Status status = for_each_piece(entry.offset, entry.bytes, [&](std::span<const std::byte> piece) {
      crc = crc32c(piece, crc);
      return true;
    });
    if (!status.ok()) return status;
    if (crc != entry.crc)
      return corrupt("a section does not match its checksum", {"section crc", entry.at + kEntryCrc});
  }
  for (std::size_t i = 0; i < kWorldSectionKinds; ++i) {
    if (const Status status = verify_section(static_cast<WorldSection>(i)); !status.ok()) return status;
  }
  if (const Status status = verify_groups(); !status.ok()) return status;
  if (const Status status = verify_rim(); !status.ok()) return status;
  if (field_.exists()) {
    if (const Status status = decode_field(nullptr); !status.ok()) return status;
  }
  if (const Status status = verify_blend_rows(); !status.ok()) return status;
  return verify_images();
}

Status WorldReader::copy_section(WorldSection section, const ByteSink& sink) const {
  const SectionPlace& place = place_of(section);
  std::uint32_t crc = 0;
  bool taken = true;
  const Status status = for_each_piece(place.offset, place.bytes, [&](std::span<const std::byte> piece) {
    crc = crc32c(piece, crc);
    taken = sink.write(sink.context, piece);
    return taken;
  });
  if (!status.ok()) return status;
  if (!taken) return {StatusCode::limit_reached, "the bytes cannot be written", "sink"};
  if (crc == place.crc) return {};
  return corrupt("a section does not match its checksum", {"section crc", place.entry + kEntryCrc});
}

Status WorldReader::verify_rim() const {
  const std::uint64_t first = place_of(WorldSection::surroundings).offset + sizeof(Surroundings);
  material_section::Fault fault;
  std::uint64_t at = 0;
  const auto check = [&](std::span<const std::byte> piece) {
    fault = material_section::check_rim(piece);
    fault.offset += at;
    at += piece.size();
    return fault.what == nullptr;
  };
  const Status status = for_each_piece(first, surroundings_.rim_points * kRimPointBytes, check);
  if (!status.ok() || fault.what == nullptr) return status;
  return corrupt_section(WorldSection::surroundings, fault.what, fault.offset);
}

Status WorldReader::verify_section(WorldSection section) const {
  const SectionPlace& place = place_of(section);
  SectionCheck check(section, info_, materials_.count);
  SectionFault fault;
  const Status status = for_each_piece(place.offset, place.bytes, [&](std::span<const std::byte> piece) {
    fault = check.feed(piece);
    return fault.what == nullptr;
  });
  if (!status.ok()) return status;
  if (fault.what == nullptr && place.present) fault = check.finish();
  return fault.what == nullptr ? Status() : corrupt_section(section, fault.what, fault.offset);
}

Status WorldReader::verify_groups() const {
  const SectionPlace& samples = place_of(WorldSection::samples);
  const SectionPlace& crcs = place_of(WorldSection::sample_crcs);
  const std::uint64_t whole = std::uint64_t{kHeightGroup} *
                              static_cast<std::uint64_t>(patch_vertices(info_.level)) * sizeof(std::int16_t);
  for (std::uint64_t first = 0, at = 0; first < samples.bytes; first += whole, at += sizeof(std::uint32_t)) {
    std::uint32_t stated = 0;
    std::uint32_t crc = 0;
    Status status = read_bytes(crcs.offset + at, std::as_writable_bytes(std::span(&stated, 1)));
    if (!status.ok()) return status;
    status = for_each_piece(samples.offset + first, std::min(whole, samples.bytes - first),
                            [&](std::span<const std::byte> piece) {
                              crc = crc32c(piece, crc);
                              return true;
                            });
    if (!status.ok()) return status;
    if (crc != stated) {
      return corrupt_section(WorldSection::sample_crcs, "a group of heights does not match its checksum", at);
    }
  }
  return {};
}

Status WorldReader::verify_images() const {
  const std::uint64_t start = place_of(WorldSection::textures).offset;
  for (std::size_t image = 0; image < material_section::image_count(materials_); ++image) {
    const std::uint64_t first = material_section::image_offset(materials_, image);
    std::uint32_t crc = 0;
    const Status status =
        for_each_piece(start + first, material_section::image_offset(materials_, image + 1) - first,
                       [&](std::span<const std::byte> piece) {
                         crc = crc32c(piece, crc);
                         return true;
                       });
    if (!status.ok()) return status;
    if (crc != image_crcs_[image])
      return corrupt_section(WorldSection::textures, "an image does not match its checksum", first);
  }
  return {};
}

Status WorldReader::read_overrides(std::span<std::uint8_t> overrides) const {
  if (has_overrides()) return read_checked(WorldSection::overrides, std::as_writable_bytes(overrides));
  if (overrides.size() != info_.patches) return wrong_length(WorldSection::overrides);
  std::fill(overrides.begin(), overrides.end(), std::uint8_t{0});
  return {};
}

Status WorldReader::read_textures(TextureArray array, int level, std::uint32_t first, std::uint32_t count,
                                  std::span<std::byte> out) const {
  KARST_ASSERT(level >= 0 && level < texture_levels(materials_.side, array));
  KARST_ASSERT(first <= materials_.count && count <= materials_.count - first);
  const std::size_t image = texture_image_bytes(materials_.format, materials_.side, array, level);
  if (out.size() != image * count) return wrong_length(WorldSection::textures);
  const std::uint64_t start = texture_offset(materials_, array, level, first);
  if (const Status status = read_bytes(place_of(WorldSection::textures).offset + start, out); !status.ok())
    return status;
  const std::size_t index = material_section::image_index(materials_, array, level, first);
  for (std::uint32_t k = 0; k < count; ++k) {
    if (crc32c(out.subspan(k * image, image)) == image_crcs_[index + k]) continue;
    return corrupt_section(WorldSection::textures, "an image does not match its checksum", start + k * image);
  }
  return {};
}

Status WorldReader::read_section(WorldSection section, std::span<std::byte> out) const {
  const SectionPlace& place = place_of(section);
  if (out.size() != place.bytes) return wrong_length(section);
  if (const Status status = read_bytes(place.offset, out); !status.ok()) return status;
  if (crc32c(out) == place.crc) return {};
  return corrupt("a section does not match its checksum", {"section crc", place.entry + kEntryCrc});
}

Status WorldReader::read_checked(WorldSection section, std::span<std::byte> out) const {
  if (const Status status = read_section(section, out); !status.ok()) return status;
  SectionCheck check(section, info_, materials_.count);
  SectionFault fault = check.feed(out);
  if (fault.what == nullptr) fault = check.finish();
  return fault.what == nullptr ? Status() : corrupt_section(section, fault.what, fault.offset);
}

std::size_t WorldReader::octree_room(std::uint32_t octets, std::uint32_t trees) {
  return static_cast<std::size_t>(octree_section_bytes(octets, trees));
}

Status WorldReader::read_octrees(std::span<std::byte> room, std::span<Octree> trees) const {
  KARST_ASSERT(trees.size() == info_.regions);
  const bool one = info_.regions == 1;
  const std::span<const GroundRegion> regions = ground_.info.regions();
  for (std::size_t n = 0; n < trees.size(); ++n) {
    if (const Status status = trees[n].reset(one ? info_.depth : regions[n].depth); !status.ok())
      return status;
  }
  const std::size_t bytes = octree_room(info_.octets, info_.regions);
  if (room.size() < bytes) return wrong_length(WorldSection::octree);
  if (const Status status = read_section(WorldSection::octree, room.first(bytes)); !status.ok())
    return status;
  std::size_t at = 0;
  for (std::size_t n = 0; n < trees.size(); ++n) {
    const std::uint32_t octets = one ? info_.octets : regions[n].octets;
    const std::size_t length = octree_room(octets);
    const Status status =
        decode_octree(room.subspan(at, length), octets, one ? info_.extent : regions[n].extent, trees[n]);
    if (status.code() == StatusCode::corrupt) {
      return {status.code(), status.what(), status.field(),
              place_of(WorldSection::octree).offset + at + status.value()};
    }
    if (!status.ok()) return status;
    at += length;
  }
  return {};
}

Status WorldReader::read_keys(std::span<PatchKey> keys) const {
  return read_checked(WorldSection::keys, std::as_writable_bytes(keys));
}

Status WorldReader::match_keys(std::span<const Surface> surfaces) const {
  const SectionPlace& place = place_of(WorldSection::keys);
  constexpr const char* kOthers = "the world's patches are not those that its voxels make";
  SectionCheck check(WorldSection::keys, info_, 0);
  SectionFault fault;
  std::uint32_t crc = 0;
  std::size_t patch = 0, first = 0, region = 0;  // first: of the region
  const auto next_region = [&] {
    while (region < surfaces.size() && patch - first == surfaces[region].patches.size()) {
      first = patch;
      ++region;
    }
  };
  const Status status = for_each_piece(place.offset, place.bytes, [&](std::span<const std::byte> piece) {
    crc = crc32c(piece, crc);
    if (fault.what == nullptr) fault = check.feed(piece);
    for (std::size_t at = 0; fault.what == nullptr && at < piece.size(); at += sizeof(PatchKey), ++patch) {
      const auto bits = load<std::uint64_t>(piece, at);
      next_region();
      const bool same =
          region < surfaces.size() &&
          key_of(surfaces[region], static_cast<PatchId>(patch - first), static_cast<std::uint32_t>(region))
                  .bits() == bits;
      if (!same) fault = {kOthers, patch * sizeof(PatchKey)};
    }
    return true;
  });
  if (!status.ok()) return status;
  if (crc != place.crc)
    return corrupt("a section does not match its checksum", {"section crc", place.entry + kEntryCrc});
  if (fault.what == nullptr) fault = check.finish();
  next_region();
  if (fault.what == nullptr && region != surfaces.size()) fault = {kOthers, place.bytes};
  return fault.what == nullptr ? Status() : corrupt_section(WorldSection::keys, fault.what, fault.offset);
}

Status WorldReader::read_mask(std::span<std::byte> mask) const {
  return read_checked(WorldSection::mask, mask);
}

Status WorldReader::read_level_errors(std::span<std::uint16_t> values) const {
  return read_checked(WorldSection::level_errors, std::as_writable_bytes(values));
}

Status WorldReader::read_bounds(std::span<PatchBounds> bounds) const {
  return read_checked(WorldSection::bounds, std::as_writable_bytes(bounds));
}

Status WorldReader::read_cones(std::span<NormalCone> cones) const {
  return read_section(WorldSection::cones, std::as_writable_bytes(cones));
}

Status WorldReader::read_shading_cones(std::span<NormalCone> cones) const {
  return read_section(WorldSection::shading_cones, std::as_writable_bytes(cones));
}

Status WorldReader::read_height_crcs(std::span<std::uint32_t> crcs) const {
  return read_section(WorldSection::sample_crcs, std::as_writable_bytes(crcs));
}

Status WorldReader::read_heights(std::uint32_t group, std::uint32_t crc, std::span<std::int16_t> out) const {
  const SectionPlace& place = place_of(WorldSection::samples);
  const std::uint64_t whole = std::uint64_t{kHeightGroup} *
                              static_cast<std::uint64_t>(patch_vertices(info_.level)) * sizeof(std::int16_t);
  const std::uint64_t first = group * whole;
  if (first >= place.bytes || out.size_bytes() != std::min(whole, place.bytes - first))
    return wrong_length(WorldSection::samples);
  const std::span<std::byte> bytes = std::as_writable_bytes(out);
  if (const Status status = read_bytes(place.offset + first, bytes); !status.ok()) return status;
  if (crc32c(bytes) != crc)
    return corrupt_section(WorldSection::samples, "a group of heights does not match its checksum", first);
  SectionCheck check(WorldSection::samples, info_, 0);
  const SectionFault fault = check.feed(bytes);
  if (fault.what == nullptr) return {};
  return corrupt_section(WorldSection::samples, fault.what, first + fault.offset);
}

}  // namespace karst::core
