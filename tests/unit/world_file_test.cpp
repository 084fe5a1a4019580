// SPDX-License-Identifier: MIT
#include "terrain/file/world_reader.h"

#include "tests/support/world_bytes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <string>

namespace karst::core {
namespace {

using namespace world_offsets;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

void expect_same_info(const WorldInfo& a, const WorldInfo& b) {
  EXPECT_EQ(a.voxel_size_m, b.voxel_size_m);
  for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(a.origin_m[axis], b.origin_m[axis]);
  EXPECT_EQ(a.extent, b.extent);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.level, b.level);
  EXPECT_EQ(a.octets, b.octets);
  EXPECT_EQ(a.volumes, b.volumes);
  EXPECT_EQ(a.patches, b.patches);
  EXPECT_EQ(a.height_blocks, b.height_blocks);
  EXPECT_STREQ(a.name, b.name);
}

TEST(WorldFile, WhatIsWrittenIsReadAgain) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const TestWorld world(1 + static_cast<int>(seed % 5), 1 + static_cast<int>(seed % 6), seed);
    const std::vector<std::byte> file = world.bytes();
    WorldInfo info;
    const Status status = read_world_info(file, info);
    ASSERT_TRUE(status.ok()) << status.what() << " " << status.field() << " " << status.value();
    expect_same_info(info, world.info);

    TreeMemory copy(9, info.octets);
    ASSERT_TRUE(read_octree(file, copy.tree).ok());
    EXPECT_EQ(copy.tree.depth(), info.depth);
    EXPECT_EQ(copy.tree.octets_used(), info.octets);
    EXPECT_TRUE(same_nodes(copy.tree, copy.tree.root(), world.memory.tree, world.memory.tree.root()));

    const WorldPatches heights = read_patches(file);
    EXPECT_TRUE(std::equal(heights.keys.begin(), heights.keys.end(), world.keys.begin(), world.keys.end()));
    EXPECT_TRUE(std::equal(heights.mask.begin(), heights.mask.end(), world.mask.begin(), world.mask.end()));
    EXPECT_TRUE(std::equal(heights.samples.begin(), heights.samples.end(), world.samples.begin(),
                           world.samples.end()));
    EXPECT_TRUE(std::equal(heights.level_errors.begin(), heights.level_errors.end(), world.errors.begin(),
                           world.errors.end()));
    ASSERT_EQ(heights.bounds.size(), world.bounds.size());
    if (!heights.bounds.empty()) {
      EXPECT_EQ(std::memcmp(heights.bounds.data(), world.bounds.data(), heights.bounds.size_bytes()), 0);
    }

    // Written from what was read, it is the same file.
    std::vector<std::byte> again;
    ASSERT_TRUE(write_world({info, &copy.tree, heights}, again).ok());
    EXPECT_EQ(again, file);
  }
}

TEST(WorldFile, SectionsAreAlignedAndTheLayoutIsTheDocumentedOne) {
  const TestWorld world(4, 3, 5);
  const std::vector<std::byte> file = world.bytes();
  EXPECT_EQ(std::memcmp(file.data(), "KARST\x1a\r\n", 8), 0);
  EXPECT_EQ(load_at<std::uint32_t>(file, kVersion), 5u);
  EXPECT_EQ(load_at<std::uint32_t>(file, kHeaderBytes), 192u + 9 * 32);
  EXPECT_EQ(load_at<std::uint64_t>(file, kFileBytes), file.size());
  EXPECT_EQ(load_at<std::uint32_t>(file, kSections), 9u);
  EXPECT_EQ(load_at<double>(file, kVoxelSize), world.info.voxel_size_m);
  EXPECT_EQ(load_at<double>(file, kOrigin + 16), world.info.origin_m[2]);
  EXPECT_EQ(load_at<std::int32_t>(file, kExtent + 8), world.info.extent.z);
  EXPECT_EQ(load_at<std::int32_t>(file, kDepth), 4);
  EXPECT_EQ(load_at<std::int32_t>(file, kLevel), 3);
  EXPECT_EQ(load_at<std::uint32_t>(file, kOctets), world.info.octets);
  EXPECT_EQ(load_at<std::uint32_t>(file, kVolumes), world.info.volumes);
  EXPECT_EQ(load_at<std::uint32_t>(file, kPatches), world.info.patches);
  EXPECT_EQ(load_at<std::uint32_t>(file, kHeightBlocks), world.info.height_blocks);
  EXPECT_STREQ(reinterpret_cast<const char*>(file.data() + kName), "world 5");
  const char* const kinds[] = {"OCTR", "PKEY", "HMSK", "HGTS", "HCRC", "LERR", "PBND", "CONE", "SCON"};
  const std::size_t bytes[] = {2u * world.info.octets + 1,
                               world.info.patches * 8u,
                               (world.info.patches + 7) / 8,
                               world.info.height_blocks * 81u * 2u,
                               (world.info.height_blocks + 7) / 8 * 4u,
                               world.info.patches * 4u * 2u,
                               world.info.patches * 12u,
                               world.info.patches * 4u,
                               world.info.patches * 4u};
  std::size_t end = 192 + 9 * 32;
  for (std::size_t i = 0; i < 9; ++i) {
    const std::size_t entry = kTable + i * kEntry;
    EXPECT_EQ(std::memcmp(file.data() + entry, kinds[i], 4), 0);
    EXPECT_EQ(load_at<std::uint32_t>(file, entry + kEntryFlags), 1u);
    const auto offset = load_at<std::uint64_t>(file, entry + kEntryOffset);
    EXPECT_EQ(offset, (end + 63) / 64 * 64);
    EXPECT_EQ(load_at<std::uint64_t>(file, entry + kEntryBytes), bytes[i]);
    end = offset + bytes[i];
  }
  EXPECT_EQ(end, file.size());
}

