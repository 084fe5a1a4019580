// SPDX-License-Identifier: MIT
#include "terrain/file/world_layout.h"

#include "terrain/base/checksum.h"
#include "terrain/base/config.h"
#include "terrain/base/lattice.h"
#include "terrain/file/fields/field_section.h"
#include "terrain/file/ground_section.h"
#include "terrain/file/materials/material_section.h"
#include "terrain/file/octree_section.h"
#include "terrain/measure/level_error.h"
#include "terrain/surface/bezier/case_tables.h"

#include <algorithm>
#include <bit>
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
  if (info.regions < 1 || info.regions > kMostRegions) return {"regions are outside 1..16", kRegions};
  const std::uint32_t tree_octets = ((1u << (3 * info.depth)) - 1) / 7;
  if (info.octets > std::uint64_t{tree_octets} * info.regions)
    return {"more octets than a full octree of this depth", kOctets};
  const std::int64_t corners =
      std::int64_t{info.extent.x - 1} * info.extent.y * (info.extent.z - 1) * info.regions;
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

// What to say about a file of another version than this one; null: it is this one.
const char* other_version(std::uint32_t version) {
  static_assert(kWorldFileVersion == 5);
  switch (version) {
    case 1:
      return "world file of version 1; this karst reads 5: bake it again with karst-bake";
    case 2:
      return "world file of version 2; this karst reads 5: bake it again with karst-bake";
    case 3:
      return "world file of version 3; this karst reads 5: bake it again with karst-bake";
    case 4:
      return "world file of version 4; this karst reads 5: bake it again with karst-bake";
    case kWorldFileVersion:
      return nullptr;
    default:
      return "world file of a version that this karst, which reads 5, does not know";
  }
}

// All that can be said before the fields have a meaning: this is a whole, undamaged file of this version.
Status check_envelope(std::span<const std::byte> file, std::uint64_t file_bytes) {
  if (file.size() < kMagic.size() || std::memcmp(file.data(), kMagic.data(), kMagic.size()) != 0) {
    return corrupt("not a karst world file", kMagicField);
  }
  if (file.size() < kHeaderBytes)
    return corrupt("the file ends inside its header", {"file_bytes", file.size()});
  if (const char* other = other_version(load<std::uint32_t>(file, kVersion.offset)); other != nullptr)
    return {StatusCode::unsupported, other, kVersion.name, kVersion.offset};
  const auto count = load<std::uint32_t>(file, kSections.offset);
  if (count > kMaxSections) return corrupt("more than 20 sections", kSections);
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
  // 0 says what 1 would.
  info.regions = load<std::uint32_t>(file, kRegions.offset);
  if (info.regions == 0) info.regions = 1;
  info.level = load<std::int32_t>(file, kLevel.offset);
  info.octets = load<std::uint32_t>(file, kOctets.offset);
  info.volumes = load<std::uint32_t>(file, kVolumes.offset);
  info.patches = load<std::uint32_t>(file, kPatches.offset);
  info.height_blocks = load<std::uint32_t>(file, kHeightBlocks.offset);
  std::memcpy(info.name, file.data() + kName.offset, kWorldNameBytes);
}

