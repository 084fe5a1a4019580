// SPDX-License-Identifier: MIT
#include "terrain/file/world_writer.h"

#include "terrain/base/checksum.h"
#include "terrain/file/fields/field_section.h"
#include "terrain/file/ground_section.h"
#include "terrain/file/materials/material_section.h"
#include "terrain/file/octree_section.h"
#include "terrain/file/world_layout.h"

#include <algorithm>
#include <array>

namespace karst::core {

using namespace world_layout;

namespace {

Status invalid(const char* what, const char* field) {
  return {StatusCode::invalid_argument, what, field};
}

Status put(const ByteSink& sink, std::span<const std::byte> bytes) {
  if (bytes.empty() || sink.write(sink.context, bytes)) return {};
  return {StatusCode::limit_reached, "the bytes cannot be written", "sink"};
}

Status put_zeros(const ByteSink& sink, std::uint64_t count) {
  static constexpr std::array<std::byte, kWorldSectionAlignment> kZeros{};
  return put(sink, std::span(kZeros).first(static_cast<std::size_t>(count)));
}

// Of eight blocks in a row each; the last group may be shorter.
Status put_group_crcs(const ByteSink& sink, std::span<const std::int16_t> samples, int level) {
  const std::size_t whole = std::size_t{kHeightGroup} * static_cast<std::size_t>(patch_vertices(level));
  while (!samples.empty()) {
    const std::span<const std::int16_t> group = samples.first(std::min(samples.size(), whole));
    const std::uint32_t crc = crc32c(std::as_bytes(group));
    if (const Status status = put(sink, std::as_bytes(std::span(&crc, 1))); !status.ok()) return status;
    samples = samples.subspan(group.size());
  }
  return {};
}

// Of worlds whose shading cones are not known.
Status put_unknown_cones(const ByteSink& sink, std::size_t count) {
  constexpr std::size_t kPiece = 64;
  const std::array<NormalCone, kPiece> cones{};
  for (; count > 0; count -= std::min(count, kPiece)) {
    const Status status = put(sink, std::as_bytes(std::span(cones).first(std::min(count, kPiece))));
    if (!status.ok()) return status;
  }
  return {};
}

Status put_material_set(const ByteSink& sink, const WorldMaterials& materials) {
  std::array<std::byte, material_section::kMostBytes> room;
  const std::span<std::byte> bytes = std::span(room).first(material_section::section_bytes(materials.set));
  material_section::encode(materials.set, materials.textures, bytes);
  return put(sink, bytes);
}

Status put_surroundings(const ByteSink& sink, const WorldMaterials& materials) {
  const Status status = put(sink, std::as_bytes(std::span(&materials.surroundings, 1)));
  return status.ok() ? put(sink, std::as_bytes(materials.rim)) : status;
}

Status put_blend_map(const ByteSink& sink, const WorldMaterials& materials) {
  const BlendMap& map = materials.set.blend_map;
  std::array<std::byte, material_section::kBlendHeaderBytes> header;
  material_section::encode_blend_header(map, header);
  Status status = put(sink, header);
  const std::size_t row = map.width * kBlendTexelBytes;
  for (std::uint32_t k = 0; status.ok() && k < map.depth; ++k) {
    const std::uint32_t crc = crc32c(materials.blend_map.subspan(k * row, row));
    status = put(sink, std::as_bytes(std::span(&crc, 1)));
  }
  return status.ok() ? put(sink, materials.blend_map) : status;
}

Status put_ground(const ByteSink& sink, const WorldGround& ground) {
  std::array<std::byte, ground_section::kMostBytes> room;
  const auto bytes = std::span(room).first(ground_section::section_bytes(ground));
  ground_section::encode(ground, bytes);
  return put(sink, bytes);
}

Status put_region(const ByteSink& sink, const WorldGround& ground) {
  std::array<std::byte, ground_section::kMostRegionBytes> room;
  const auto bytes = std::span(room).first(
      ground_section::region_bytes(ground.info.regions().size(), ground.info.can_be_dug));
  ground_section::encode_regions(ground.info, bytes);
  return put(sink, bytes);
}

Status put_imagery(const ByteSink& sink, const WorldGround& ground) {
  std::array<std::byte, ground_section::kImageryBytes> bytes;
  ground_section::encode_imagery(ground, bytes);
  return put(sink, bytes);
}

std::span<const std::byte> bytes_of(WorldSection section, const WorldPatches& patches,
                                    const WorldMaterials& materials) {
  switch (section) {
    case WorldSection::keys:
      return std::as_bytes(patches.keys);
    case WorldSection::mask:
      return patches.mask;
    case WorldSection::samples:
      return std::as_bytes(patches.samples);
    case WorldSection::level_errors:
      return std::as_bytes(patches.level_errors);
    case WorldSection::bounds:
      return std::as_bytes(patches.bounds);
    case WorldSection::cones:
      return std::as_bytes(patches.cones);
    case WorldSection::shading_cones:
      return std::as_bytes(patches.shading_cones);
    case WorldSection::textures:
      return materials.textures;
    case WorldSection::overrides:
      return std::as_bytes(materials.overrides);
    case WorldSection::lights:
      return std::as_bytes(materials.lights);
    default:
      return {};
  }
}

Status put_octrees(const WorldWriter& world, const ByteSink& sink) {
  if (world.octrees.empty()) return encode_octree(*world.octree, world.info.octets, world.info.extent, sink);
  for (std::size_t n = 0; n < world.octrees.size(); ++n) {
    const GroundRegion& region = world.ground.info.regions()[n];
    const Status status = encode_octree(*world.octrees[n], region.octets, region.extent, sink);
    if (!status.ok()) return status;
  }
  return {};
}

Status put_section(const WorldWriter& world, WorldSection section, const ByteSink& sink) {
  switch (section) {
    case WorldSection::octree:
      return put_octrees(world, sink);
    case WorldSection::sample_crcs:
      return put_group_crcs(sink, world.patches.samples, world.info.level);
    case WorldSection::shading_cones:
      if (world.patches.shading_cones.empty()) return put_unknown_cones(sink, world.info.patches);
      break;
    case WorldSection::materials:
      return put_material_set(sink, world.materials);
    case WorldSection::surroundings:
      return put_surroundings(sink, world.materials);
    case WorldSection::blend_map:
      return put_blend_map(sink, world.materials);
    case WorldSection::ground:
      return put_ground(sink, world.ground);
    case WorldSection::region:
      return put_region(sink, world.ground);
    case WorldSection::imagery:
      return put_imagery(sink, world.ground);
    case WorldSection::field:
      return field_section::encode(*world.field, sink.context, sink.write);
    default:
      break;
  }
  return put(sink, bytes_of(section, world.patches, world.materials));
}

Status checksum(const WorldWriter& world, WorldSection section, std::uint32_t& crc) {
  crc = 0;
  const auto add = [&](std::span<const std::byte> bytes) {
    crc = crc32c(bytes, crc);
    return true;
  };
  return put_section(world, section, ByteSink::to(add));
}

Status check_patches(const WorldInfo& info, const WorldPatches& patches) {
  struct Named {
    WorldSection section;
    const char* field;
  };
  static constexpr Named kSectionFields[] = {
      {WorldSection::keys, "keys"},
      {WorldSection::mask, "mask"},
      {WorldSection::samples, "samples"},
      {WorldSection::level_errors, "level_errors"},
      {WorldSection::bounds, "bounds"},
      {WorldSection::cones, "cones"},
      {WorldSection::shading_cones, "shading_cones"},
  };
  for (const Named& named : kSectionFields) {
    const std::span<const std::byte> bytes = bytes_of(named.section, patches, WorldMaterials());
    const bool unknown = named.section == WorldSection::shading_cones && bytes.empty();
    if (!unknown && bytes.size() != kind_of(named.section).bytes(info))
      return invalid("not as long as the counts of the world say", named.field);
    SectionCheck check(named.section, info, 0);
    SectionFault fault = check.feed(bytes);
    if (fault.what == nullptr) fault = check.finish();
    if (fault.what != nullptr) return invalid(fault.what, named.field);
  }
  return {};
}

Status check_materials(const WorldInfo& info, const WorldMaterials& materials) {
  if (const auto fault = material_section::check_set(materials.set); fault.what != nullptr)
    return invalid(fault.what, "materials");
  if (materials.textures.size() != texture_bytes(materials.set))
    return invalid("the textures do not fit the materials", "textures");
  const BlendMap& map = materials.set.blend_map;
  if (const auto fault = material_section::check_blend_map(map, materials.set.count); fault.what != nullptr)
    return invalid(fault.what, "blend_map");
  if (materials.blend_map.size() != std::size_t{map.width} * map.depth * kBlendTexelBytes)
    return invalid("the texels do not fit the map's size", "blend_map");
  if (!materials.overrides.empty() && materials.set.count == 0)
    return invalid("there are no materials to choose from", "overrides");
  if (!materials.overrides.empty() && materials.overrides.size() != info.patches)
    return invalid("the overrides do not fit the patches", "overrides");
  SectionCheck overrides(WorldSection::overrides, info, materials.set.count);
  if (const SectionFault fault = overrides.feed(std::as_bytes(materials.overrides)); fault.what != nullptr)
    return invalid(fault.what, "overrides");
  if (const auto fault = material_section::check_lights(materials.lights); fault.what != nullptr)
    return invalid(fault.what, "lights");
  if (const auto fault = material_section::check_surroundings(materials.surroundings, info.extent);
      fault.what != nullptr)
    return invalid(fault.what, "surroundings");
  if (materials.rim.size() != materials.surroundings.rim_points)
    return invalid("not as many points as stated", "rim");
  if (const auto fault = material_section::check_rim(std::as_bytes(materials.rim)); fault.what != nullptr)
    return invalid(fault.what, "rim");
  return {};
}

}  // namespace

Status WorldWriter::validate() const {
  if (const Status status = validate_world_info(info); !status.ok()) return status;
  if (const Status status = check_octrees(); !status.ok()) return status;
  if (const Status status = check_patches(info, patches); !status.ok()) return status;
  if (ground.info.exists()) {
    if (const auto fault = ground_section::check(ground); fault.what != nullptr)
      return invalid(fault.what, "ground");
    if (const auto fault = ground_section::check_regions(info, ground.info); fault.what != nullptr)
      return invalid(fault.what, "region");
    const bool has_field = field != nullptr && field->exists();
    for (const GroundRegion& region : ground.info.regions()) {
      if (region.is_field() && !has_field) return invalid("there is a region, but no patches", "region");
    }
    const auto of_imagery =
        ground.imagery.exists() ? ground_section::check_imagery(ground) : ground_section::Fault();
    if (of_imagery.what != nullptr) return invalid(of_imagery.what, "imagery");
  }
  return check_materials(info, materials);
}

Status WorldWriter::check_octrees() const {
  if (octrees.empty()) {
    if (octree == nullptr) return invalid("no octree given", "octree");
    if (octree->depth() != info.depth) return invalid("the octree has another depth", "depth");
    return info.regions == 1 ? Status() : invalid("not as many as regions", "octrees");
  }
  if (octrees.size() != info.regions || octrees.size() != ground.info.regions().size())
    return invalid("not as many as regions", "octrees");
  for (std::size_t n = 0; n < octrees.size(); ++n) {
    if (octrees[n] == nullptr) return invalid("no octree given", "octrees");
    if (octrees[n]->depth() != ground.info.regions()[n].depth)
      return invalid("the octree has another depth", "depth");
  }
  return {};
}

std::uint64_t WorldWriter::field_bytes() const {
  if (field == nullptr || !field->exists()) return 0;
  return field_section::section_bytes(field_section::info_of(*field));
}

std::uint64_t WorldWriter::file_bytes() const {
  SectionPlaces places;
  return lay_out(info, materials, ground, field_bytes(), places);
}

std::uint64_t WorldWriter::tiles_begin() const {
  SectionPlaces places;
  lay_out(info, materials, ground, field_bytes(), places);
  return places[static_cast<std::size_t>(WorldSection::tiles)].offset;
}

Status WorldWriter::run(const ByteSink& sink) const {
  if (ground.info.exists()) return invalid("tiles are not written here", "ground");
  return put_all(sink, sink);
}

Status WorldWriter::run_around(const ByteSink& head, const ByteSink& tail) const {
  if (!ground.info.exists()) return invalid("there is none", "ground");
  return put_all(head, tail);
}

Status WorldWriter::put_all(const ByteSink& head, const ByteSink& tail) const {
  if (const Status status = validate(); !status.ok()) return status;
  SectionPlaces places;
  const std::uint64_t bytes = lay_out(info, materials, ground, field_bytes(), places);
  const auto place_of = [&](WorldSection s) -> SectionPlace& { return places[static_cast<std::size_t>(s)]; };
  for (const WorldSection section : writing_order()) {
    if (!place_of(section).present) continue;
    if (section == WorldSection::tiles) {
      place_of(section).crc = ground.tile_crc;
      continue;
    }
    const Status status = checksum(*this, section, place_of(section).crc);
    if (!status.ok()) return status;
  }
  std::array<std::byte, kMostHead> room;
  std::uint64_t end = store_head(info, places, bytes, room);
  if (const Status status = put(head, std::span(room).first(static_cast<std::size_t>(end))); !status.ok())
    return status;
  for (const WorldSection section : writing_order()) {
    const SectionPlace& place = place_of(section);
    if (!place.present) continue;
    const bool is_tiles = section == WorldSection::tiles;
    Status status = put_zeros(is_tiles ? head : tail, place.offset - end);
    if (status.ok() && !is_tiles) status = put_section(*this, section, tail);
    if (!status.ok()) return status;
    end = place.offset + place.bytes;
  }
  return {};
}

}  // namespace karst::core
