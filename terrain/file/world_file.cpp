// SPDX-License-Identifier: MIT
#include "terrain/file/world_file.h"

#include "terrain/base/checksum.h"
#include "terrain/file/material_section.h"
#include "terrain/file/octree_section.h"
#include "terrain/file/world_layout.h"

#include <algorithm>
#include <limits>

namespace karst::core {

using namespace world_layout;

namespace {

Status invalid(const char* what, const char* field) {
  return {StatusCode::invalid_argument, what, field};
}

std::span<const std::byte> head_of(std::span<const std::byte> file) {
  return file.first(std::min(file.size(), kMostHead));
}

std::span<const std::byte> bytes_of(std::span<const std::byte> file, const Table& table,
                                    WorldSection section) {
  const WorldSectionPlace& place = table.sections[static_cast<std::size_t>(section)];
  return file.subspan(static_cast<std::size_t>(place.offset), static_cast<std::size_t>(place.bytes));
}

std::span<std::byte> place_of(std::span<std::byte> file, const WorldSections& sections,
                              WorldSection section) {
  const WorldSectionPlace& place = sections[static_cast<std::size_t>(section)];
  return file.subspan(static_cast<std::size_t>(place.offset), static_cast<std::size_t>(place.bytes));
}

// A section's bytes as values of a type that takes any bits; aligned, because sections are.
template <class T>
std::span<const T> as(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)};
}

std::uint32_t group_crc(std::span<const std::int16_t> samples, int level, std::uint32_t group) {
  const std::size_t whole = std::size_t{kHeightGroup} * static_cast<std::size_t>(patch_vertices(level));
  const std::span<const std::int16_t> rest = samples.subspan(group * whole);
  return crc32c(std::as_bytes(rest.first(std::min(rest.size(), whole))));
}

// Checksums of everything, and the zeros between sections.
Status verify_sections(std::span<const std::byte> file, const Table& table) {
  for (std::size_t i = 0; i < table.count; ++i) {
    const Entry& entry = table.entries[i];
    const auto gap = static_cast<std::size_t>(entry.gap);
    const auto offset = static_cast<std::size_t>(entry.offset);
    if (!all_zero(file.subspan(gap, offset - gap)))
      return corrupt("bytes between sections are not 0", {"padding", gap});
    if (crc32c(file.subspan(offset, static_cast<std::size_t>(entry.bytes))) != entry.crc)
      return corrupt("a section does not match its checksum", {"section crc", entry.at + kEntryCrc});
  }
  return {};
}

// Whether patches fit info, the same for reading and for writing. The field of a fault is that of
// WorldPatches, its offset that of the fault in the section.
struct PatchesFault {
  const char* what = nullptr;  // null: none
  const char* field = "";
  WorldSection section = WorldSection::mask;
  std::size_t offset = 0;  // bytes from the section's start
};

PatchesFault find_patches_fault(const WorldInfo& info, const WorldPatches& patches) {
  if (const std::size_t at = find_mask_fault(patches.mask, info); at != patches.mask.size()) {
    return {"the mask's bits are not height_blocks of the patches", "mask", WorldSection::mask, at};
  }
  if (const std::size_t at = find_sample_fault(patches.samples); at != patches.samples.size()) {
    return {"a height is beyond the largest displacement", "samples", WorldSection::samples,
            at * sizeof(std::int16_t)};
  }
  if (const std::size_t at = find_level_error_fault(info.level, patches.level_errors);
      at != patches.level_errors.size()) {
    return {"a finer level's error is larger than a coarser one's", "level_errors",
            WorldSection::level_errors, at * sizeof(std::uint16_t)};
  }
  if (const std::size_t at = find_bounds_fault(patches.bounds); at != patches.bounds.size()) {
    return {"a box's minimum is above its maximum", "bounds", WorldSection::bounds, at * sizeof(PatchBounds)};
  }
  return {};
}

