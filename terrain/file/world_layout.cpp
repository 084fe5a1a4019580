// SPDX-License-Identifier: MIT
#include "terrain/file/world_layout.h"

#include "terrain/base/checksum.h"
#include "terrain/base/config.h"
#include "terrain/base/lattice.h"
#include "terrain/file/material_section.h"
#include "terrain/file/octree_section.h"
#include "terrain/surface/bezier/case_tables.h"

#include <algorithm>
#include <cmath>

namespace karst::core::world_layout {
namespace {

Fault check_place(const WorldInfo& info) {
  // Written so that NaN fails. Below and above these sizes float metres of a camera path lose their meaning.
  if (!(info.voxel_size_m >= 1e-6 && info.voxel_size_m <= 1e9)) {
    return {"voxel size is outside 1e-6..1e9 m", kVoxelSize};
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(std::abs(info.origin_m[axis]) <= 1e12)) {
      return {"origin is beyond 1e12 m", {kOrigin.name, kOrigin.offset + axis * sizeof(double)}};
    }
  }
  return {};
}

Fault check_extent(const WorldInfo& info) {
  if (info.depth < 1 || info.depth > kMaxDepth) return {"octree depth is outside 1..9", kDepth};
  if (info.level < 1 || info.level > kMaxLevel) return {"level is outside 1..6", kLevel};
  const std::int32_t size = std::int32_t{1} << info.depth;
  for (int axis = 0; axis < 3; ++axis) {
    // Fewer than two voxels a side have no voxel corner inside; the topmost layer stays air, so that the
    // surface closes inside the octree.
    const std::int32_t least = axis == 1 ? 1 : 2;
    const std::int32_t most = axis == 1 ? size - 1 : size;
    if (info.extent[axis] < least || info.extent[axis] > most) {
      return {"extent does not fit the octree",
              {kExtent.name, kExtent.offset + static_cast<std::size_t>(axis) * sizeof(std::int32_t)}};
    }
  }
  return {};
}

// Counts size the memory of a terrain: each is bounded by the geometry that it counts.
Fault check_counts(const WorldInfo& info) {
  const std::uint32_t tree_octets = ((1u << (3 * info.depth)) - 1) / 7;
  if (info.octets > tree_octets) return {"more octets than a full octree of this depth", kOctets};
  const std::int64_t corners = std::int64_t{info.extent.x - 1} * info.extent.y * (info.extent.z - 1);
  if (info.volumes > corners) return {"more volumes than voxel corners", kVolumes};
  if (info.patches > kMostPatches) return {"more than 2^24 patches", kPatches};
  if (info.patches < info.volumes || info.patches > std::uint64_t{info.volumes} * kMaxCasePatches) {
    return {"patches do not fit the volumes", kPatches};
  }
  if (info.height_blocks > info.patches) return {"more height blocks than patches", kHeightBlocks};
  return {};
}

Fault check_name(const WorldInfo& info) {
  std::size_t length = 0;
  while (length < kWorldNameBytes && info.name[length] != '\0') ++length;
  if (length == kWorldNameBytes) return {"name is not terminated", kName};
  for (std::size_t i = 0; i < length; ++i) {
    // The name is printed: no control characters, which terminals obey.
    if (info.name[i] < 0x20 || info.name[i] > 0x7e)
      return {"name is not printable ASCII", {kName.name, kName.offset + i}};
  }
  for (std::size_t i = length; i < kWorldNameBytes; ++i) {
    if (info.name[i] != '\0') return {"name has bytes after its end", {kName.name, kName.offset + i}};
  }
  return {};
}
// ----------------------------------------------------------------------------------------------------

// All that can be said before the fields have a meaning: this is a whole, undamaged file of this version.
Status check_envelope(std::span<const std::byte> file, std::uint64_t file_bytes) {
  if (file.size() < kMagic.size() || std::memcmp(file.data(), kMagic.data(), kMagic.size()) != 0) {
    return corrupt("not a karst world file", kMagicField);
  }
  if (file.size() < kHeaderBytes)
    return corrupt("the file ends inside its header", {"file_bytes", file.size()});
  if (load<std::uint32_t>(file, kVersion.offset) != kWorldFileVersion) {
    return {StatusCode::unsupported, "the file is of another version", kVersion.name, kVersion.offset};
  }
  const auto count = load<std::uint32_t>(file, kSections.offset);
  if (count > kMaxSections) return corrupt("more than 16 sections", kSections);
  const std::size_t header = kHeaderBytes + count * kEntryBytes;
  if (load<std::uint32_t>(file, kHeaderLength.offset) != header) {
    return corrupt("header length does not fit the number of sections", kHeaderLength);
  }
  if (file.size() < header) return corrupt("the file ends inside its header", {"file_bytes", file.size()});
  const std::size_t after_crc = kHeaderCrc.offset + sizeof(std::uint32_t);
  const std::uint32_t crc =
      crc32c(file.subspan(after_crc, header - after_crc), crc32c(file.first(kHeaderCrc.offset)));
  if (load<std::uint32_t>(file, kHeaderCrc.offset) != crc) {
    return corrupt("the header does not match its checksum", kHeaderCrc);
  }
  if (load<std::uint64_t>(file, kFileBytes.offset) != file_bytes) {
    return corrupt("the file is shorter or longer than it says", kFileBytes);
  }
  return {};
}

void load_info(std::span<const std::byte> file, WorldInfo& info) {
  info.voxel_size_m = load<double>(file, kVoxelSize.offset);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    info.origin_m[axis] = load<double>(file, kOrigin.offset + axis * sizeof(double));
    info.extent[static_cast<int>(axis)] =
        load<std::int32_t>(file, kExtent.offset + axis * sizeof(std::int32_t));
  }
  info.depth = load<std::int32_t>(file, kDepth.offset);
  info.level = load<std::int32_t>(file, kLevel.offset);
  info.octets = load<std::uint32_t>(file, kOctets.offset);
  info.volumes = load<std::uint32_t>(file, kVolumes.offset);
  info.patches = load<std::uint32_t>(file, kPatches.offset);
  info.height_blocks = load<std::uint32_t>(file, kHeightBlocks.offset);
  std::memcpy(info.name, file.data() + kName.offset, kWorldNameBytes);
}