// docs/formats.md lists the kinds of sections in the order of the code, by the same names.
TEST(WorldFile, TheDocumentedSectionsAreTheCodesSections) {
  std::ifstream text(KARST_SOURCE_DIR "/docs/formats.md");
  ASSERT_TRUE(text.good());
  std::string line;
  while (std::getline(text, line) && line != "| kind | section | bytes |") {
  }
  std::getline(text, line);
  std::size_t required = 0;
  for (const world_layout::SectionKind& kind : world_layout::kSectionKinds) {
    ASSERT_TRUE(std::getline(text, line));
    char letters[5] = {};
    std::memcpy(letters, &kind.letters, 4);
    EXPECT_EQ(line.find(std::string("| `") + letters + "` | " + kind.name + " | "), 0u) << line;
    required += kind.required ? 1u : 0u;
  }
  std::getline(text, line);
  EXPECT_EQ(line, "");
  EXPECT_EQ(required, 9u);  // as the text above the table says
}

// One field broken at a time: the writer and the reader both refuse it and name it.
struct Broken {
  const char* field;
  std::size_t offset;  // of the field in the file
  std::function<void(WorldInfo&)> spoil;
  std::function<void(std::span<std::byte>)> spoil_file;
};

template <class T>
Broken broken(const char* field, std::size_t offset, T WorldInfo::*member, T value) {
  return {field, offset, [=](WorldInfo& info) { info.*member = value; },
          [=](std::span<std::byte> file) { store_at(file, offset, value); }};
}

Broken broken_origin(std::size_t axis, double value) {
  return {"origin_m", kOrigin + 8 * axis, [=](WorldInfo& info) { info.origin_m[axis] = value; },
          [=](std::span<std::byte> file) { store_at(file, kOrigin + 8 * axis, value); }};
}

Broken broken_extent(int axis, std::int32_t value) {
  const std::size_t offset = kExtent + 4 * static_cast<std::size_t>(axis);
  return {"extent", offset, [=](WorldInfo& info) { info.extent[axis] = value; },
          [=](std::span<std::byte> file) { store_at(file, offset, value); }};
}

Broken broken_name(std::size_t at, char value) {
  return {"name", kName + at, [=](WorldInfo& info) { info.name[at] = value; },
          [=](std::span<std::byte> file) { store_at(file, kName + at, value); }};
}

