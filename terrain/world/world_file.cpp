// SPDX-License-Identifier: MIT
// Layout: a header of fixed size, the section table, then the sections one after another, each at the next
// multiple of 64 bytes. That leaves one place for everything: sections cannot overlap, the bytes between them
// are 0, and equal worlds are equal files. docs/formats.md has the offsets.
#include "terrain/world/world_file.h"

#include "terrain/base/checksum.h"
#include "terrain/base/config.h"
#include "terrain/base/lattice.h"
#include "terrain/patch/heights.h"
#include "terrain/surface/case_tables.h"
#include "terrain/world/octree_section.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace karst {
namespace {

// Heights are used where they lie in the file, and the file is little-endian.
static_assert(std::endian::native == std::endian::little);

struct Field {
  const char* name;
  std::size_t offset;  // bytes from the start of the file
};

constexpr std::size_t kHeaderBytes = 192;
constexpr std::size_t kEntryBytes = 32;  // of the section table
constexpr std::uint32_t kMaxSections = 16;
constexpr std::array<unsigned char, 8> kMagic = {'K', 'A',  'R',  'S',
                                                 'T', 0x1a, '\r', '\n'};  // text mode damages it

constexpr Field kMagicField{"magic", 0};
constexpr Field kVersion{"version", 8};
constexpr Field kHeaderLength{"header_bytes", 12};
constexpr Field kFileBytes{"file_bytes", 16};
constexpr Field kSections{"sections", 24};
constexpr Field kHeaderCrc{"header_crc", 28};
constexpr Field kVoxelSize{"voxel_size_m", 32};
constexpr Field kOrigin{"origin_m", 40};
constexpr Field kExtent{"extent", 64};
constexpr Field kDepth{"depth", 76};
constexpr Field kLevel{"level", 80};
constexpr Field kOctets{"octets", 84};
constexpr Field kVolumes{"volumes", 88};
constexpr Field kPatches{"patches", 92};
constexpr Field kHeightBlocks{"height_blocks", 96};
constexpr Field kReserved{"reserved", 100};
constexpr Field kName{"name", 104};
constexpr Field kReservedEnd{"reserved", 168};

// Offsets inside an entry of the section table.
constexpr std::size_t kEntryKind = 0;
constexpr std::size_t kEntryFlags = 4;
constexpr std::size_t kEntryOffset = 8;
constexpr std::size_t kEntryBytesField = 16;
constexpr std::size_t kEntryCrc = 24;
constexpr std::size_t kEntryReserved = 28;
constexpr std::uint32_t kRequired =
    1;  // the flag bit: a reader that does not know the kind must refuse the file

constexpr std::uint32_t four_letters(const char (&s)[5]) {
  std::uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8 | static_cast<unsigned char>(s[i]);
  return value;
}

enum : std::size_t { kOctree, kMask, kSamples, kLevelErrors, kKnownSections };
constexpr std::array<std::uint32_t, kKnownSections> kKinds = {four_letters("OCTR"), four_letters("HMSK"),
                                                              four_letters("HGTS"), four_letters("LERR")};
constexpr std::array<const char*, kKnownSections> kSectionNames = {"octree", "height mask", "height samples",
                                                                   "level errors"};

struct Section {
  std::size_t offset = 0;
  std::size_t bytes = 0;
  bool present = false;
};
using Sections = std::array<Section, kKnownSections>;

template <class T>
T load(std::span<const std::byte> bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

template <class T>
void store(std::span<std::byte> bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}

constexpr std::uint64_t align_up(std::uint64_t bytes) {
  return (bytes + kWorldSectionAlignment - 1) / kWorldSectionAlignment * kWorldSectionAlignment;
}

bool all_zero(std::span<const std::byte> bytes) {
  return std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0}; });
}

Status corrupt(const char* what, Field field) {
  return {StatusCode::corrupt, what, field.name, field.offset};
}

// --- Ranges of the fields, the same for reading and for writing
// -------------------------------------------------

struct Fault {
  const char* what = nullptr;  // null: none
  Field field{"", 0};
};

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