// One entry of the table: its section begins at the next multiple of the alignment after end, which moves to
// the section's end. known: index of its kind, kWorldSectionKinds for others.
Status read_entry(std::span<const std::byte> file, std::uint64_t entry, std::uint64_t file_bytes,
                  std::uint64_t& end, Entry& section, std::size_t& known) {
  const auto letters = load<std::uint32_t>(file, entry + kEntryKind);
  const auto same = [&](const SectionKind& kind) { return kind.letters == letters; };
  known = static_cast<std::size_t>(std::find_if(kSectionKinds.begin(), kSectionKinds.end(), same) -
                                   kSectionKinds.begin());
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

// Of kinds that this version does not know, which only verify() reads: enough for what a later version could
// add, and too little to keep a reader busy.
constexpr std::uint32_t kMostUnknown = 4;
constexpr std::uint64_t kMostUnknownBytes = std::uint64_t{16} << 20;

// Whether a section can be so long in a world with these counts.
bool fits(WorldSection section, std::uint64_t bytes, const WorldInfo& info) {
  if (kind_of(section).bytes != nullptr) return bytes == kind_of(section).bytes(info);
  if (section == WorldSection::materials)
    return bytes >= material_section::kHeaderBytes && bytes <= material_section::kMostBytes;
  if (section == WorldSection::lights)
    return bytes > 0 && bytes <= kMostLights * sizeof(PointLight) && bytes % sizeof(PointLight) == 0;
  if (section == WorldSection::surroundings)
    return bytes >= sizeof(Surroundings) &&
           bytes <= sizeof(Surroundings) + most_rim_points(info.extent) * kRimPointBytes;
  if (section == WorldSection::ground)
    return bytes == ground_section::kBytes || bytes == ground_section::kMostBytes;
  // Which of the two GRND says.
  if (section == WorldSection::region) {
    return bytes == ground_section::region_bytes(info.regions, false) ||
           bytes == ground_section::region_bytes(info.regions, true);
  }
  if (section == WorldSection::tiles) return bytes > 0;
  if (section == WorldSection::field) return bytes > field_section::kHeaderBytes;
  if (section == WorldSection::imagery) return bytes == ground_section::kImageryBytes;
  if (section == WorldSection::blend_map) {
    const BlendMap most{kMostBlendSide, kMostBlendSide, {}};
    return bytes > material_section::kBlendHeaderBytes &&
           bytes <= material_section::blend_section_bytes(most);
  }
  return true;
}

// Which sections are there.
Status check_presence(const Table& table, std::uint32_t regions) {
  const auto present = [&](WorldSection s) { return table.places[static_cast<std::size_t>(s)].present; };
  const auto missing = [](WorldSection s) {
    return corrupt("a section is missing", {kind_of(s).name, kSections.offset});
  };
  for (std::size_t i = 0; i < kWorldSectionKinds; ++i) {
    if (kSectionKinds[i].required && !table.places[i].present) return missing(static_cast<WorldSection>(i));
  }
  if (present(WorldSection::materials) && !present(WorldSection::textures))
    return missing(WorldSection::textures);
  const bool needed =
      present(WorldSection::textures) || present(WorldSection::overrides) || present(WorldSection::blend_map);
  if (needed && !present(WorldSection::materials)) return missing(WorldSection::materials);
  const bool has_ground = present(WorldSection::ground) || present(WorldSection::tiles);
  for (const WorldSection section : {WorldSection::ground, WorldSection::tiles}) {
    if (has_ground && !present(section)) return missing(section);
  }
  if (present(WorldSection::region) && !has_ground) return missing(WorldSection::ground);
  if (regions > 1 && !present(WorldSection::region)) return missing(WorldSection::region);
  if (present(WorldSection::imagery) && !has_ground) return missing(WorldSection::ground);
  return {};
}

Status read_table(std::span<const std::byte> head, std::uint64_t file_bytes, const WorldInfo& info,
                  Table& table) {
  table = {};
  const auto count = load<std::uint32_t>(head, kSections.offset);
  std::uint64_t end = kHeaderBytes + std::uint64_t{count} * kEntryBytes;
  std::uint32_t unknown = 0;
  std::uint64_t unknown_bytes = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    Entry& entry = table.entries[table.count++];
    std::size_t known = kWorldSectionKinds;
    if (const Status status = read_entry(head, kHeaderBytes + i * kEntryBytes, file_bytes, end, entry, known);
        !status.ok()) {
      return status;
    }
    if (known == kWorldSectionKinds) {
      unknown_bytes += entry.bytes;  // all of them lie in the file, one behind the other
      if (++unknown > kMostUnknown)
        return {StatusCode::unsupported, "more than 4 sections of unknown kinds", "section kind", entry.at};
      if (unknown_bytes > kMostUnknownBytes) {
        return {StatusCode::unsupported, "sections of unknown kinds hold more than 16 MiB", "section bytes",
                entry.at + kEntryBytesField};
      }
      continue;
    }
    const Field name{kSectionKinds[known].name, entry.at};
    if (table.places[known].present) return corrupt("a section is there twice", name);
    if (!fits(static_cast<WorldSection>(known), entry.bytes, info)) {
      return corrupt("a section's length does not fit the counts of the header",
                     {name.name, entry.at + kEntryBytesField});
    }
    table.places[known] = {entry.offset, entry.bytes, entry.crc, entry.at, true};
  }
  if (const Status status = check_presence(table, info.regions); !status.ok()) return status;
  if (end != file_bytes) return corrupt("bytes follow the last section", {"padding", end});
  return {};
}

// Calls bad(entry), which tells whether an entry may not be so, for entries of a type that takes any bits.
template <class T, class Bad>
std::uint64_t find_entry(std::span<const std::byte> bytes, const Bad& bad) {
  for (std::size_t at = 0; at + sizeof(T) <= bytes.size(); at += sizeof(T)) {
    if (bad(load<T>(bytes, at))) return at;
  }
  return bytes.size();
}