Status check_patches(const WorldInfo& info, const WorldPatches& patches) {
  if (patches.mask.size() != section_bytes(WorldSection::mask, info))
    return invalid("the mask does not fit the patches", "mask");
  if (patches.samples.size_bytes() != section_bytes(WorldSection::samples, info)) {
    return invalid("the samples do not fit height_blocks and level", "samples");
  }
  if (patches.level_errors.size_bytes() != section_bytes(WorldSection::level_errors, info)) {
    return invalid("the errors of levels do not fit patches and level", "level_errors");
  }
  if (patches.bounds.size_bytes() != section_bytes(WorldSection::bounds, info))
    return invalid("the boxes do not fit the patches", "bounds");
  if (patches.cones.size_bytes() != section_bytes(WorldSection::cones, info))
    return invalid("the cones do not fit the patches", "cones");
  if (!patches.shading_cones.empty() && patches.shading_cones.size() != patches.cones.size())
    return invalid("the cones do not fit the patches", "shading_cones");
  const PatchesFault fault = find_patches_fault(info, patches);
  return fault.what == nullptr ? Status() : invalid(fault.what, fault.field);
}

// Where a fault of a section lies in the file.
Status corrupt_section(const Table& table, WorldSection section, const char* what, std::size_t offset) {
  const auto index = static_cast<std::size_t>(section);
  return corrupt(what,
                 {kSectionNames[index], static_cast<std::size_t>(table.sections[index].offset) + offset});
}

// The sections that may be missing.
Status verify_materials(std::span<const std::byte> file, const Table& table) {
  MaterialSet set;
  std::array<std::uint32_t, material_section::kMostImages> crcs;
  if (table.sections[static_cast<std::size_t>(WorldSection::materials)].present) {
    const material_section::Fault fault =
        material_section::decode(bytes_of(file, table, WorldSection::materials), set, crcs);
    if (fault.what != nullptr)
      return corrupt_section(table, WorldSection::materials, fault.what, fault.offset);
    const std::span<const std::byte> textures = bytes_of(file, table, WorldSection::textures);
    if (textures.size() != texture_bytes(set))
      return corrupt_section(table, WorldSection::textures, "the section's length does not fit the materials",
                             0);
    const std::size_t image = material_section::find_image_fault(set, crcs, textures);
    if (image != material_section::image_count(set)) {
      return corrupt_section(table, WorldSection::textures, "an image does not match its checksum",
                             material_section::image_offset(set, image));
    }
  }
  const material_section::Fault override_fault = material_section::check_overrides(
      as<std::uint8_t>(bytes_of(file, table, WorldSection::overrides)), set.count);
  if (override_fault.what != nullptr)
    return corrupt_section(table, WorldSection::overrides, override_fault.what, override_fault.offset);
  const material_section::Fault light_fault =
      material_section::check_lights(as<PointLight>(bytes_of(file, table, WorldSection::lights)));
  if (light_fault.what != nullptr)
    return corrupt_section(table, WorldSection::lights, light_fault.what, light_fault.offset);
  return {};
}

// Whether they can be written with info.
Status check_materials(const WorldInfo& info, const WorldMaterials& materials) {
  if (const auto fault = material_section::check_set(materials.set); fault.what != nullptr)
    return invalid(fault.what, "materials");
  if (materials.textures.size() != texture_bytes(materials.set))
    return invalid("the textures do not fit the materials", "textures");
  if (!materials.overrides.empty() && materials.set.count == 0)
    return invalid("there are no materials to choose from", "overrides");
  if (!materials.overrides.empty() && materials.overrides.size() != info.patches)
    return invalid("the overrides do not fit the patches", "overrides");
  if (const auto fault = material_section::check_overrides(materials.overrides, materials.set.count);
      fault.what != nullptr)
    return invalid(fault.what, "overrides");
  if (const auto fault = material_section::check_lights(materials.lights); fault.what != nullptr)
    return invalid(fault.what, "lights");
  return {};
}

