// SPDX-License-Identifier: MIT
#include "terrain/file/world_reader.h"

#include <algorithm>
#include <array>

#include "terrain/base/checksum.h"
#include "terrain/file/octree_section.h"
#include "terrain/file/world_layout.h"

namespace karst::core {

using namespace world_layout;

namespace {

Status unreadable(std::uint64_t offset) {
  return {StatusCode::corrupt, "the file cannot be read", "file", offset};
}

Status wrong_length(WorldSection section) {
  return {StatusCode::invalid_argument, "the room does not fit the section",
          kSectionNames[static_cast<std::size_t>(section)]};
}

}  // namespace

Status WorldReader::open(const ByteSource& source) {
  *this = {};
  source_ = source;
  std::array<std::byte, kMostHead> bytes;
  const std::span<std::byte> head =
      std::span(bytes).first(static_cast<std::size_t>(std::min<std::uint64_t>(source.bytes, bytes.size())));
  if (!source.read(source.context, 0, head)) return unreadable(0);
  WorldInfo info;
  Table table;
  if (const Status status = read_head(head, source.bytes, info, table); !status.ok()) return status;
  for (std::size_t i = 0; i < table.count; ++i) {
    const Entry& entry = table.entries[i];
    std::array<std::byte, kWorldSectionAlignment> zeros;
    const std::span<std::byte> gap =
        std::span(zeros).first(static_cast<std::size_t>(entry.offset - entry.gap));
    if (!source.read(source.context, entry.gap, gap)) return unreadable(entry.gap);
    if (!all_zero(gap)) {
      return corrupt("bytes between sections are not 0", {"padding", static_cast<std::size_t>(entry.gap)});
    }
  }
  sections_ = table.sections;
  Status status = read_materials();
  if (status.ok()) status = read_lights();
  if (!status.ok()) {
    *this = {};
    return status;
  }
  info_ = info;
  return {};
}

Status WorldReader::read_materials() {
  const WorldSectionPlace& section = place_of(WorldSection::materials);
  if (!section.present) return {};
  std::array<std::byte, material_section::kMostBytes> room;
  const std::span<std::byte> bytes = std::span(room).first(static_cast<std::size_t>(section.bytes));
  if (const Status status = read_section(WorldSection::materials, bytes); !status.ok()) return status;
  const auto fault = material_section::decode(bytes, materials_, image_crcs_);
  if (fault.what != nullptr)
    return corrupt(fault.what, {"materials", static_cast<std::size_t>(section.offset) + fault.offset});
  const WorldSectionPlace& textures = place_of(WorldSection::textures);
  if (textures.bytes != texture_bytes(materials_)) {
    return corrupt("the section's length does not fit the materials",
                   {"textures", static_cast<std::size_t>(textures.offset)});
  }
  return {};
}

Status WorldReader::read_lights() {
  const WorldSectionPlace& section = place_of(WorldSection::lights);
  light_count_ = static_cast<std::size_t>(section.bytes) / sizeof(PointLight);
  if (!section.present) return {};
  const std::span<PointLight> lights = std::span(lights_).first(light_count_);
  if (const Status status = read_section(WorldSection::lights, std::as_writable_bytes(lights)); !status.ok())
    return status;
  const auto fault = material_section::check_lights(lights);
  if (fault.what == nullptr) return {};
  return corrupt(fault.what, {"lights", static_cast<std::size_t>(section.offset) + fault.offset});
}

bool WorldReader::has_overrides() const {
  return place_of(WorldSection::overrides).present;
}

Status WorldReader::read_overrides(std::span<std::uint8_t> overrides) const {
  if (!has_overrides()) {
    if (overrides.size() != info_.patches) return wrong_length(WorldSection::overrides);
    std::fill(overrides.begin(), overrides.end(), std::uint8_t{0});
    return {};
  }
  const Status status = read_section(WorldSection::overrides, std::as_writable_bytes(overrides));
  if (!status.ok()) return status;
  const auto fault = material_section::check_overrides(overrides, materials_.count);
  if (fault.what == nullptr) return {};
  return corrupt(
      fault.what,
      {"overrides", static_cast<std::size_t>(place_of(WorldSection::overrides).offset) + fault.offset});
}

Status WorldReader::read_textures(TextureArray array, int level, std::uint32_t first, std::uint32_t count,
                                  std::span<std::byte> out) const {
  const std::size_t image = texture_image_bytes(materials_.format, materials_.side, level);
  if (out.size() != image * count) return wrong_length(WorldSection::textures);
  const std::uint64_t start =
      place_of(WorldSection::textures).offset + texture_offset(materials_, array, level, first);
  if (!source_.read(source_.context, start, out)) return unreadable(start);
  const std::size_t index = material_section::image_index(materials_, array, level, first);
  for (std::uint32_t k = 0; k < count; ++k) {
    if (crc32c(out.subspan(k * image, image)) == image_crcs_[index + k]) continue;
    return corrupt("an image does not match its checksum",
                   {"textures", static_cast<std::size_t>(start) + k * image});
  }
  return {};
}

Status WorldReader::read_section(WorldSection section, std::span<std::byte> out) const {
  const WorldSectionPlace& place = place_of(section);
  if (out.size() != place.bytes) return wrong_length(section);
  if (!source_.read(source_.context, place.offset, out)) return unreadable(place.offset);
  if (crc32c(out) != place.crc) {
    return corrupt("a section does not match its checksum", {"section crc", place.entry + kEntryCrc});
  }
  return {};
}

std::size_t WorldReader::octree_room(std::uint32_t octets) {
  return static_cast<std::size_t>(octree_section_bytes(octets));
}

Status WorldReader::read_octree(std::span<std::byte> room, Octree& tree) const {
  if (const Status status = tree.reset(info_.depth); !status.ok()) return status;
  const std::size_t bytes = octree_room(info_.octets);
  if (room.size() < bytes) return wrong_length(WorldSection::octree);
  if (const Status status = read_section(WorldSection::octree, room.first(bytes)); !status.ok())
    return status;
  const Status status = decode_octree(room.first(bytes), info_.octets, info_.extent, tree);
  if (status.code() != StatusCode::corrupt) return status;
  const std::uint64_t offset = sections_[static_cast<std::size_t>(WorldSection::octree)].offset;
  return {status.code(), status.what(), status.field(), offset + status.value()};
}

Status WorldReader::read_mask(std::span<std::byte> mask) const {
  if (const Status status = read_section(WorldSection::mask, mask); !status.ok()) return status;
  const std::size_t at = find_mask_fault(mask, info_);
  if (at == mask.size()) return {};
  return corrupt("the mask's bits are not height_blocks of the patches",
                 {"height mask", static_cast<std::size_t>(sections_[1].offset) + at});
}

Status WorldReader::read_level_errors(std::span<std::uint16_t> values) const {
  const Status status = read_section(WorldSection::level_errors, std::as_writable_bytes(values));
  if (!status.ok()) return status;
  const std::size_t at = find_level_error_fault(info_.level, values);
  if (at == values.size()) return {};
  const std::uint64_t offset = sections_[static_cast<std::size_t>(WorldSection::level_errors)].offset;
  return corrupt("a finer level's error is larger than a coarser one's",
                 {"level errors", static_cast<std::size_t>(offset) + at * sizeof(std::uint16_t)});
}

Status WorldReader::read_bounds(std::span<PatchBounds> bounds) const {
  const Status status = read_section(WorldSection::bounds, std::as_writable_bytes(bounds));
  if (!status.ok()) return status;
  const std::size_t at = find_bounds_fault(bounds);
  if (at == bounds.size()) return {};
  const std::uint64_t offset = sections_[static_cast<std::size_t>(WorldSection::bounds)].offset;
  return corrupt("a box's minimum is above its maximum",
                 {"patch bounds", static_cast<std::size_t>(offset) + at * sizeof(PatchBounds)});
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
  const WorldSectionPlace& place = place_of(WorldSection::samples);
  const std::uint64_t whole = std::uint64_t{kHeightGroup} *
                              static_cast<std::uint64_t>(patch_vertices(info_.level)) * sizeof(std::int16_t);
  const std::uint64_t first = group * whole;
  if (first >= place.bytes || out.size_bytes() != std::min(whole, place.bytes - first))
    return wrong_length(WorldSection::samples);
  if (!source_.read(source_.context, place.offset + first, std::as_writable_bytes(out)))
    return unreadable(place.offset + first);
  if (crc32c(std::as_bytes(out)) != crc) {
    return corrupt("a group of heights does not match its checksum",
                   {"height samples", static_cast<std::size_t>(place.offset + first)});
  }
  const std::size_t at = find_sample_fault(out);
  if (at == out.size()) return {};
  return corrupt(
      "a height is beyond the largest displacement",
      {"height samples", static_cast<std::size_t>(place.offset + first) + at * sizeof(std::int16_t)});
}

}  // namespace karst::core