std::vector<Broken> all_broken() {
  std::vector<Broken> list;
  for (const double bad : {0.0, -1.0, 0.9e-6, 1.1e9, kNan, kInfinity, -kInfinity}) {
    list.push_back(broken("voxel_size_m", kVoxelSize, &WorldInfo::voxel_size_m, bad));
  }
  for (const double bad : {1.1e12, -1.1e12, kNan, kInfinity, -kInfinity}) {
    for (std::size_t axis = 0; axis < 3; ++axis) list.push_back(broken_origin(axis, bad));
  }
  constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
  constexpr std::int32_t kLeast = std::numeric_limits<std::int32_t>::min();
  for (const std::int32_t bad : {0, -1, 17, kMost, kLeast}) {
    for (int axis = 0; axis < 3; ++axis) list.push_back(broken_extent(axis, bad));
  }
  list.push_back(broken_extent(0, 1));
  list.push_back(broken_extent(1, 16));
  list.push_back(broken_extent(2, 1));
  for (const std::int32_t bad : {0, -1, 10, kMost, kLeast}) {
    list.push_back(broken("depth", kDepth, &WorldInfo::depth, bad));
  }
  for (const std::int32_t bad : {0, -1, 7, kMost, kLeast}) {
    list.push_back(broken("level", kLevel, &WorldInfo::level, bad));
  }
  for (const std::uint32_t bad : {586u, 0x7fffffffu, 0x80000000u, 0xffffffffu}) {  // depth 4 has 585
    list.push_back(broken("octets", kOctets, &WorldInfo::octets, bad));
  }
  for (const std::uint32_t bad : {3376u, 0x80000000u, 0xffffffffu}) {
    list.push_back(broken("volumes", kVolumes, &WorldInfo::volumes, bad));
  }
  for (const std::uint32_t bad : {0u, 1000u, 0x1000001u, 0x80000000u, 0xffffffffu}) {
    list.push_back(broken("patches", kPatches, &WorldInfo::patches, bad));
  }
  for (const std::uint32_t bad : {1000u, 0x80000000u, 0xffffffffu}) {
    list.push_back(broken("height_blocks", kHeightBlocks, &WorldInfo::height_blocks, bad));
  }
  list.push_back(broken_name(2, '\n'));
  list.push_back(broken_name(0, '\x1b'));
  list.push_back(broken_name(3, '\x7f'));
  list.push_back(broken_name(1, '\x9b'));
  list.push_back(broken_name(63, 'x'));
  list.push_back(broken_name(20, 'x'));
  list.push_back({"name", kName, [](WorldInfo& info) { std::memset(info.name, 'x', kWorldNameBytes); },
                  [](std::span<std::byte> file) { std::memset(file.data() + kName, 'x', kWorldNameBytes); }});
  return list;
}

TEST(WorldFile, EveryFieldOutOfRangeIsNamed) {
  const TestWorld world(4, 2, 6);
  ASSERT_GT(world.info.volumes, 0u);
  const std::vector<std::byte> file = world.bytes();
  for (const Broken& bad : all_broken()) {
    WorldInfo info = world.info;
    bad.spoil(info);
    EXPECT_EQ(validate_world_info(info).code(), StatusCode::invalid_argument);
    EXPECT_STREQ(validate_world_info(info).field(), bad.field);
    std::vector<std::byte> out;
    EXPECT_STREQ(write_world({info, &world.memory.tree, world.patches()}, out).field(), bad.field);
    EXPECT_TRUE(out.empty());

    std::vector<std::byte> damaged = file;
    bad.spoil_file(damaged);
    WorldInfo untouched;
    untouched.depth = 77;
    EXPECT_STREQ(read_world_info(damaged, untouched).field(), "header_crc");
    fix_checksums(damaged);
    const Status status = read_world_info(damaged, untouched);
    EXPECT_EQ(status.code(), StatusCode::corrupt);
    EXPECT_STREQ(status.field(), bad.field);
    EXPECT_EQ(status.value(), bad.offset) << bad.field;
    EXPECT_EQ(untouched.depth, 77);
  }
}

TEST(WorldFile, LimitsThemselvesAreAccepted) {
  TestWorld world(4, 2, 7);
  world.info.voxel_size_m = 1e-6;
  world.info.origin_m[0] = 1e12;
  world.info.origin_m[1] = -1e12;
  std::memset(world.info.name, '~', 63);
  EXPECT_TRUE(validate_world_info(world.info).ok());
  world.info.voxel_size_m = 1e9;
  std::memset(world.info.name, 0, 64);
  world.info.extent = {16, 15, 16};
  const std::vector<std::byte> file = world.bytes();
  WorldInfo info;
  EXPECT_TRUE(read_world_info(file, info).ok());
  expect_same_info(info, world.info);
}

TEST(WorldFile, NothingButAWorldFileIsOne) {
  WorldInfo info;
  EXPECT_STREQ(read_world_info({}, info).field(), "magic");
  std::vector<std::byte> text(500, std::byte{'a'});
  EXPECT_STREQ(read_world_info(text, info).field(), "magic");

  std::vector<std::byte> file = TestWorld(3, 1, 8).bytes();
  for (const std::uint32_t version : {1u, 2u, 3u, 4u, 0u, 6u, 0xffffffffu}) {
    store_at(file, kVersion, version);
    fix_checksums(file);
    const Status status = read_world_info(file, info);
    EXPECT_EQ(status.code(), StatusCode::unsupported);
    EXPECT_STREQ(status.field(), "version");
    EXPECT_EQ(status.value(), kVersion);
    const std::string what = status.what();
    const bool older = version >= 1 && version <= 4;
    EXPECT_EQ(what.find("bake it again") != std::string::npos, older) << what;
    EXPECT_EQ(what.find("version " + std::to_string(version)) != std::string::npos, older) << what;
  }
}

