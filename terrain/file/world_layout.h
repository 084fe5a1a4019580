// SPDX-License-Identifier: MIT
// Where everything lies in a .karst file, and the checks that reading and writing share: a header of fixed
// size, the section table, then the sections one after another, each at the next multiple of 64 bytes. That
// leaves one place for everything: sections cannot overlap, the bytes between them are 0, and equal worlds
// are equal files. docs/formats.md has the offsets. For world_reader.cpp, world_writer.cpp and
// terrain/edit/save_world.cpp alone.
#pragma once

#include "terrain/file/world_file.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace karst::core::world_layout {

// Sections are used as they lie in the file, and the file is little-endian.
static_assert(std::endian::native == std::endian::little);

struct Field {
  const char* name;
  std::uint64_t offset;  // bytes from the start of the file
};

inline constexpr std::size_t kHeaderBytes = 192;
inline constexpr std::size_t kEntryBytes = 32;  // of the section table
inline constexpr std::uint32_t kMaxSections = 20;
inline constexpr std::size_t kMostHead = kHeaderBytes + kMaxSections * kEntryBytes;
inline constexpr std::array<unsigned char, 8> kMagic = {'K', 'A',  'R',  'S',
                                                        'T', 0x1a, '\r', '\n'};  // text mode damages it

inline constexpr Field kMagicField{"magic", 0};
inline constexpr Field kVersion{"version", 8};
inline constexpr Field kHeaderLength{"header_bytes", 12};
inline constexpr Field kFileBytes{"file_bytes", 16};
inline constexpr Field kSections{"sections", 24};
inline constexpr Field kHeaderCrc{"header_crc", 28};
inline constexpr Field kVoxelSize{"voxel_size_m", 32};
inline constexpr Field kOrigin{"origin_m", 40};
inline constexpr Field kExtent{"extent", 64};
inline constexpr Field kDepth{"depth", 76};
inline constexpr Field kLevel{"level", 80};
inline constexpr Field kOctets{"octets", 84};
inline constexpr Field kVolumes{"volumes", 88};
inline constexpr Field kPatches{"patches", 92};
inline constexpr Field kHeightBlocks{"height_blocks", 96};
inline constexpr Field kRegions{"regions", 100};
inline constexpr Field kName{"name", 104};
inline constexpr Field kReservedEnd{"reserved", 168};

// Offsets inside an entry of the section table.
inline constexpr std::size_t kEntryKind = 0;
inline constexpr std::size_t kEntryFlags = 4;
inline constexpr std::size_t kEntryOffset = 8;
inline constexpr std::size_t kEntryBytesField = 16;
inline constexpr std::size_t kEntryCrc = 24;
inline constexpr std::size_t kEntryReserved = 28;
inline constexpr std::uint32_t kRequired =
    1;  // the flag bit: a reader that does not know the kind must refuse the file

constexpr std::uint32_t four_letters(const char (&s)[5]) {
  std::uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8 | static_cast<unsigned char>(s[i]);
  return value;
}

struct SectionKind {
  std::uint32_t letters;
  const char* name;
  bool required;   // must be there; the first kWorldSections are
  bool must_know;  // a reader that does not know it must refuse the file; the required ones too
  // Length that the header's counts decide; null: its contents do (material_section.h).
  std::uint64_t (*bytes)(const WorldInfo& info);
};
// By WorldSection.
extern const std::array<SectionKind, kWorldSectionKinds> kSectionKinds;

inline const SectionKind& kind_of(WorldSection section) {
  return kSectionKinds[static_cast<std::size_t>(section)];
}

template <class T>
T load(std::span<const std::byte> bytes, std::uint64_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + static_cast<std::size_t>(offset), sizeof value);
  return value;
}

template <class T>
void store(std::span<std::byte> bytes, std::uint64_t offset, T value) {
  std::memcpy(bytes.data() + static_cast<std::size_t>(offset), &value, sizeof value);
}