bool is_too_high(std::int16_t s) {
  return s > kMaxHeight || s < -kMaxHeight;
}

bool is_inside_out(const PatchBounds& b) {
  return b.min[0] > b.max[0] || b.min[1] > b.max[1] || b.min[2] > b.max[2];
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

SectionCheck::SectionCheck(WorldSection section, const WorldInfo& info, std::uint32_t materials)
    : section_(section), info_(info), materials_(materials) {}

SectionFault SectionCheck::feed(std::span<const std::byte> bytes) {
  SectionFault fault;
  const auto entry_fault = [&](std::uint64_t at, const char* what) {
    return at == bytes.size() ? SectionFault() : SectionFault{what, at};
  };
  switch (section_) {
    case WorldSection::keys:
      fault = feed_keys(bytes);
      break;
    case WorldSection::mask:
      fault = feed_mask(bytes);
      break;
    case WorldSection::samples:
      fault = entry_fault(find_entry<std::int16_t>(bytes, is_too_high),
                          "a height is beyond the largest displacement");
      break;
    case WorldSection::level_errors:
      fault = feed_level_errors(bytes);
      break;
    case WorldSection::bounds:
      fault =
          entry_fault(find_entry<PatchBounds>(bytes, is_inside_out), "a box's minimum is above its maximum");
      break;
    case WorldSection::overrides: {
      const auto unknown = [&](std::uint8_t material) {
        return material > materials_ && material != kPaintedByMap;
      };
      fault =
          entry_fault(find_entry<std::uint8_t>(bytes, unknown), "a patch has a material that is not there");
      break;
    }
    default:
      break;
  }
  fault.offset += at_;
  at_ += bytes.size();
  return fault;
}

SectionFault SectionCheck::finish() const {
  if (section_ == WorldSection::mask && count_ != info_.height_blocks)
    return {"the mask's bits are not height_blocks of the patches", 0};
  if (section_ == WorldSection::keys && count_ != info_.volumes)
    return {"the keys are not of as many volumes as stated", 0};
  return {};
}

// last_ is 0 before the first: the key of no patch, because no corner lies on a side.
const char* SectionCheck::key_fault(PatchKey key) const {
  if (key.bits() >> PatchKey::kBits != 0 || key.region() >= info_.regions)
    return "a patch is of no region of the world";
  if (key.bits() <= last_) return "a patch's key is not above the one before";
  const glm::ivec3 corner = key.corner();
  const bool inside = corner.x >= 1 && corner.x < info_.extent.x && corner.y >= 1 &&
                      corner.y <= info_.extent.y && corner.z >= 1 && corner.z < info_.extent.z;
  if (!inside) return "a patch lies outside the extent";
  if (key.case_patch() >= kMaxCasePatches) return "a patch's key has no such case";
  if (key.case_patch() > 0 && key.bits() != last_ + 1) return "the patches of a volume do not follow another";
  return nullptr;
}

SectionFault SectionCheck::feed_keys(std::span<const std::byte> bytes) {
  for (std::size_t at = 0; at + sizeof(PatchKey) <= bytes.size(); at += sizeof(PatchKey)) {
    const PatchKey key = PatchKey::from_bits(load<std::uint64_t>(bytes, at));
    if (const char* what = key_fault(key); what != nullptr) return {what, at};
    count_ += key.case_patch() == 0 ? 1u : 0u;
    last_ = key.bits();
  }
  return {};
}

SectionFault SectionCheck::feed_mask(std::span<const std::byte> bytes) {
  const std::uint64_t last_byte = info_.patches / 8;  // with unused bits, where there are any
  for (std::size_t k = 0; k < bytes.size(); ++k) {
    const auto bits = std::to_integer<unsigned>(bytes[k]);
    if (at_ + k == last_byte && bits >> (info_.patches % 8) != 0)
      return {"unused bits of the mask are not 0", k};
    count_ += static_cast<std::uint64_t>(std::popcount(bits));
  }
  return {};
}

// Errors and reaches fall or stay from each to the next, half a row each. Level 1 has none.
SectionFault SectionCheck::feed_level_errors(std::span<const std::byte> bytes) {
  const auto half = static_cast<std::uint64_t>(info_.level - 1);
  for (std::size_t at = 0; at + sizeof(std::uint16_t) <= bytes.size(); at += sizeof(std::uint16_t)) {
    const auto value = load<std::uint16_t>(bytes, at);
    if ((at_ + at) / sizeof(std::uint16_t) % half != 0 && value > last_)
      return {"a finer level's error is larger than a coarser one's", at};
    last_ = value;
  }
  return {};
}

const std::array<SectionKind, kWorldSectionKinds> kSectionKinds = {{
    {four_letters("OCTR"), "octree", true, true,
     [](const WorldInfo& i) { return octree_section_bytes(i.octets, i.regions); }},
    {four_letters("PKEY"), "patch keys", true, true,
     [](const WorldInfo& i) { return i.patches * std::uint64_t{sizeof(PatchKey)}; }},
    {four_letters("HMSK"), "height mask", true, true,
     [](const WorldInfo& i) { return (std::uint64_t{i.patches} + 7) / 8; }},
    {four_letters("HGTS"), "height samples", true, true,
     [](const WorldInfo& i) {
       return i.height_blocks * static_cast<std::uint64_t>(patch_vertices(i.level)) * sizeof(std::int16_t);
     }},
    {four_letters("HCRC"), "height checksums", true, true,
     [](const WorldInfo& i) {
       return height_groups(i.height_blocks) * std::uint64_t{sizeof(std::uint32_t)};
     }},
    {four_letters("LERR"), "level errors", true, true,
     [](const WorldInfo& i) {
       return i.patches * std::uint64_t{level_error_values(i.level)} * sizeof(std::uint16_t);
     }},
    {four_letters("PBND"), "patch bounds", true, true,
     [](const WorldInfo& i) { return i.patches * std::uint64_t{sizeof(PatchBounds)}; }},
    {four_letters("CONE"), "normal cones", true, true,
     [](const WorldInfo& i) { return i.patches * std::uint64_t{sizeof(NormalCone)}; }},
    {four_letters("SCON"), "shading cones", true, true,
     [](const WorldInfo& i) { return i.patches * std::uint64_t{sizeof(NormalCone)}; }},
    {four_letters("MATL"), "materials", false, false, nullptr},
    {four_letters("MTEX"), "textures", false, false, nullptr},
    {four_letters("MOVR"), "overrides", false, false,
     [](const WorldInfo& i) { return std::uint64_t{i.patches}; }},
    {four_letters("LGTS"), "lights", false, false, nullptr},
    {four_letters("SURR"), "surroundings", false, false, nullptr},
    {four_letters("BMAP"), "blend map", false, false, nullptr},
    {four_letters("GRND"), "ground", false, true, nullptr},
    {four_letters("TILE"), "tiles", false, true, nullptr},
    {four_letters("REGN"), "region", false, true, nullptr},
    {four_letters("IMAG"), "imagery", false, false, nullptr},
    {four_letters("FELD"), "field", false, true, nullptr},
}};

std::array<WorldSection, kWorldSectionKinds> writing_order() {
  std::array<WorldSection, kWorldSectionKinds> order{WorldSection::tiles};
  std::size_t count = 1;
  for (std::size_t i = 0; i < kWorldSectionKinds; ++i) {
    const auto section = static_cast<WorldSection>(i);
    if (section != WorldSection::tiles) order[count++] = section;
  }
  return order;
}

std::uint64_t lay_out(const WorldInfo& info, const WorldMaterials& materials, const WorldGround& ground,
                      std::uint64_t field_bytes, SectionPlaces& places) {
  places = {};
  const auto of = [&](WorldSection s) -> SectionPlace& { return places[static_cast<std::size_t>(s)]; };
  if (materials.set.count > 0) {
    of(WorldSection::materials) = {.bytes = material_section::section_bytes(materials.set), .present = true};
    of(WorldSection::textures) = {.bytes = texture_bytes(materials.set), .present = true};
  }
  of(WorldSection::overrides).present = !materials.overrides.empty();
  of(WorldSection::lights) = {.bytes = materials.lights.size_bytes(), .present = !materials.lights.empty()};
  of(WorldSection::surroundings) = {.bytes = sizeof(Surroundings) + materials.rim.size_bytes(),
                                    .present = materials.surroundings.has_water() || !materials.rim.empty()};
  of(WorldSection::blend_map) = {.bytes = material_section::blend_section_bytes(materials.set.blend_map),
                                 .present = materials.set.blend_map.exists()};
  of(WorldSection::ground) = {.bytes = ground_section::section_bytes(ground),
                              .present = ground.info.exists()};
  of(WorldSection::tiles) = {.bytes = ground.tile_bytes, .present = ground.info.exists()};
  of(WorldSection::region) = {.bytes = ground_section::region_bytes(info.regions, ground.info.can_be_dug),
                              .present = ground.info.region_count > 0};
  of(WorldSection::imagery) = {.bytes = ground_section::kImageryBytes,
                               .present = ground.info.exists() && ground.imagery.exists()};
  of(WorldSection::field) = {.bytes = field_bytes, .present = field_bytes > 0};
  std::uint64_t end = kHeaderBytes;
  for (const WorldSection section : writing_order()) {
    SectionPlace& place = of(section);
    place.present = place.present || kind_of(section).required;
    if (!place.present) continue;
    if (kind_of(section).bytes != nullptr) place.bytes = kind_of(section).bytes(info);
    place.entry = end;
    end += kEntryBytes;
  }
  for (const WorldSection section : writing_order()) {
    SectionPlace& place = of(section);
    if (!place.present) continue;
    place.offset = align_up(end);
    end = place.offset + place.bytes;
  }
  return end;
}

std::size_t store_head(const WorldInfo& info, const SectionPlaces& places, std::uint64_t file_bytes,
                       std::span<std::byte> out) {
  std::uint32_t count = 0;
  for (const SectionPlace& place : places) count += place.present ? 1 : 0;
  const std::size_t header = kHeaderBytes + count * kEntryBytes;
  const std::span<std::byte> head = out.first(header);
  std::fill(head.begin(), head.end(), std::byte{0});
  std::memcpy(head.data(), kMagic.data(), kMagic.size());
  store(head, kVersion.offset, kWorldFileVersion);
  store(head, kHeaderLength.offset, static_cast<std::uint32_t>(header));
  store(head, kFileBytes.offset, file_bytes);
  store(head, kSections.offset, count);
  store(head, kVoxelSize.offset, info.voxel_size_m);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    store(head, kOrigin.offset + axis * sizeof(double), info.origin_m[axis]);
    store(head, kExtent.offset + axis * sizeof(std::int32_t), info.extent[static_cast<int>(axis)]);
  }
  store(head, kDepth.offset, std::int32_t{info.depth});
  store(head, kRegions.offset, info.regions > 1 ? info.regions : 0);
  store(head, kLevel.offset, std::int32_t{info.level});
  store(head, kOctets.offset, info.octets);
  store(head, kVolumes.offset, info.volumes);
  store(head, kPatches.offset, info.patches);
  store(head, kHeightBlocks.offset, info.height_blocks);
  std::memcpy(head.data() + kName.offset, info.name, kWorldNameBytes);
  for (std::size_t i = 0; i < kWorldSectionKinds; ++i) {
    if (!places[i].present) continue;
    const std::uint64_t entry = places[i].entry;
    store(head, entry + kEntryKind, kSectionKinds[i].letters);
    store(head, entry + kEntryFlags, kSectionKinds[i].required || kSectionKinds[i].must_know ? kRequired : 0);
    store(head, entry + kEntryOffset, places[i].offset);
    store(head, entry + kEntryBytesField, places[i].bytes);
    store(head, entry + kEntryCrc, places[i].crc);
  }
  const std::size_t after_crc = kHeaderCrc.offset + sizeof(std::uint32_t);
  const std::span<const std::byte> bytes = head;
  store(head, kHeaderCrc.offset, crc32c(bytes.subspan(after_crc), crc32c(bytes.first(kHeaderCrc.offset))));
  return header;
}

Status read_head(std::span<const std::byte> head, std::uint64_t file_bytes, WorldInfo& info, Table& table) {
  if (const Status status = check_envelope(head, file_bytes); !status.ok()) return status;
  load_info(head, info);
  if (const Fault fault = check_info(info); fault.what != nullptr) return corrupt(fault.what, fault.field);
  if (load<std::uint32_t>(head, kRegions.offset) == 1) return corrupt("one region is written as 0", kRegions);
  if (!all_zero(head.subspan(kReservedEnd.offset, kHeaderBytes - kReservedEnd.offset))) {
    return corrupt("a reserved field is not 0", kReservedEnd);
  }
  return read_table(head, file_bytes, info, table);
}

}  // namespace karst::core::world_layout

namespace karst::core {

Status validate_world_info(const WorldInfo& info) {
  const world_layout::Fault fault = world_layout::check_info(info);
  return fault.what == nullptr ? Status()
                               : Status(StatusCode::invalid_argument, fault.what, fault.field.name);
}

}  // namespace karst::core