// One entry of the table: its section begins at the next multiple of the alignment after end, which moves to
// the section's end. known: index of its kind, kWorldSectionKinds for others.
Status read_entry(std::span<const std::byte> file, std::size_t entry, std::uint64_t file_bytes,
                  std::uint64_t& end, Entry& section, std::size_t& known) {
  const auto kind = load<std::uint32_t>(file, entry + kEntryKind);
  known = static_cast<std::size_t>(std::find(kKinds.begin(), kKinds.end(), kind) - kKinds.begin());
  const auto flags = load<std::uint32_t>(file, entry + kEntryFlags);
  const auto offset = load<std::uint64_t>(file, entry + kEntryOffset);
  const auto bytes = load<std::uint64_t>(file, entry + kEntryBytesField);
  if ((flags & ~kRequired) != 0)
    return corrupt("unknown flags of a section", {"section flags", entry + kEntryFlags});
  if (load<std::uint32_t>(file, entry + kEntryReserved) != 0) {
    return corrupt("a reserved field is not 0", {"section reserved", entry + kEntryReserved});
  }
  const std::uint64_t start = align_up(end);
  if (offset != start || start > file_bytes) {
    return corrupt("a section is not where it must be", {"section offset", entry + kEntryOffset});
  }
  if (bytes > file_bytes - start) {
    return corrupt("a section ends outside the file", {"section bytes", entry + kEntryBytesField});
  }
  if (known == kWorldSectionKinds && (flags & kRequired) != 0) {
    return {StatusCode::unsupported, "the file needs a section that this version does not know",
            "section kind", entry + kEntryKind};
  }
  section = {start, bytes, load<std::uint32_t>(file, entry + kEntryCrc), end, entry};
  end = start + bytes;
  return {};
}

// The lengths that counts of the header, or nothing but the kind, decide.
bool fits(WorldSection section, std::uint64_t bytes, const WorldInfo& info) {
  switch (section) {
    case WorldSection::materials:
      return bytes >= material_section::kHeaderBytes && bytes <= material_section::kMostBytes;
    case WorldSection::textures:
      return true;
    case WorldSection::overrides:
      return bytes == info.patches;
    case WorldSection::lights:
      return bytes > 0 && bytes <= kMostLights * sizeof(PointLight) && bytes % sizeof(PointLight) == 0;
    default:
      return bytes == section_bytes(section, info);
  }
}

// Which sections are there.
Status check_presence(const Table& table) {
  const auto present = [&](WorldSection s) { return table.sections[static_cast<std::size_t>(s)].present; };
  const auto missing = [](WorldSection s) {
    return corrupt("a section is missing", {kSectionNames[static_cast<std::size_t>(s)], kSections.offset});
  };
  for (std::size_t i = 0; i < kWorldSections; ++i) {
    if (!table.sections[i].present) return missing(static_cast<WorldSection>(i));
  }
  if (present(WorldSection::materials) && !present(WorldSection::textures))
    return missing(WorldSection::textures);
  const bool needed = present(WorldSection::textures) || present(WorldSection::overrides);
  if (needed && !present(WorldSection::materials)) return missing(WorldSection::materials);
  return {};
}

Status read_table(std::span<const std::byte> head, std::uint64_t file_bytes, const WorldInfo& info,
                  Table& table) {
  table = {};
  const auto count = load<std::uint32_t>(head, kSections.offset);
  std::uint64_t end = kHeaderBytes + std::uint64_t{count} * kEntryBytes;
  for (std::uint32_t i = 0; i < count; ++i) {
    Entry& entry = table.entries[table.count++];
    std::size_t known = kWorldSectionKinds;
    if (const Status status = read_entry(head, kHeaderBytes + i * kEntryBytes, file_bytes, end, entry, known);
        !status.ok()) {
      return status;
    }
    if (known == kWorldSectionKinds) continue;
    const Field name{kSectionNames[known], entry.at};
    if (table.sections[known].present) return corrupt("a section is there twice", name);
    if (!fits(static_cast<WorldSection>(known), entry.bytes, info)) {
      return corrupt("a section's length does not fit the counts of the header",
                     {name.name, entry.at + kEntryBytesField});
    }
    table.sections[known] = {entry.offset, entry.bytes, entry.crc, entry.at, true};
  }
  if (const Status status = check_presence(table); !status.ok()) return status;
  if (end != file_bytes)
    return corrupt("bytes follow the last section", {"padding", static_cast<std::size_t>(end)});
  return {};
}

}  // namespace

