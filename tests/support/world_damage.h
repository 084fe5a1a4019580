// SPDX-License-Identifier: MIT
// Ways to damage the bytes of a world file. Needs no GoogleTest, so that libFuzzer can use it too.
#pragma once

#include "terrain/base/checksum.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace karst::core {

// Byte offsets of docs/formats.md, typed in again: a reader that moved a field must fail the tests.
namespace world_offsets {
inline constexpr std::size_t kVersion = 8;
inline constexpr std::size_t kHeaderBytes = 12;
inline constexpr std::size_t kFileBytes = 16;
inline constexpr std::size_t kSections = 24;
inline constexpr std::size_t kHeaderCrc = 28;
inline constexpr std::size_t kVoxelSize = 32;
inline constexpr std::size_t kOrigin = 40;
inline constexpr std::size_t kExtent = 64;
inline constexpr std::size_t kDepth = 76;
inline constexpr std::size_t kLevel = 80;
inline constexpr std::size_t kOctets = 84;
inline constexpr std::size_t kVolumes = 88;
inline constexpr std::size_t kPatches = 92;
inline constexpr std::size_t kHeightBlocks = 96;
inline constexpr std::size_t kName = 104;
inline constexpr std::size_t kTable = 192;
inline constexpr std::size_t kEntry = 32;
inline constexpr std::size_t kEntryFlags = 4;
inline constexpr std::size_t kEntryOffset = 8;
inline constexpr std::size_t kEntryBytes = 16;
inline constexpr std::size_t kEntryCrc = 24;
inline constexpr std::size_t kEntryReserved = 28;
}  // namespace world_offsets

template <class T>
T load_at(std::span<const std::byte> bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

template <class T>
void store_at(std::span<std::byte> bytes, std::size_t offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
}

// Offset of the section table's entry of a kind, or 0 where there is none.
inline std::size_t entry_of(std::span<const std::byte> file, const char* letters) {
  using namespace world_offsets;
  if (file.size() < kTable) return 0;
  const std::uint64_t sections = load_at<std::uint32_t>(file, kSections);
  for (std::size_t i = 0; i < sections && kTable + (i + 1) * kEntry <= file.size(); ++i) {
    if (std::memcmp(file.data() + kTable + i * kEntry, letters, 4) == 0) return kTable + i * kEntry;
  }
  return 0;
}

// The bytes that an entry names, where they lie inside the file.
inline std::span<const std::byte> section_at(std::span<const std::byte> file, std::size_t entry) {
  using namespace world_offsets;
  if (entry == 0) return {};
  const auto offset = load_at<std::uint64_t>(file, entry + kEntryOffset);
  const auto bytes = load_at<std::uint64_t>(file, entry + kEntryBytes);
  if (offset > file.size() || bytes > file.size() - offset) return {};
  return file.subspan(offset, bytes);
}

inline std::span<const std::byte> section_of(std::span<const std::byte> file, const char* letters) {
  return section_at(file, entry_of(file, letters));
}

// Of groups of heights: eight blocks each, at the level that the header states.
inline void fix_group_checksums(std::span<std::byte> file, std::uint64_t sections) {
  using namespace world_offsets;
  const auto level = load_at<std::int32_t>(file, kLevel);
  if (level < 1 || level > 6) return;
  std::span<std::byte> samples;
  std::span<std::byte> crcs;
  for (std::size_t i = 0; i < sections; ++i) {
    const std::size_t entry = kTable + i * kEntry;
    const auto offset = load_at<std::uint64_t>(file, entry + kEntryOffset);
    const auto bytes = load_at<std::uint64_t>(file, entry + kEntryBytes);
    if (offset > file.size() || bytes > file.size() - offset) continue;
    if (std::memcmp(file.data() + entry, "HGTS", 4) == 0) samples = file.subspan(offset, bytes);
    if (std::memcmp(file.data() + entry, "HCRC", 4) == 0 && offset >= kTable)
      crcs = file.subspan(offset, bytes);
  }
  const std::size_t side = (std::size_t{1} << level) + 1;
  for (std::size_t at = 0; at + 4 <= crcs.size() && !samples.empty(); at += 4) {
    const std::span<std::byte> group = samples.first(std::min(samples.size(), 8 * side * side * 2));
    store_at(crcs, at, crc32c(group));
    samples = samples.subspan(group.size());
  }
}

// Of texture images: as many as fit what MATL says and what MTEX holds.
inline void fix_image_checksums(std::span<std::byte> file, std::uint64_t sections) {
  using namespace world_offsets;
  std::span<std::byte> materials;
  std::span<std::byte> textures;
  for (std::size_t i = 0; i < sections; ++i) {
    const std::size_t entry = kTable + i * kEntry;
    const auto offset = load_at<std::uint64_t>(file, entry + kEntryOffset);
    const auto bytes = load_at<std::uint64_t>(file, entry + kEntryBytes);
    if (offset > file.size() || bytes > file.size() - offset) continue;
    if (std::memcmp(file.data() + entry, "MATL", 4) == 0 && offset >= kTable)
      materials = file.subspan(offset, bytes);
    if (std::memcmp(file.data() + entry, "MTEX", 4) == 0) textures = file.subspan(offset, bytes);
  }
  if (materials.size() < 16) return;
  const auto count = load_at<std::uint32_t>(materials, 0);
  const auto side = load_at<std::uint32_t>(materials, 4);
  const auto format = load_at<std::uint32_t>(materials, 8);
  if (count < 1 || count > 8 || side < 16 || side > 1024 || (side & (side - 1)) != 0 || format > 1) return;
  std::size_t crc = 16 + count * 84;
  for (const bool far : {true, false}) {
    for (std::size_t texels = far ? side / 2 : side; texels > 0; texels /= 2) {
      const std::size_t blocks = (texels + 3) / 4;
      const std::size_t image = format == 0 ? texels * texels * 4
                                : far       ? blocks * blocks * 16
                                            : texels * texels * 2;
      for (std::uint32_t layer = 0; layer < count; ++layer) {
        if (crc + 4 > materials.size() || image > textures.size()) return;
        store_at(materials, crc, crc32c(textures.first(image)));
        crc += 4;
        textures = textures.subspan(image);
      }
    }
  }
}

// Makes the checksums fit whatever the bytes say now, as far as they lie inside, so that damage reaches the
// checks behind them.
inline void fix_checksums(std::span<std::byte> file) {
  using namespace world_offsets;
  if (file.size() < kTable) return;
  std::uint64_t sections = load_at<std::uint32_t>(file, kSections);
  sections = std::min<std::uint64_t>(sections, (file.size() - kTable) / kEntry);
  fix_group_checksums(file, sections);
  fix_image_checksums(file, sections);
  for (std::size_t i = 0; i < sections; ++i) {
    const std::size_t entry = kTable + i * kEntry;
    const auto offset = load_at<std::uint64_t>(file, entry + kEntryOffset);
    const auto bytes = load_at<std::uint64_t>(file, entry + kEntryBytes);
    if (offset > file.size() || bytes > file.size() - offset) continue;
    store_at(file, entry + kEntryCrc, crc32c(file.subspan(offset, bytes)));
  }
  const std::uint64_t header = load_at<std::uint32_t>(file, kHeaderBytes);
  if (header < kTable || header > file.size()) return;
  const std::uint32_t before = crc32c(file.first(kHeaderCrc));
  store_at(file, kHeaderCrc, crc32c(file.subspan(kHeaderCrc + 4, header - kHeaderCrc - 4), before));
}

}  // namespace karst::core