TEST(WorldFile, BytesNeedNoAlignment) {
  const std::vector<std::byte> file = TestWorld(3, 1, 8).bytes();
  std::vector<std::byte> shifted(file.size() + 1);
  std::copy(file.begin(), file.end(), shifted.begin() + 1);
  WorldInfo info;
  EXPECT_TRUE(read_world_info(std::span(shifted).subspan(1), info).ok());
}

TEST(WorldFile, SectionTableFaultsAreNamed) {
  const TestWorld world(4, 2, 6);
  const std::vector<std::byte> file = world.bytes();
  const auto status_of = [&](const std::function<void(std::span<std::byte>)>& spoil) {
    std::vector<std::byte> damaged = file;
    spoil(damaged);
    fix_checksums(damaged);
    WorldInfo info;
    return read_world_info(damaged, info);
  };
  const auto expect = [&](const char* field, std::size_t offset, auto value) {
    const Status status = status_of([&](std::span<std::byte> bytes) { store_at(bytes, offset, value); });
    EXPECT_EQ(status.code(), StatusCode::corrupt) << field;
    EXPECT_STREQ(status.field(), field);
    EXPECT_EQ(status.value(), offset);
  };
  for (const std::uint32_t bad : {21u, 0x80000000u, 0xffffffffu}) expect("sections", kSections, bad);
  for (const std::uint32_t bad : {0u, 2u, 16u}) {
    EXPECT_STREQ(status_of([&](std::span<std::byte> bytes) { store_at(bytes, kSections, bad); }).field(),
                 "header_bytes");
  }
  for (const std::uint32_t bad : {0u, 191u, 224u, 0xffffffffu}) {
    std::vector<std::byte> damaged = file;
    store_at(damaged, kHeaderBytes, bad);
    WorldInfo info;
    EXPECT_STREQ(read_world_info(damaged, info).field(), "header_bytes");
  }
  for (const std::uint64_t bad :
       {std::uint64_t{0}, std::uint64_t{1} << 31, std::uint64_t{1} << 63, ~std::uint64_t{0}}) {
    expect("file_bytes", kFileBytes, bad);
    for (std::size_t i = 0; i < kWorldSections; ++i) {
      const std::size_t entry = kTable + i * kEntry;
      expect("section offset", entry + kEntryOffset, bad);
      if (bad != 0) expect("section bytes", entry + kEntryBytes, bad);
    }
  }
  expect("section flags", kTable + kEntryFlags, std::uint32_t{3});
  expect("section reserved", kTable + kEntryReserved, std::uint32_t{1});
  expect("regions", 100, std::uint32_t{1});
  expect("regions", 100, std::uint32_t{17});
  EXPECT_STREQ(status_of([](std::span<std::byte> bytes) { bytes[191] = std::byte{1}; }).field(), "reserved");
  // A kind that is there twice, and one that is missing because its place holds an optional stranger.
  EXPECT_STREQ(status_of([](std::span<std::byte> bytes) {
                 std::memcpy(bytes.data() + kTable + kEntry, "OCTR", 4);
               }).what(),
               "a section is there twice");
  const auto rename = [](std::uint32_t flags) {
    return [=](std::span<std::byte> bytes) {
      std::memcpy(bytes.data() + kTable + kEntry, "XTRA", 4);
      store_at(bytes, kTable + kEntry + kEntryFlags, flags);
    };
  };
  EXPECT_STREQ(status_of(rename(0)).what(), "a section is missing");
  EXPECT_STREQ(status_of(rename(0)).field(), "patch keys");
  EXPECT_EQ(status_of(rename(1)).code(), StatusCode::unsupported);
}