Fault check_info(const WorldInfo& info) {
  for (const auto check : {check_place, check_extent, check_counts, check_name}) {
    if (const Fault fault = check(info); fault.what != nullptr) return fault;
  }
  return {};
}

// Bytes of a section; the product of the largest counts is far below 2^64.
std::uint64_t section_bytes(std::size_t section, const WorldInfo& info) {
  if (section == kOctree) return octree_section_bytes(info.octets);
  if (section == kMask) return (std::uint64_t{info.patches} + 7) / 8;
  if (section == kLevelErrors) {
    return std::uint64_t{info.patches} * level_error_values(info.level) * sizeof(std::uint16_t);
  }
  return std::uint64_t{info.height_blocks} * static_cast<std::uint64_t>(patch_vertices(info.level)) *
         sizeof(std::int16_t);
}

// Where write_world puts the sections, valid where the file's length, which is returned, fits size_t.
std::uint64_t lay_out(const WorldInfo& info, Sections& sections) {
  std::uint64_t end = kHeaderBytes + kKnownSections * kEntryBytes;
  for (std::size_t i = 0; i < kKnownSections; ++i) {
    const std::uint64_t start = align_up(end);
    end = start + section_bytes(i, info);
    sections[i] = {static_cast<std::size_t>(start), static_cast<std::size_t>(end - start), true};
  }
  return end;
}

// --- Heights
// ----------------------------------------------------------------------------------------------------

// Byte of the mask that is wrong, or its size where the mask is right.
std::size_t find_mask_fault(std::span<const std::byte> mask, const WorldInfo& info) {
  std::uint64_t blocks = 0;
  for (const std::byte b : mask)
    blocks += static_cast<std::uint64_t>(std::popcount(std::to_integer<unsigned>(b)));
  const std::uint32_t last_bits = info.patches % 8;
  if (last_bits != 0 && std::to_integer<unsigned>(mask.back()) >> last_bits != 0) return mask.size() - 1;
  return blocks == info.height_blocks ? mask.size() : 0;
}

// Index of the first sample beyond +-kMaxHeight, or the number of samples.
std::size_t find_sample_fault(std::span<const std::int16_t> samples) {
  const auto bad = [](std::int16_t s) { return s > kMaxHeight || s < -kMaxHeight; };
  return static_cast<std::size_t>(std::find_if(samples.begin(), samples.end(), bad) - samples.begin());
}

std::span<const std::int16_t> as_samples(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const std::int16_t*>(bytes.data()), bytes.size() / sizeof(std::int16_t)};
}

std::span<const std::uint16_t> as_level_errors(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const std::uint16_t*>(bytes.data()), bytes.size() / sizeof(std::uint16_t)};
}

// --- Reading
// ----------------------------------------------------------------------------------------------------