constexpr std::uint64_t align_up(std::uint64_t bytes) {
  return (bytes + kWorldSectionAlignment - 1) / kWorldSectionAlignment * kWorldSectionAlignment;
}

bool all_zero(std::span<const std::byte> bytes);

constexpr Status corrupt(const char* what, Field field) {
  return {StatusCode::corrupt, what, field.name, field.offset};
}

// --- Ranges of the fields, the same for reading and for writing

struct Fault {
  const char* what = nullptr;  // null: none
  Field field{"", 0};
};
Fault check_info(const WorldInfo& info);

// --- Contents: what a section must be like, the same for reading it whole, for checking it through a small
// buffer and for writing it.

// Of the sections that hold one entry a patch or block: keys, mask, samples, level errors, bounds, overrides.
// Others pass.
struct SectionFault {
  const char* what = nullptr;  // null: none
  std::uint64_t offset = 0;    // bytes from the section's start
};

class SectionCheck {
 public:
  // Bytes that hold whole entries of every kind: pieces of a section are multiples of it, but the last.
  static constexpr std::size_t kPiece = 24;

  // materials: of the world, for overrides.
  SectionCheck(WorldSection section, const WorldInfo& info, std::uint32_t materials);

  // The next bytes of the section, any alignment.
  SectionFault feed(std::span<const std::byte> bytes);
  // After the last ones: what the whole of them must add up to.
  SectionFault finish() const;

 private:
  SectionFault feed_keys(std::span<const std::byte> bytes);
  SectionFault feed_mask(std::span<const std::byte> bytes);
  SectionFault feed_level_errors(std::span<const std::byte> bytes);
  const char* key_fault(PatchKey key) const;

  WorldSection section_;
  const WorldInfo& info_;
  std::uint32_t materials_;
  std::uint64_t at_ = 0;     // bytes fed before
  std::uint64_t count_ = 0;  // volumes of the keys, bits of the mask
  std::uint64_t last_ = 0;   // bits of the last key, the last level error
};

// --- Places of sections

struct SectionPlace {
  std::uint64_t offset = 0;  // bytes from the start of the file
  std::uint64_t bytes = 0;
  std::uint32_t crc = 0;
  std::uint64_t entry = 0;  // offset of its entry in the section table
  bool present = false;
};
using SectionPlaces = std::array<SectionPlace, kWorldSectionKinds>;

// The order in which sections are written: tiles first, so that where they begin depends only on which
// sections there are.
std::array<WorldSection, kWorldSectionKinds> writing_order();

// Where the writer puts the sections. field_bytes: of its section, 0: none. Returns the file's length.
std::uint64_t lay_out(const WorldInfo& info, const WorldMaterials& materials, const WorldGround& ground,
                      std::uint64_t field_bytes, SectionPlaces& places);

// The header and the table over sections whose places and checksums are known; returns their length. out:
// kMostHead bytes.
std::size_t store_head(const WorldInfo& info, const SectionPlaces& places, std::uint64_t file_bytes,
                       std::span<std::byte> out);

// --- Reading. head: the file's first bytes, up to kMostHead of them.

// One entry of the section table, of a known kind or another.
struct Entry {
  std::uint64_t offset = 0;  // of the section
  std::uint64_t bytes = 0;
  std::uint32_t crc = 0;
  std::uint64_t gap = 0;  // where the zeros before the section begin
  std::uint64_t at = 0;   // of the entry itself
};
struct Table {
  std::array<Entry, kMaxSections> entries;
  std::size_t count = 0;
  SectionPlaces places;  // of the known ones
};

// All that the head tells: that this is a whole file of this version, the fields and the table.
// corrupt, unsupported as in world_file.h; an older version is unsupported and says to bake again.
Status read_head(std::span<const std::byte> head, std::uint64_t file_bytes, WorldInfo& info, Table& table);

}  // namespace karst::core::world_layout