// The header and the table over sections whose contents are in place.
void store_header(const WorldInfo& info, const WorldSections& sections, std::span<std::byte> file) {
  std::uint32_t count = 0;
  for (const WorldSectionPlace& place : sections) count += place.present ? 1 : 0;
  const std::size_t header = kHeaderBytes + count * kEntryBytes;
  std::memcpy(file.data(), kMagic.data(), kMagic.size());
  store(file, kVersion.offset, kWorldFileVersion);
  store(file, kHeaderLength.offset, static_cast<std::uint32_t>(header));
  store(file, kFileBytes.offset, std::uint64_t{file.size()});
  store(file, kSections.offset, count);
  store(file, kVoxelSize.offset, info.voxel_size_m);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    store(file, kOrigin.offset + axis * sizeof(double), info.origin_m[axis]);
    store(file, kExtent.offset + axis * sizeof(std::int32_t), info.extent[static_cast<int>(axis)]);
  }
  store(file, kDepth.offset, std::int32_t{info.depth});
  store(file, kLevel.offset, std::int32_t{info.level});
  store(file, kOctets.offset, info.octets);
  store(file, kVolumes.offset, info.volumes);
  store(file, kPatches.offset, info.patches);
  store(file, kHeightBlocks.offset, info.height_blocks);
  std::memcpy(file.data() + kName.offset, info.name, kWorldNameBytes);
  for (std::size_t i = 0; i < kWorldSectionKinds; ++i) {
    if (!sections[i].present) continue;
    const std::size_t entry = sections[i].entry;
    store(file, entry + kEntryKind, kKinds[i]);
    store(file, entry + kEntryFlags, i < kWorldSections ? kRequired : 0);
    store(file, entry + kEntryOffset, sections[i].offset);
    store(file, entry + kEntryBytesField, sections[i].bytes);
    store(file, entry + kEntryCrc, crc32c(place_of(file, sections, static_cast<WorldSection>(i))));
  }
  const std::size_t after_crc = kHeaderCrc.offset + sizeof(std::uint32_t);
  const std::span<const std::byte> bytes = file;
  store(file, kHeaderCrc.offset,
        crc32c(bytes.subspan(after_crc, header - after_crc), crc32c(bytes.first(kHeaderCrc.offset))));
}

}  // namespace

Status validate_world_info(const WorldInfo& info) {
  const Fault fault = check_info(info);
  return fault.what == nullptr ? Status() : invalid(fault.what, fault.field.name);
}

Status read_world_info(std::span<const std::byte> file, WorldInfo& info) {
  if (reinterpret_cast<std::uintptr_t>(file.data()) % kWorldAlignment != 0)
    return invalid("the bytes are not aligned to 4", "file");
  WorldInfo read;
  Table table;
  if (const Status status = read_head(head_of(file), file.size(), read, table); !status.ok()) return status;
  if (const Status status = verify_sections(file, table); !status.ok()) return status;
  const WorldPatches patches = read_patches(file, read);
  if (const PatchesFault fault = find_patches_fault(read, patches); fault.what != nullptr)
    return corrupt_section(table, fault.section, fault.what, fault.offset);
  const auto crcs = as<std::uint32_t>(bytes_of(file, table, WorldSection::sample_crcs));
  for (std::uint32_t group = 0; group < crcs.size(); ++group) {
    if (group_crc(patches.samples, read.level, group) == crcs[group]) continue;
    return corrupt_section(table, WorldSection::sample_crcs, "a group of heights does not match its checksum",
                           group * sizeof(std::uint32_t));
  }
  if (const Status status = verify_materials(file, table); !status.ok()) return status;
  info = read;
  return {};
}

Status read_octree(std::span<const std::byte> file, const WorldInfo& info, Octree& tree) {
  if (const Status status = tree.reset(info.depth); !status.ok()) return status;
  WorldInfo read;
  Table table;
  if (Status status = read_head(head_of(file), file.size(), read, table); !status.ok()) return status;
  const Status status =
      decode_octree(bytes_of(file, table, WorldSection::octree), info.octets, info.extent, tree);
  if (status.code() != StatusCode::corrupt) return status;
  const std::uint64_t offset = table.sections[static_cast<std::size_t>(WorldSection::octree)].offset;
  return {status.code(), status.what(), status.field(), offset + status.value()};
}

WorldPatches read_patches(std::span<const std::byte> file, const WorldInfo& info) {
  WorldInfo read;
  Table table;
  if (!read_head(head_of(file), file.size(), read, table).ok() || read.patches != info.patches) return {};
  return {bytes_of(file, table, WorldSection::mask),
          as<std::int16_t>(bytes_of(file, table, WorldSection::samples)),
          as<std::uint16_t>(bytes_of(file, table, WorldSection::level_errors)),
          as<PatchBounds>(bytes_of(file, table, WorldSection::bounds)),
          as<NormalCone>(bytes_of(file, table, WorldSection::cones)),
          as<NormalCone>(bytes_of(file, table, WorldSection::shading_cones))};
}