// The file with sections of kinds that no version has behind its own, each so long.
std::vector<std::byte> with_strangers(std::span<const std::byte> file, std::size_t count,
                                      std::size_t stranger_bytes) {
  // The header grows, so every section moves.
  const std::size_t old_header = kTable + kWorldSections * kEntry;
  const std::size_t sections = kWorldSections + count;
  const std::size_t new_header = kTable + sections * kEntry;
  std::vector<std::byte> longer(new_header);
  std::copy_n(file.begin(), old_header, longer.begin());
  for (std::size_t i = 0; i < sections; ++i) {
    const std::size_t entry = kTable + i * kEntry;
    const std::uint64_t bytes =
        i < kWorldSections ? load_at<std::uint64_t>(file, entry + kEntryBytes) : stranger_bytes;
    longer.resize((longer.size() + 63) / 64 * 64);
    store_at(longer, entry + kEntryOffset, std::uint64_t{longer.size()});
    store_at(longer, entry + kEntryBytes, bytes);
    if (i < kWorldSections) {
      const auto offset = load_at<std::uint64_t>(file, entry + kEntryOffset);
      longer.insert(longer.end(), file.begin() + static_cast<std::ptrdiff_t>(offset),
                    file.begin() + static_cast<std::ptrdiff_t>(offset + bytes));
    } else {
      std::memcpy(longer.data() + entry, "NEWS", 4);
      longer.resize(longer.size() + stranger_bytes, std::byte{0x5a});
    }
  }
  store_at(longer, kSections, static_cast<std::uint32_t>(sections));
  store_at(longer, kHeaderBytes, static_cast<std::uint32_t>(new_header));
  store_at(longer, kFileBytes, std::uint64_t{longer.size()});
  fix_checksums(longer);
  return longer;
}

TEST(WorldFile, OptionalSectionsOfLaterVersionsAreSkipped) {
  const TestWorld world(4, 2, 6);
  std::vector<std::byte> longer = with_strangers(world.bytes(), 1, 5);
  WorldInfo info;
  const Status status = read_world_info(longer, info);
  ASSERT_TRUE(status.ok()) << status.what() << " " << status.field();
  TreeMemory copy(4);
  EXPECT_TRUE(read_octree(longer, copy.tree).ok());
  EXPECT_EQ(read_patches(longer).samples.size(), world.samples.size());

  // The same section as a required one is more than this version can read.
  store_at(longer, kTable + kWorldSections * kEntry + kEntryFlags, std::uint32_t{1});
  fix_checksums(longer);
  EXPECT_EQ(read_world_info(longer, info).code(), StatusCode::unsupported);
  EXPECT_STREQ(read_world_info(longer, info).field(), "section kind");
}