// All that can be said before the fields have a meaning: this is a whole, undamaged file of this version.
Status check_envelope(std::span<const std::byte> file) {
  if (reinterpret_cast<std::uintptr_t>(file.data()) % alignof(std::int16_t) != 0) {
    return {StatusCode::invalid_argument, "the bytes are not aligned to 2", "file"};
  }
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
  if (load<std::uint64_t>(file, kFileBytes.offset) != file.size()) {
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
// the section's end. known: index of its kind, kKnownSections for others.
Status read_entry(std::span<const std::byte> file, std::size_t entry, std::uint64_t& end, Section& section,
                  std::size_t& known) {
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
  if (offset != start || start > file.size()) {
    return corrupt("a section is not where it must be", {"section offset", entry + kEntryOffset});
  }
  if (bytes > file.size() - start) {
    return corrupt("a section ends outside the file", {"section bytes", entry + kEntryBytesField});
  }
  if (known == kKnownSections && (flags & kRequired) != 0) {
    return {StatusCode::unsupported, "the file needs a section that this version does not know",
            "section kind", entry + kEntryKind};
  }
  section = {static_cast<std::size_t>(start), static_cast<std::size_t>(bytes), true};
  end = start + bytes;
  return {};
}

// The section table after check_envelope; verify adds the contents' checksums and the zeros between sections.
Status read_table(std::span<const std::byte> file, const WorldInfo& info, bool verify, Sections& sections) {
  sections = {};
  const auto count = load<std::uint32_t>(file, kSections.offset);
  std::uint64_t end = kHeaderBytes + std::uint64_t{count} * kEntryBytes;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::size_t entry = kHeaderBytes + i * kEntryBytes;
    const auto gap = static_cast<std::size_t>(end);  // inside the file, as end always is
    Section section;
    std::size_t known = kKnownSections;
    if (const Status status = read_entry(file, entry, end, section, known); !status.ok()) return status;
    if (verify) {
      if (!all_zero(file.subspan(gap, section.offset - gap))) {
        return corrupt("bytes between sections are not 0", {"padding", gap});
      }
      if (crc32c(file.subspan(section.offset, section.bytes)) !=
          load<std::uint32_t>(file, entry + kEntryCrc)) {
        return corrupt("a section does not match its checksum", {"section crc", entry + kEntryCrc});
      }
    }
    if (known == kKnownSections) continue;
    const Field name{kSectionNames[known], entry};
    if (sections[known].present) return corrupt("a section is there twice", name);
    if (section.bytes != section_bytes(known, info)) {
      return corrupt("a section's length does not fit the counts of the header",
                     {name.name, entry + kEntryBytesField});
    }
    sections[known] = section;
  }
  for (std::size_t i = 0; i < kKnownSections; ++i) {
    if (!sections[i].present) return corrupt("a section is missing", {kSectionNames[i], kSections.offset});
  }
  if (end != file.size())
    return corrupt("bytes follow the last section", {"padding", static_cast<std::size_t>(end)});
  return {};
}

std::span<const std::byte> bytes_of(std::span<const std::byte> file, const Section& section) {
  return file.subspan(section.offset, section.bytes);
}

// --- Writing
// ----------------------------------------------------------------------------------------------------

Status invalid(const char* what, const char* field) {
  return {StatusCode::invalid_argument, what, field};
}

Status check_heights(const WorldInfo& info, const WorldHeights& heights) {
  if (heights.mask.size() != section_bytes(kMask, info))
    return invalid("the mask does not fit the patches", "mask");
  if (find_mask_fault(heights.mask, info) != heights.mask.size()) {
    return invalid("the mask's bits are not height_blocks of the patches", "mask");
  }
  if (heights.samples.size_bytes() != section_bytes(kSamples, info)) {
    return invalid("the samples do not fit height_blocks and level", "samples");
  }
  if (find_sample_fault(heights.samples) != heights.samples.size()) {
    return invalid("a height is beyond the largest displacement", "samples");
  }
  if (heights.level_errors.size_bytes() != section_bytes(kLevelErrors, info)) {
    return invalid("the errors of levels do not fit patches and level", "level_errors");
  }
  if (find_level_error_fault(info.level, heights.level_errors) != heights.level_errors.size()) {
    return invalid("a finer level's error is larger than a coarser one's", "level_errors");
  }
  return {};
}

// The header and the table over sections whose contents are in place.
void store_header(const WorldInfo& info, const Sections& sections, std::span<std::byte> file) {
  const std::size_t header = kHeaderBytes + kKnownSections * kEntryBytes;
  std::memcpy(file.data(), kMagic.data(), kMagic.size());
  store(file, kVersion.offset, kWorldFileVersion);
  store(file, kHeaderLength.offset, static_cast<std::uint32_t>(header));
  store(file, kFileBytes.offset, std::uint64_t{file.size()});
  store(file, kSections.offset, static_cast<std::uint32_t>(kKnownSections));
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
  for (std::size_t i = 0; i < kKnownSections; ++i) {
    const std::size_t entry = kHeaderBytes + i * kEntryBytes;
    store(file, entry + kEntryKind, kKinds[i]);
    store(file, entry + kEntryFlags, kRequired);
    store(file, entry + kEntryOffset, sections[i].offset);
    store(file, entry + kEntryBytesField, sections[i].bytes);
    store(file, entry + kEntryCrc, crc32c(bytes_of(file, sections[i])));
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
  if (const Status status = check_envelope(file); !status.ok()) return status;
  WorldInfo read;
  load_info(file, read);
  if (const Fault fault = check_info(read); fault.what != nullptr) return corrupt(fault.what, fault.field);
  if (!all_zero(file.subspan(kReserved.offset, kName.offset - kReserved.offset))) {
    return corrupt("a reserved field is not 0", kReserved);
  }
  if (!all_zero(file.subspan(kReservedEnd.offset, kHeaderBytes - kReservedEnd.offset))) {
    return corrupt("a reserved field is not 0", kReservedEnd);
  }
  Sections sections;
  if (const Status status = read_table(file, read, true, sections); !status.ok()) return status;

  const std::span<const std::byte> mask = bytes_of(file, sections[kMask]);
  if (const std::size_t at = find_mask_fault(mask, read); at != mask.size()) {
    return corrupt("the mask's bits are not height_blocks of the patches",
                   {"height mask", sections[kMask].offset + at});
  }
  const std::span<const std::int16_t> samples = as_samples(bytes_of(file, sections[kSamples]));
  if (const std::size_t at = find_sample_fault(samples); at != samples.size()) {
    return corrupt("a height is beyond the largest displacement",
                   {"height samples", sections[kSamples].offset + at * sizeof(std::int16_t)});
  }
  const std::span<const std::uint16_t> errors = as_level_errors(bytes_of(file, sections[kLevelErrors]));
  if (const std::size_t at = find_level_error_fault(read.level, errors); at != errors.size()) {
    return corrupt("a finer level's error is larger than a coarser one's",
                   {"level errors", sections[kLevelErrors].offset + at * sizeof(std::uint16_t)});
  }
  info = read;
  return {};
}

Status read_octree(std::span<const std::byte> file, const WorldInfo& info, Octree& tree) {
  if (const Status status = tree.reset(info.depth); !status.ok()) return status;
  Sections sections;
  if (Status status = check_envelope(file); !status.ok()) return status;
  if (Status status = read_table(file, info, false, sections); !status.ok()) return status;
  const Status status = decode_octree(bytes_of(file, sections[kOctree]), info.octets, info.extent, tree);
  if (status.code() != StatusCode::corrupt) return status;
  return {status.code(), status.what(), status.field(), sections[kOctree].offset + status.value()};
}

WorldHeights read_heights(std::span<const std::byte> file, const WorldInfo& info) {
  Sections sections;
  if (!check_envelope(file).ok() || !read_table(file, info, false, sections).ok()) return {};
  return {bytes_of(file, sections[kMask]), as_samples(bytes_of(file, sections[kSamples])),
          as_level_errors(bytes_of(file, sections[kLevelErrors]))};
}

std::size_t world_file_bytes(const WorldInfo& info) {
  Sections sections;
  const std::uint64_t most = std::numeric_limits<std::size_t>::max();
  return static_cast<std::size_t>(std::min(lay_out(info, sections), most));
}

Status write_world(const WorldInfo& info, const Octree& tree, const WorldHeights& heights,
                   std::span<std::byte> out, std::size_t& written) {
  written = 0;
  if (const Status status = validate_world_info(info); !status.ok()) return status;
  if (tree.depth() != info.depth) return invalid("the octree has another depth", "depth");
  if (const Status status = check_heights(info, heights); !status.ok()) return status;
  Sections sections;
  const std::uint64_t bytes = lay_out(info, sections);
  if (bytes > out.size())
    return {StatusCode::limit_reached, "the output is too short for the file", "out", bytes};

  const std::span<std::byte> file = out.first(static_cast<std::size_t>(bytes));
  std::fill(file.begin(), file.end(), std::byte{0});
  const auto place = [&](std::size_t i) { return file.subspan(sections[i].offset, sections[i].bytes); };
  if (const Status status = encode_octree(tree, info.octets, info.extent, place(kOctree)); !status.ok())
    return status;
  std::copy(heights.mask.begin(), heights.mask.end(), place(kMask).begin());
  const std::span<const std::byte> samples = std::as_bytes(heights.samples);
  std::copy(samples.begin(), samples.end(), place(kSamples).begin());
  const std::span<const std::byte> errors = std::as_bytes(heights.level_errors);
  std::copy(errors.begin(), errors.end(), place(kLevelErrors).begin());
  store_header(info, sections, file);
  written = file.size();
  return {};
}

}  // namespace karst