WorldMaterials read_materials(std::span<const std::byte> file, const WorldInfo& info) {
  WorldInfo read;
  Table table;
  if (!read_head(head_of(file), file.size(), read, table).ok() || read.patches != info.patches)
    return WorldMaterials();
  WorldMaterials materials;
  std::array<std::uint32_t, material_section::kMostImages> crcs;
  // Without the section there is nothing to decode, and the set stays empty.
  static_cast<void>(
      material_section::decode(bytes_of(file, table, WorldSection::materials), materials.set, crcs));
  materials.textures = bytes_of(file, table, WorldSection::textures);
  materials.overrides = as<std::uint8_t>(bytes_of(file, table, WorldSection::overrides));
  materials.lights = as<PointLight>(bytes_of(file, table, WorldSection::lights));
  return materials;
}

std::size_t world_file_bytes(const WorldInfo& info, const WorldMaterials& materials) {
  WorldSections sections;
  const std::uint64_t most = std::numeric_limits<std::size_t>::max();
  return static_cast<std::size_t>(std::min(lay_out(info, materials, sections), most));
}

std::size_t world_file_bytes(const WorldInfo& info) {
  return world_file_bytes(info, WorldMaterials());
}

Status write_world(const WorldInfo& info, const Octree& tree, const WorldPatches& patches,
                   std::span<std::byte> out, std::size_t& written) {
  return write_world(info, tree, patches, WorldMaterials(), out, written);
}

Status write_world(const WorldInfo& info, const Octree& tree, const WorldPatches& patches,
                   const WorldMaterials& materials, std::span<std::byte> out, std::size_t& written) {
  written = 0;
  if (const Status status = validate_world_info(info); !status.ok()) return status;
  if (tree.depth() != info.depth) return invalid("the octree has another depth", "depth");
  if (const Status status = check_patches(info, patches); !status.ok()) return status;
  if (const Status status = check_materials(info, materials); !status.ok()) return status;
  WorldSections sections;
  const std::uint64_t bytes = lay_out(info, materials, sections);
  if (bytes > out.size())
    return {StatusCode::limit_reached, "the output is too short for the file", "out", bytes};

  const std::span<std::byte> file = out.first(static_cast<std::size_t>(bytes));
  std::fill(file.begin(), file.end(), std::byte{0});
  if (const Status status =
          encode_octree(tree, info.octets, info.extent, place_of(file, sections, WorldSection::octree));
      !status.ok()) {
    return status;
  }
  const auto copy = [&](WorldSection section, std::span<const std::byte> from) {
    std::copy(from.begin(), from.end(), place_of(file, sections, section).begin());
  };
  copy(WorldSection::mask, patches.mask);
  copy(WorldSection::samples, std::as_bytes(patches.samples));
  copy(WorldSection::level_errors, std::as_bytes(patches.level_errors));
  copy(WorldSection::bounds, std::as_bytes(patches.bounds));
  copy(WorldSection::cones, std::as_bytes(patches.cones));
  if (patches.shading_cones.empty()) {
    const std::span<std::byte> to = place_of(file, sections, WorldSection::shading_cones);
    constexpr NormalCone kUnknown;
    for (std::size_t at = 0; at < to.size(); at += sizeof kUnknown) store(to, at, kUnknown);
  } else {
    copy(WorldSection::shading_cones, std::as_bytes(patches.shading_cones));
  }
  if (materials.set.count > 0) {
    material_section::encode(materials.set, materials.textures,
                             place_of(file, sections, WorldSection::materials));
  }
  copy(WorldSection::textures, materials.textures);
  copy(WorldSection::overrides, std::as_bytes(materials.overrides));
  copy(WorldSection::lights, std::as_bytes(materials.lights));
  const std::span<std::byte> crcs = place_of(file, sections, WorldSection::sample_crcs);
  for (std::uint32_t group = 0; group < height_groups(info.height_blocks); ++group) {
    store(crcs, group * sizeof(std::uint32_t), group_crc(patches.samples, info.level, group));
  }
  store_header(info, sections, file);
  written = file.size();
  return {};
}

}  // namespace karst::core