bool all_zero(std::span<const std::byte> bytes) {
  return std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0}; });
}

Fault check_info(const WorldInfo& info) {
  for (const auto check : {check_place, check_extent, check_counts, check_name}) {
    if (const Fault fault = check(info); fault.what != nullptr) return fault;
  }
  return {};
}

std::uint64_t section_bytes(WorldSection section, const WorldInfo& info) {
  switch (section) {
    case WorldSection::octree:
      return octree_section_bytes(info.octets);
    case WorldSection::mask:
      return (std::uint64_t{info.patches} + 7) / 8;
    case WorldSection::samples:
      return std::uint64_t{info.height_blocks} * static_cast<std::uint64_t>(patch_vertices(info.level)) *
             sizeof(std::int16_t);
    case WorldSection::sample_crcs:
      return std::uint64_t{height_groups(info.height_blocks)} * sizeof(std::uint32_t);
    case WorldSection::level_errors:
      return std::uint64_t{info.patches} * level_error_values(info.level) * sizeof(std::uint16_t);
    case WorldSection::bounds:
      return std::uint64_t{info.patches} * sizeof(PatchBounds);
    case WorldSection::cones:
    case WorldSection::shading_cones:
      return std::uint64_t{info.patches} * sizeof(NormalCone);
    default:
      return 0;
  }
}

std::uint64_t lay_out(const WorldInfo& info, const WorldMaterials& materials, WorldSections& sections) {
  sections = {};
  const bool has_materials = materials.set.count > 0;
  const std::uint64_t optional[] = {has_materials ? material_section::section_bytes(materials.set) : 0,
                                    has_materials ? texture_bytes(materials.set) : 0,
                                    materials.overrides.size(), materials.lights.size_bytes()};
  std::size_t count = 0;
  for (std::size_t i = 0; i < kWorldSectionKinds; ++i) {
    WorldSectionPlace& place = sections[i];
    place.present = i < kWorldSections || optional[i - kWorldSections] > 0;
    if (!place.present) continue;
    place.bytes =
        i < kWorldSections ? section_bytes(static_cast<WorldSection>(i), info) : optional[i - kWorldSections];
    place.entry = kHeaderBytes + count++ * kEntryBytes;
  }
  std::uint64_t end = kHeaderBytes + count * kEntryBytes;
  for (WorldSectionPlace& place : sections) {
    if (!place.present) continue;
    place.offset = align_up(end);
    end = place.offset + place.bytes;
  }
  return end;
}

std::size_t find_mask_fault(std::span<const std::byte> mask, const WorldInfo& info) {
  std::uint64_t blocks = 0;
  for (const std::byte b : mask)
    blocks += static_cast<std::uint64_t>(std::popcount(std::to_integer<unsigned>(b)));
  const std::uint32_t last_bits = info.patches % 8;
  if (last_bits != 0 && std::to_integer<unsigned>(mask.back()) >> last_bits != 0) return mask.size() - 1;
  return blocks == info.height_blocks ? mask.size() : 0;
}

std::size_t find_sample_fault(std::span<const std::int16_t> samples) {
  const auto bad = [](std::int16_t s) { return s > kMaxHeight || s < -kMaxHeight; };
  return static_cast<std::size_t>(std::find_if(samples.begin(), samples.end(), bad) - samples.begin());
}

std::size_t find_bounds_fault(std::span<const PatchBounds> bounds) {
  const auto bad = [](const PatchBounds& b) {
    return b.min[0] > b.max[0] || b.min[1] > b.max[1] || b.min[2] > b.max[2];
  };
  return static_cast<std::size_t>(std::find_if(bounds.begin(), bounds.end(), bad) - bounds.begin());
}

Status read_head(std::span<const std::byte> head, std::uint64_t file_bytes, WorldInfo& info, Table& table) {
  if (const Status status = check_envelope(head, file_bytes); !status.ok()) return status;
  load_info(head, info);
  if (const Fault fault = check_info(info); fault.what != nullptr) return corrupt(fault.what, fault.field);
  if (!all_zero(head.subspan(kReserved.offset, kName.offset - kReserved.offset))) {
    return corrupt("a reserved field is not 0", kReserved);
  }
  if (!all_zero(head.subspan(kReservedEnd.offset, kHeaderBytes - kReservedEnd.offset))) {
    return corrupt("a reserved field is not 0", kReservedEnd);
  }
  return read_table(head, file_bytes, info, table);
}

}  // namespace karst::core::world_layout
