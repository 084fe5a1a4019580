// SPDX-License-Identifier: MIT
// Deterministic mutation fuzzing of the world file. Most cases get checksums that fit, or they would all end
// at the first check; sanitizer builds turn any read outside the file into a failure.
#include "tests/fuzz/run/seed_worlds.h"
#include "tests/fuzz/world_file_target.h"
#include "tests/support/world_bytes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

namespace karst::core {
namespace {

using namespace world_offsets;

struct Tally {
  int rejected = 0;
  int header = 0;
  int octree = 0;

  void add(Reached reached) {
    rejected += reached == Reached::rejected;
    header += reached == Reached::header;
    octree += reached == Reached::octree;
  }
  int all() const { return rejected + header + octree; }
};

const std::vector<std::byte>& small_file() {
  static const std::vector<std::byte> file = TestWorld(3, 1, 12).bytes();
  return file;
}

// The same with two materials of 16 x 16 texels, overrides, a light and a blend map.
const std::vector<std::byte>& material_file() {
  static const std::vector<std::byte> file = [] {
    TestWorld world(3, 1, 12);
    world.add_materials(2, 16, TextureFormat::etc2, 1, 5);
    world.add_blend_map(5, 3, 6);
    return world.bytes();
  }();
  return file;
}

// Depth 3 and level 1: the header, a few octets, a mask of some bytes and some blocks of nine samples.
TEST(WorldFileFuzz, TheSeedItselfIsAccepted) {
  EXPECT_EQ(fuzz_world_file(small_file()), Reached::octree);
  EXPECT_GT(TestWorld(3, 1, 12).info.height_blocks, 0u);
  EXPECT_GT(TestWorld(3, 1, 12).info.octets, 1u);
}

TEST(WorldFileFuzz, EveryTruncationIsRejected) {
  const std::vector<std::byte>& file = small_file();
  for (std::size_t length = 0; length < file.size(); ++length) {
    std::vector<std::byte> cut(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(length));
    ASSERT_EQ(fuzz_world_file(cut), Reached::rejected) << length;
    fix_checksums(cut);
    ASSERT_EQ(fuzz_world_file(cut), Reached::rejected) << length;
    if (length < kTable) continue;
    store_at(cut, kFileBytes, std::uint64_t{length});
    fix_checksums(cut);
    ASSERT_EQ(fuzz_world_file(cut), Reached::rejected) << length;
  }
}

TEST(WorldFileFuzz, EveryFlippedBitIsRejected) {
  std::vector<std::byte> file = small_file();
  for (std::size_t bit = 0; bit < file.size() * 8; ++bit) {
    const auto mask = static_cast<std::byte>(1u << bit % 8);
    file[bit / 8] ^= mask;
    ASSERT_EQ(fuzz_world_file(file), Reached::rejected) << "bit " << bit;
    file[bit / 8] ^= mask;
  }
}

TEST(WorldFileFuzz, FlippedBitsBehindTheChecksums) {
  Tally tally;
  for (std::size_t bit = 0; bit < small_file().size() * 8; ++bit) {
    std::vector<std::byte> file = small_file();
    file[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
    fix_checksums(file);
    tally.add(fuzz_world_file(file));
  }
  // Some bits only change a number to another possible one, and some only the octree.
  EXPECT_GT(tally.rejected, 500);
  EXPECT_GT(tally.header, 50);
  EXPECT_GT(tally.octree, 500);
}

TEST(WorldFileFuzz, MaterialsFlippedAndCut) {
  EXPECT_EQ(fuzz_world_file(material_file()), Reached::octree);
  std::vector<std::byte> file = material_file();
  Tally tally;
  for (std::size_t bit = 0; bit < file.size() * 8; ++bit) {
    const auto mask = static_cast<std::byte>(1u << bit % 8);
    file[bit / 8] ^= mask;
    ASSERT_EQ(fuzz_world_file(file), Reached::rejected) << "bit " << bit;
    std::vector<std::byte> fixed = file;
    fix_checksums(fixed);
    tally.add(fuzz_world_file(fixed));
    file[bit / 8] ^= mask;
  }
  EXPECT_GT(tally.rejected, 1'000);
  EXPECT_GT(tally.octree, 1'000);
  for (std::size_t length = 0; length < file.size(); ++length) {
    std::vector<std::byte> cut(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(length));
    if (length >= kTable) store_at(cut, kFileBytes, std::uint64_t{length});
    fix_checksums(cut);
    ASSERT_EQ(fuzz_world_file(cut), Reached::rejected) << length;
  }
}

// A ground with imagery: what says where tiles and image tiles lie, with checksums that fit.
TEST(WorldFileFuzz, GroundAndImageryFlipped) {
  const std::vector<std::byte> seed = seed_worlds()[3];
  EXPECT_EQ(fuzz_world_file(seed), Reached::octree);
  for (const char* const letters : {"GRND", "IMAG"}) {
    const std::span<const std::byte> section = section_of(seed, letters);
    ASSERT_FALSE(section.empty()) << letters;
    const auto first = static_cast<std::size_t>(section.data() - seed.data());
    std::vector<std::byte> file = seed;
    Tally tally;
    for (std::size_t bit = first * 8; bit < (first + section.size()) * 8; ++bit) {
      const auto mask = static_cast<std::byte>(1u << bit % 8);
      file[bit / 8] ^= mask;
      ASSERT_EQ(fuzz_world_file(file), Reached::rejected) << letters << " bit " << bit - first * 8;
      std::vector<std::byte> fixed = file;
      fix_checksums(fixed);
      tally.add(fuzz_world_file(fixed));
      file[bit / 8] ^= mask;
    }
    // Checksums of tiles and numbers that nothing hangs on may be any.
    EXPECT_GT(tally.rejected, 20) << letters;
    EXPECT_EQ(tally.all(), static_cast<int>(8 * section.size()));
  }
}

// A region, and two: each seed is read down to its octrees, and whatever says where they stand and how many
// of what they hold is refused, or is a world that can be written and read again.
TEST(WorldFileFuzz, RegionsFlipped) {
  const std::vector<std::vector<std::byte>> seeds = seed_worlds();
  for (std::size_t n = 0; n < seeds.size(); ++n) {
    WorldInfo info;
    ASSERT_TRUE(read_world_info(seeds[n], info).ok()) << n;
    EXPECT_EQ(fuzz_world_file(seeds[n]), Reached::octree) << n;
    const std::span<const std::byte> section = section_of(seeds[n], "REGN");
    EXPECT_EQ(section.size(), n < 4 || n > 5 ? 0u : n == 4 ? 16u : 96u);
    if (section.empty()) continue;
    EXPECT_EQ(info.regions, n - 3);
    const auto first = static_cast<std::size_t>(section.data() - seeds[n].data());
    Tally tally;
    for (std::size_t bit = first * 8; bit < (first + section.size()) * 8; ++bit) {
      std::vector<std::byte> file = seeds[n];
      file[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
      ASSERT_EQ(fuzz_world_file(file), Reached::rejected) << n << " bit " << bit - first * 8;
      fix_checksums(file);
      tally.add(fuzz_world_file(file));
    }
    // Other places and other edges of a rim are as good.
    EXPECT_GT(tally.rejected, 60) << n;
    EXPECT_GT(tally.octree, 4) << n;
  }
}

// The field of an isosurface: its header, what its blocks are, and a part of the samples.
TEST(WorldFileFuzz, FieldFlipped) {
  const std::vector<std::byte> seed = seed_worlds()[6];
  EXPECT_EQ(fuzz_world_file(seed), Reached::octree);
  const std::span<const std::byte> section = section_of(seed, "FELD");
  ASSERT_EQ(section.size(), 64 + 3 + 4096u);
  const auto first = static_cast<std::size_t>(section.data() - seed.data());
  Tally tally;
  for (std::size_t bit = first * 8; bit < (first + 100) * 8; ++bit) {
    std::vector<std::byte> file = seed;
    file[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
    ASSERT_EQ(fuzz_world_file(file), Reached::rejected) << "bit " << bit - first * 8;
    fix_checksums(file);
    tally.add(fuzz_world_file(file));
  }
  // Reserved bytes, sizes, kinds; where it lies, how far samples reach and what they are may be any.
  EXPECT_GT(tally.rejected, 300);
  EXPECT_GT(tally.octree, 33 * 8);
}

// Its materials: how many blocks have some, which, and a part of theirs.
TEST(WorldFileFuzz, FieldMaterialsFlipped) {
  const std::vector<std::byte> seed = seed_worlds()[7];
  EXPECT_EQ(fuzz_world_file(seed), Reached::octree);
  const std::span<const std::byte> section = section_of(seed, "FELD");
  const std::size_t fillings = 64 + 3 + 4096;
  ASSERT_EQ(section.size(), fillings + 3 + 4096);
  const auto first = static_cast<std::size_t>(section.data() - seed.data());
  Tally header, codes;
  const auto flip = [&](std::size_t bit, Tally& tally) {
    std::vector<std::byte> file = seed;
    file[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
    fix_checksums(file);
    tally.add(fuzz_world_file(file));
  };
  for (std::size_t bit = (first + 40) * 8; bit < (first + 64) * 8; ++bit) flip(bit, header);
  EXPECT_EQ(header.octree, 0);
  for (std::size_t bit = (first + fillings) * 8; bit < (first + fillings + 60) * 8; ++bit) flip(bit, codes);
  // There are two materials: most other codes are of those that are not there.
  EXPECT_GT(codes.rejected, 200);
  EXPECT_GT(codes.octree, 50);
}

// Numbers that mean something, in every field of the sections of materials, overrides and lights.
TEST(WorldFileFuzz, InterestingNumbersInMaterials) {
  std::vector<std::uint32_t> values;
  for (int bits = 0; bits < 32; ++bits) {
    for (const std::uint32_t d : {~std::uint32_t{0}, std::uint32_t{0}, std::uint32_t{1}})
      values.push_back((std::uint32_t{1} << bits) + d);
  }
  for (const float f : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                        -std::numeric_limits<float>::infinity(), -0.0f, 1e-4f, -1.0f, 1e6f, 0.5f})
    values.push_back(std::bit_cast<std::uint32_t>(f));
  Tally tally;
  for (const char* section : {"MATL", "MOVR", "LGTS", "BMAP"}) {
    const std::size_t entry = entry_of(material_file(), section);
    const auto start = load_at<std::uint64_t>(material_file(), entry + kEntryOffset);
    const auto bytes =
        std::min<std::uint64_t>(load_at<std::uint64_t>(material_file(), entry + kEntryBytes), 144);
    for (std::size_t offset = start; offset + 4 <= start + bytes; offset += 4) {
      for (const std::uint32_t value : values) {
        std::vector<std::byte> file = material_file();
        store_at(file, offset, value);
        fix_checksums(file);
        tally.add(fuzz_world_file(file));
      }
    }
  }
  EXPECT_GT(tally.rejected, 1'000);
  EXPECT_GT(tally.octree, 100);
}

TEST(WorldFileFuzz, InterestingNumbersInEveryField) {
  std::vector<std::uint64_t> values;
  for (int bits = 0; bits < 64; ++bits) {
    for (const std::uint64_t d : {~std::uint64_t{0}, std::uint64_t{0}, std::uint64_t{1}}) {
      values.push_back((std::uint64_t{1} << bits) + d);
    }
  }
  for (const double d : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                         -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::denorm_min(),
                         -0.0, std::numeric_limits<double>::max(), 1e-6, 1e9, -1e12}) {
    values.push_back(std::bit_cast<std::uint64_t>(d));
  }
  Tally tally;
  const std::size_t header = kTable + 4 * kEntry;
  for (std::size_t offset = kVersion; offset < header; offset += 4) {
    for (const std::uint64_t value : values) {
      std::vector<std::byte> file = small_file();
      store_at(file, offset, static_cast<std::uint32_t>(value));
      fix_checksums(file);
      tally.add(fuzz_world_file(file));
      if (offset % 8 != 0) continue;
      store_at(file, offset, value);
      fix_checksums(file);
      tally.add(fuzz_world_file(file));
    }
  }
  EXPECT_GT(tally.all(), 15'000);
  EXPECT_GT(tally.octree, 100);
}

// Counts, depth and extent changed together, so that they fit one another more often than by chance.
void mutate_header(std::vector<std::byte>& file, TestRandom& random) {
  switch (random.below(6)) {
    case 0:
      store_at(file, kDepth, random.range(1, 9));
      break;
    case 1:
      store_at(file, kExtent + 4 * random.below(3), random.range(1, 12));
      break;
    case 2:
      store_at(file, kLevel, random.range(0, 7));
      break;
    case 3: {
      const std::size_t field = kOctets + 4 * random.below(4);
      store_at(file, field, load_at<std::uint32_t>(file, field) + random.below(5) - 2);
      break;
    }
    case 4: {
      const std::size_t entry = kTable + kEntry * random.below(kWorldSections);
      const std::size_t field = entry + (random.chance(0.5) ? kEntryOffset : kEntryBytes);
      const auto change = static_cast<std::uint64_t>(random.range(-2, 2)) * (random.chance(0.5) ? 64 : 1);
      store_at(file, field, load_at<std::uint64_t>(file, field) + change);
      break;
    }
    default:
      store_at(file, kSections, random.below(kWorldSections + 1));
      break;
  }
}

void mutate_bytes(std::vector<std::byte>& file, TestRandom& random) {
  const auto size = static_cast<std::uint32_t>(file.size());
  const std::size_t at = random.below(size);
  const std::size_t run = std::min<std::size_t>(1 + random.below(16), size - at);
  const auto first = file.begin() + static_cast<std::ptrdiff_t>(at);
  const auto end = first + static_cast<std::ptrdiff_t>(run);
  switch (random.below(5)) {
    case 0:
      std::for_each(first, end, [&](std::byte& b) { b = static_cast<std::byte>(random.below(256)); });
      break;
    case 1:
      std::fill(first, end, static_cast<std::byte>(random.chance(0.5) ? 0xff : 0));
      break;
    case 2:
      file.erase(first, end);
      break;
    case 3:
      file.insert(first, run, static_cast<std::byte>(random.below(256)));
      break;
    default:
      std::copy(first, end, file.begin() + random.below(size - static_cast<std::uint32_t>(run) + 1));
      break;
  }
}

TEST(WorldFileFuzz, RandomMutations) {
  TestRandom random(13);
  Tally tally;
  for (int round = 0; round < 100'000; ++round) {
    std::vector<std::byte> file = round % 4 == 0 ? material_file() : small_file();
    const int steps = random.range(1, 4);
    for (int step = 0; step < steps && file.size() >= kTable + kWorldSections * kEntry; ++step) {
      if (random.chance(0.4)) {
        mutate_header(file, random);
      } else {
        mutate_bytes(file, random);
      }
    }
    if (file.size() >= kTable && random.chance(0.8)) store_at(file, kFileBytes, std::uint64_t{file.size()});
    fix_checksums(file);
    tally.add(fuzz_world_file(file));
  }
  EXPECT_GT(tally.rejected, 10'000);
  EXPECT_GT(tally.header, 1'000);
  EXPECT_GT(tally.octree, 100);
}

// Whole octree sections of random nodes, in headers that promise them: the decoder must bound its own walk.
TEST(WorldFileFuzz, RandomOctrees) {
  TestRandom random(14);
  Tally tally;
  for (int round = 0; round < 6'000; ++round) {
    WorldInfo info;
    info.depth = random.range(1, 9);
    const int size = 1 << info.depth;
    info.extent = {size, size - 1, size};
    info.level = 1;
    TreeMemory empty(info.depth, 1);
    std::vector<std::byte> file;
    ASSERT_TRUE(write_world({info, &empty.tree, {}}, file).ok());
    const std::uint32_t full = ((1u << (3 * info.depth)) - 1) / 7;
    const std::uint32_t octets = random.below(std::min(full, 1500u) + 1);
    const double internal = random.chance(0.3) ? 1.0 : random.chance(0.5) ? 0.125 : 0.3;
    const auto start = static_cast<std::size_t>(load_at<std::uint64_t>(file, kTable + kEntryOffset));
    file.resize(start);
    std::uint32_t at = 0;
    std::vector<std::byte> section(2 * std::size_t{octets} + 1);
    for (std::uint32_t node = 0; node < 1 + 8 * octets; ++node) {
      unsigned code = random.below(2);
      if (at < octets && (node == 0 || random.chance(internal))) {
        code = 2;
        ++at;
      } else if (random.chance(0.001)) {
        code = 3;
      }
      section[node / 4] |= static_cast<std::byte>(code << (node % 4 * 2));
    }
    file.insert(file.end(), section.begin(), section.end());
    store_at(file, kOctets, octets);
    store_at(file, kTable + kEntryBytes, std::uint64_t{section.size()});
    file.resize((file.size() + 63) / 64 * 64);
    for (std::size_t i = 1; i < kWorldSections; ++i)
      store_at(file, kTable + i * kEntry + kEntryOffset, std::uint64_t{file.size()});
    store_at(file, kFileBytes, std::uint64_t{file.size()});
    fix_checksums(file);
    const Reached reached = fuzz_world_file(file);
    EXPECT_NE(reached, Reached::rejected);
    tally.add(reached);
  }
  EXPECT_GT(tally.header, 3'000);
  EXPECT_GT(tally.octree, 100);
}

TEST(WorldFileFuzz, Noise) {
  TestRandom random(15);
  for (int round = 0; round < 2'000; ++round) {
    std::vector<std::byte> bytes(random.below(1'000));
    for (std::byte& b : bytes) b = static_cast<std::byte>(random.below(256));
    if (bytes.size() >= kTable) {
      std::copy_n(small_file().begin(), random.below(kTable), bytes.begin());
      fix_checksums(bytes);
    }
    EXPECT_EQ(fuzz_world_file(bytes), Reached::rejected);
  }
}

}  // namespace
}  // namespace karst::core