// What nobody reads cannot keep a reader busy: too much of it is refused by the head alone.
TEST(WorldFile, SectionsOfUnknownKindsAreFewAndSmall) {
  const std::vector<std::byte> file = TestWorld(2, 1, 6).bytes();
  constexpr std::size_t kMost = 16u << 20;
  const auto status_of = [&](std::size_t count, std::size_t bytes) {
    const std::vector<std::byte> longer = with_strangers(file, count, bytes);
    std::uint64_t read = 0;
    struct Counted {
      std::span<const std::byte> bytes;
      std::uint64_t* read;
    } const counted{longer, &read};
    WorldReader reader;
    const Status status = reader.open(
        {longer.size(), &counted, [](const void* from, std::uint64_t at, std::span<std::byte> out) {
           const auto* const source = static_cast<const Counted*>(from);
           *source->read += out.size();
           std::copy_n(source->bytes.begin() + static_cast<std::ptrdiff_t>(at), out.size(), out.begin());
           return true;
         }});
    EXPECT_LT(read, 2'000u);
    return status;
  };
  EXPECT_TRUE(status_of(4, 5).ok());
  EXPECT_TRUE(status_of(1, kMost).ok());
  EXPECT_TRUE(status_of(4, kMost / 4).ok());
  EXPECT_EQ(status_of(5, 5).code(), StatusCode::unsupported);
  EXPECT_STREQ(status_of(5, 5).field(), "section kind");
  EXPECT_EQ(status_of(1, kMost + 1).code(), StatusCode::unsupported);
  EXPECT_STREQ(status_of(4, kMost / 4 + 1).field(), "section bytes");
}

TEST(WorldFile, ContentsThatContradictTheHeaderAreNamed) {
  const TestWorld world(4, 2, 6);
  const std::vector<std::byte> file = world.bytes();
  const auto start_of = [&](const char* section) {
    return load_at<std::uint64_t>(file, entry_of(file, section) + kEntryOffset);
  };
  WorldInfo info;

  std::vector<std::byte> damaged = file;
  damaged[start_of("HMSK")] ^= std::byte{1};
  EXPECT_STREQ(read_world_info(damaged, info).field(), "section crc");
  fix_checksums(damaged);
  EXPECT_STREQ(read_world_info(damaged, info).field(), "height mask");

  for (const int bad : {28'001, -28'001, 32'767, -32'768}) {
    damaged = file;
    const std::size_t at = start_of("HGTS") + 2 * (world.samples.size() - 3);
    store_at(damaged, at, static_cast<std::int16_t>(bad));
    fix_checksums(damaged);
    const Status status = read_world_info(damaged, info);
    EXPECT_STREQ(status.field(), "height samples");
    EXPECT_EQ(status.value(), at);
  }
  // Counts that are possible, but not with these sections.
  for (const std::size_t count : {kOctets, kPatches, kHeightBlocks}) {
    damaged = file;
    store_at(damaged, count, load_at<std::uint32_t>(file, count) - 1);
    fix_checksums(damaged);
    EXPECT_EQ(read_world_info(damaged, info).code(), StatusCode::corrupt);
  }
  // Between and after the sections.
  damaged = file;
  damaged[start_of("HMSK") - 1] = std::byte{1};
  EXPECT_STREQ(read_world_info(damaged, info).field(), "padding");
  damaged = file;
  damaged.resize(file.size() + 64);
  store_at(damaged, kFileBytes, std::uint64_t{damaged.size()});
  fix_checksums(damaged);
  EXPECT_STREQ(read_world_info(damaged, info).field(), "padding");
  EXPECT_EQ(read_world_info(damaged, info).value(), file.size());
}

// Two errors and two reaches a patch: each may rise from one row to the next, but not inside a row.
TEST(WorldFile, ErrorsThatRiseAreNamed) {
  const TestWorld world(4, 3, 6);
  ASSERT_GE(world.info.patches, 2u);
  const std::vector<std::byte> file = world.bytes();
  const std::size_t start = load_at<std::uint64_t>(file, entry_of(file, "LERR") + kEntryOffset);
  for (std::size_t at = 0; at < 8; ++at) {
    std::vector<std::byte> damaged = file;
    std::vector<std::uint16_t> errors(world.errors.size(), std::uint16_t{7});
    errors[at] = 8;
    std::memcpy(damaged.data() + start, errors.data(), errors.size() * 2);
    fix_checksums(damaged);
    WorldInfo info;
    const Status status = read_world_info(damaged, info);
    WorldPatches patches = world.patches();
    patches.level_errors = errors;
    std::vector<std::byte> out;
    const Status refused = write_world({world.info, &world.memory.tree, patches}, out);
    EXPECT_EQ(refused.ok(), at % 2 == 0);
    if (at % 2 == 0) {
      EXPECT_TRUE(status.ok()) << at;
      continue;
    }
    EXPECT_EQ(status.code(), StatusCode::corrupt);
    EXPECT_STREQ(status.field(), "level errors");
    EXPECT_EQ(status.value(), start + 2 * at);
    EXPECT_STREQ(refused.field(), "level_errors");
  }
}

TEST(WorldFile, BoxesTurnedInsideOutAreNamed) {
  const TestWorld world(4, 3, 6);
  std::vector<std::byte> damaged = world.bytes();
  const std::size_t start = load_at<std::uint64_t>(damaged, entry_of(damaged, "PBND") + kEntryOffset);
  std::vector<PatchBounds> bounds = world.bounds;
  bounds[1].min[2] = 5;
  bounds[1].max[2] = 4;
  std::memcpy(damaged.data() + start, bounds.data(), bounds.size() * sizeof(PatchBounds));
  fix_checksums(damaged);
  WorldInfo info;
  const Status status = read_world_info(damaged, info);
  EXPECT_EQ(status.code(), StatusCode::corrupt);
  EXPECT_STREQ(status.field(), "patch bounds");
  EXPECT_EQ(status.value(), start + sizeof(PatchBounds));
}

TEST(WorldFile, AGroupOfHeightsHasItsOwnChecksum) {
  const TestWorld world(4, 2, 6);
  std::vector<std::byte> damaged = world.bytes();
  const std::size_t start = load_at<std::uint64_t>(damaged, entry_of(damaged, "HCRC") + kEntryOffset);
  store_at(damaged, start + 4, load_at<std::uint32_t>(damaged, start + 4) ^ 1u);
  store_at(damaged, entry_of(damaged, "HCRC") + kEntryCrc,
           crc32c(std::span(damaged).subspan(start, (world.info.height_blocks + 7) / 8 * 4u)));
  const std::size_t header = kTable + kWorldSections * kEntry;
  store_at(damaged, kHeaderCrc,
           crc32c(std::span(damaged).subspan(kHeaderCrc + 4, header - kHeaderCrc - 4),
                  crc32c(std::span(damaged).first(kHeaderCrc))));
  WorldInfo info;
  const Status status = read_world_info(damaged, info);
  EXPECT_STREQ(status.field(), "height checksums");
  EXPECT_EQ(status.value(), start + 4);
}

TEST(WorldFile, OctreeFaultsAreNamedAndLeaveItEmpty) {
  // One octet: the root and its eight leaves, in 3 bytes; depth 1 so that the leaves are voxels.
  TreeMemory source(1);
  ASSERT_TRUE(source.tree.set({1, 0, 0}, 1, true).ok());
  WorldInfo info;
  info.extent = {2, 1, 2};
  info.depth = 1;
  info.level = 1;
  info.octets = 1;
  std::vector<std::byte> file;
  ASSERT_TRUE(write_world({info, &source.tree, {}}, file).ok());
  const std::size_t start = load_at<std::uint64_t>(file, kTable + kEntryOffset);
  // Root internal (2), then octants 0 and 1: 0, 1.
  ASSERT_EQ(file[start], std::byte{0b00'01'00'10});

  struct Case {
    std::size_t byte;
    unsigned value;
    const char* what;
  };
  const Case cases[] = {
      {0, 0b00'01'00'11, "a node of the octree is of no kind"},
      {0, 0b00'01'00'01, "a voxel outside the extent is filled"},
      {0, 0b00'01'00'00, "the octree has fewer nodes than its octets hold"},
      {0, 0b00'10'00'10, "the octree is deeper than its depth"},
      {0, 0b00'00'00'10, "eight equal leaves are not collapsed"},
      {0, 0b01'01'00'10, "a voxel outside the extent is filled"},
      {2, 0b00'00'01'00, "unused bits of the octree are not 0"},
  };
  TreeMemory copy(1);
  for (const Case& c : cases) {
    std::vector<std::byte> damaged = file;
    damaged[start + c.byte] = static_cast<std::byte>(c.value);
    fix_checksums(damaged);
    WorldInfo read;
    ASSERT_TRUE(read_world_info(damaged, read).ok());
    ASSERT_TRUE(copy.tree.set({0, 0, 0}, 1, true).ok());
    const Status status = read_octree(damaged, copy.tree);
    EXPECT_EQ(status.code(), StatusCode::corrupt);
    EXPECT_STREQ(status.what(), c.what);
    EXPECT_STREQ(status.field(), "octree");
    EXPECT_GE(status.value(), start);
    EXPECT_LT(status.value(), start + 3);
    EXPECT_EQ(copy.tree.root(), Octree::kEmpty);
    EXPECT_EQ(copy.tree.octets_used(), 0u);
  }

  TreeMemory none(1, 0);
  const Status full = read_octree(file, none.tree);
  EXPECT_EQ(full.code(), StatusCode::limit_reached);
  EXPECT_STREQ(full.field(), "max_octets");
  EXPECT_EQ(full.value(), 1u);
}

TEST(WorldFile, TheWriterRefusesWhatTheReaderWould) {
  const TestWorld world(4, 2, 6);
  const WorldPatches patches = world.patches();
  const Octree& tree = world.memory.tree;
  const auto field_of = [&](const WorldInfo& info, const Octree* octree, const WorldPatches& p) {
    std::vector<std::byte> out;
    const Status status = write_world({info, octree, p}, out);
    EXPECT_EQ(status.code(), StatusCode::invalid_argument);
    EXPECT_TRUE(out.empty());
    return std::string(status.field());
  };
  EXPECT_EQ(field_of(world.info, nullptr, patches), "octree");
  const TreeMemory deeper(5), empty(4);
  EXPECT_EQ(field_of(world.info, &deeper.tree, patches), "depth");
  EXPECT_EQ(field_of(world.info, &empty.tree, patches), "octree");
  WorldInfo info = world.info;
  info.octets -= 1;
  EXPECT_EQ(field_of(info, &tree, patches), "octree");
  info = world.info;
  info.extent.x = 2;
  info.volumes = 0;
  info.patches = 0;
  info.height_blocks = 0;
  EXPECT_EQ(field_of(info, &tree, {}), "octree");

  const auto spoilt = [&](auto WorldPatches::*member, auto values) {
    WorldPatches p = patches;
    p.*member = values;
    return field_of(world.info, &tree, p);
  };
  EXPECT_EQ(spoilt(&WorldPatches::keys, patches.keys.first(patches.keys.size() - 1)), "keys");
  EXPECT_EQ(spoilt(&WorldPatches::mask, patches.mask.first(patches.mask.size() - 1)), "mask");
  EXPECT_EQ(spoilt(&WorldPatches::samples, patches.samples.first(patches.samples.size() - 1)), "samples");
  EXPECT_EQ(spoilt(&WorldPatches::level_errors, patches.level_errors.first(0)), "level_errors");
  EXPECT_EQ(spoilt(&WorldPatches::bounds, patches.bounds.first(1)), "bounds");
  EXPECT_EQ(spoilt(&WorldPatches::cones, patches.cones.first(0)), "cones");
  EXPECT_EQ(spoilt(&WorldPatches::shading_cones, patches.cones.first(1)), "shading_cones");
  std::vector<PatchKey> keys = world.keys;
  std::swap(keys[0], keys[1]);
  EXPECT_EQ(spoilt(&WorldPatches::keys, std::span<const PatchKey>(keys)), "keys");
  std::vector<std::byte> mask = world.mask;
  mask[0] ^= std::byte{1};
  EXPECT_EQ(spoilt(&WorldPatches::mask, std::span<const std::byte>(mask)), "mask");
  std::vector<std::int16_t> samples = world.samples;
  samples.back() = -28'001;
  EXPECT_EQ(spoilt(&WorldPatches::samples, std::span<const std::int16_t>(samples)), "samples");
  std::vector<PatchBounds> bounds = world.bounds;
  bounds.back().min[1] = 7;
  bounds.back().max[1] = 6;
  EXPECT_EQ(spoilt(&WorldPatches::bounds, std::span<const PatchBounds>(bounds)), "bounds");
}

// Wherever the sink stops taking bytes, the writer says so, and nothing more is written.
TEST(WorldFile, ASinkThatStopsIsNamed) {
  const TestWorld world(4, 2, 6);
  const WorldWriter writer{world.info, &world.memory.tree, world.patches()};
  const std::size_t whole = writer.file_bytes();
  for (const std::size_t room : {std::size_t{0}, std::size_t{100}, std::size_t{600}, whole / 2, whole - 1}) {
    std::size_t taken = 0;
    bool stopped = false;
    const auto take = [&](std::span<const std::byte> bytes) {
      EXPECT_FALSE(stopped);
      stopped = taken + bytes.size() > room;
      if (!stopped) taken += bytes.size();
      return !stopped;
    };
    const Status status = writer.run(ByteSink::to(take));
    EXPECT_EQ(status.code(), StatusCode::limit_reached);
    EXPECT_STREQ(status.field(), "sink");
    EXPECT_LE(taken, room);
  }
}

// Keys, in the words of docs/formats.md: each broken in one way is refused where it lies.
TEST(WorldFile, KeysThatCannotBeAreNamed) {
  const TestWorld world(4, 2, 6);
  ASSERT_GE(world.info.volumes, 3u);
  const std::vector<std::byte> file = world.bytes();
  const std::size_t start = load_at<std::uint64_t>(file, entry_of(file, "PKEY") + kEntryOffset);
  const auto expect = [&](std::size_t index, std::uint64_t bits, const char* what) {
    std::vector<std::byte> damaged = file;
    store_at(damaged, start + 8 * index, bits);
    fix_checksums(damaged);
    WorldInfo info;
    const Status whole = read_world_info(damaged, info);
    WorldReader reader;
    ASSERT_TRUE(reader.open(ByteSource::of(damaged)).ok());
    std::vector<PatchKey> keys(world.info.patches);
    for (const Status& status : {whole, reader.read_keys(keys)}) {
      EXPECT_EQ(status.code(), StatusCode::corrupt);
      EXPECT_STREQ(status.field(), "patch keys");
      EXPECT_EQ(status.value(), start + 8 * index) << what;
      EXPECT_NE(std::string(status.what()).find(what), std::string::npos) << status.what();
    }
  };
  const std::size_t last = world.keys.size() - 1;
  const std::uint64_t top = world.keys[last].bits();
  expect(2, world.keys[1].bits(), "not above");
  expect(2, world.keys[0].bits(), "not above");
  expect(0, PatchKey::make(0, 0, 1, 1, 0).bits(), "outside");
  expect(0, 0, "not above");
  expect(last, PatchKey::make(0, 1023, 1023, 1023, 0).bits(), "outside");
  expect(last, top | std::uint64_t{1} << 33, "region");
  expect(last, top | std::uint64_t{1} << 63, "region");
  expect(last, top + 3, "no such case");
  expect(last, top + 1, "follow");
  expect(0, world.keys[0].bits() + 1, "follow");
  // As many patches, but a volume less.
  std::vector<std::byte> damaged = file;
  store_at(damaged, kVolumes, world.info.volumes - 1);
  fix_checksums(damaged);
  WorldInfo info;
  const Status status = read_world_info(damaged, info);
  EXPECT_STREQ(status.field(), "patch keys");
  EXPECT_EQ(status.value(), start);
}

}  // namespace
}  // namespace karst::core
