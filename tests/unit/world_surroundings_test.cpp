// SPDX-License-Identifier: MIT
// What is around a world, in its file.
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "terrain/shading/surroundings.h"
#include "tests/support/world_bytes.h"

namespace karst::core {
namespace {

using namespace world_offsets;

const std::vector<glm::ivec3> kRim = {{4096, 9000, 4096}, {28'672, -70, 4096}, {1 << 23, 5, -(1 << 23)}};

WorldMaterials around(std::span<const glm::ivec3> rim) {
  WorldMaterials materials;
  materials.surroundings = {kHasWater, 3.25f, -0.5f, static_cast<std::uint32_t>(rim.size())};
  materials.rim = rim;
  return materials;
}

std::vector<std::byte> file_with(const TestWorld& world, const WorldMaterials& materials) {
  std::vector<std::byte> file;
  const Status status = write_world({world.info, &world.memory.tree, world.patches(), materials}, file);
  EXPECT_TRUE(status.ok()) << status.what() << ' ' << status.field();
  return file;
}

std::size_t start_of_section(std::span<const std::byte> file) {
  return static_cast<std::size_t>(load_at<std::uint64_t>(file, entry_of(file, "SURR") + kEntryOffset));
}

TEST(Surroundings, AreReadAsTheyWereWritten) {
  const TestWorld world(4, 3, 1);
  const std::vector<std::byte> file = file_with(world, around(kRim));
  WorldInfo info;
  ASSERT_TRUE(read_world_info(file, info).ok());
  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
  EXPECT_TRUE(reader.surroundings().has_water());
  EXPECT_EQ(reader.surroundings().water_level, 3.25f);
  EXPECT_EQ(reader.surroundings().plain_level, -0.5f);
  std::vector<glm::ivec3> rim(3);
  ASSERT_TRUE(reader.read_rim(rim).ok());
  EXPECT_EQ(rim, kRim);
  EXPECT_EQ(reader.read_rim(std::span(rim).first(2)).code(), StatusCode::invalid_argument);
  // As documented: 16 bytes, then 12 a point.
  const std::size_t at = start_of_section(file);
  EXPECT_EQ(section_of(file, "SURR").size(), 16u + 3 * 12);
  EXPECT_EQ(load_at<std::uint32_t>(file, at), 1u);
  EXPECT_EQ(load_at<float>(file, at + 4), 3.25f);
  EXPECT_EQ(load_at<float>(file, at + 8), -0.5f);
  EXPECT_EQ(load_at<std::uint32_t>(file, at + 12), 3u);
  EXPECT_EQ(load_at<std::int32_t>(file, at + 16 + 12), 28'672);
}

TEST(Surroundings, MayBeMissingOrWithoutARim) {
  const TestWorld world(4, 3, 2);
  WorldReader reader;
  const std::vector<std::byte> none = file_with(world, WorldMaterials());
  ASSERT_TRUE(reader.open(ByteSource::of(none)).ok());
  EXPECT_EQ(entry_of(none, "SURR"), 0u);
  EXPECT_FALSE(reader.surroundings().has_water());
  EXPECT_EQ(reader.surroundings().rim_points, 0u);
  EXPECT_TRUE(reader.read_rim({}).ok());
  const std::vector<std::byte> water = file_with(world, around({}));
  ASSERT_TRUE(reader.open(ByteSource::of(water)).ok());
  EXPECT_TRUE(reader.surroundings().has_water());
  EXPECT_TRUE(reader.read_rim({}).ok());
}

TEST(Surroundings, EveryFieldOutOfRangeIsNamed) {
  const TestWorld world(4, 3, 3);
  const std::vector<std::byte> file = file_with(world, around(kRim));
  const auto expect = [&](std::size_t offset, auto value, const char* what) {
    std::vector<std::byte> damaged = file;
    const std::size_t start = start_of_section(file);
    store_at(damaged, start + offset, value);
    fix_checksums(damaged);
    WorldInfo info;
    const Status whole = read_world_info(damaged, info);
    WorldReader reader;
    Status piece = reader.open(ByteSource::of(damaged));
    std::vector<glm::ivec3> rim(3);
    if (piece.ok()) piece = reader.read_rim(rim);
    for (const Status& status : {whole, piece}) {
      EXPECT_EQ(status.code(), StatusCode::corrupt) << what;
      EXPECT_STREQ(status.field(), "surroundings");
      EXPECT_NE(std::string(status.what()).find(what), std::string::npos) << status.what();
      EXPECT_GE(status.value(), start);
      EXPECT_LE(status.value(), start + offset);
    }
  };
  expect(0, 2u, "flag");
  expect(0, 0x80000001u, "flag");
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), 2e6f, -2e6f}) {
    expect(4, bad, "level");
    expect(8, bad, "level");
  }
  expect(12, 2u, "length");
  expect(12, 4u, "length");
  expect(12, 0xffffffffu, "more than eight");
  expect(16, (1 << 23) + 1, "rim point");
  expect(16 + 12 + 4, -(1 << 23) - 1, "rim point");
}

TEST(Surroundings, ADamagedRimFailsItsChecksum) {
  const TestWorld world(4, 3, 4);
  std::vector<std::byte> file = file_with(world, around(kRim));
  file[start_of_section(file) + 16] ^= std::byte{1};
  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
  std::vector<glm::ivec3> rim(3);
  EXPECT_STREQ(reader.read_rim(rim).field(), "section crc");
  WorldInfo info;
  EXPECT_STREQ(read_world_info(file, info).field(), "section crc");
}

TEST(Surroundings, TheWriterRefusesWhatTheReaderWould) {
  const TestWorld world(4, 3, 5);
  const auto field_of = [&](const WorldMaterials& materials) {
    std::vector<std::byte> out;
    const Status status = write_world({world.info, &world.memory.tree, world.patches(), materials}, out);
    EXPECT_EQ(status.code(), StatusCode::invalid_argument);
    EXPECT_TRUE(out.empty());
    return std::string(status.field());
  };
  WorldMaterials bad = around(kRim);
  bad.surroundings.flags = 4;
  EXPECT_EQ(field_of(bad), "surroundings");
  bad = around(kRim);
  bad.surroundings.water_level = 1e7f;
  EXPECT_EQ(field_of(bad), "surroundings");
  const std::vector<glm::ivec3> many(most_rim_points(world.info.extent) + 1);
  EXPECT_EQ(field_of(around(many)), "surroundings");
  bad = around(kRim);
  bad.surroundings.rim_points = 2;
  EXPECT_EQ(field_of(bad), "rim");
  const std::vector<glm::ivec3> far(1, glm::ivec3(0, 0, (1 << 23) + 1));
  EXPECT_EQ(field_of(around(far)), "rim");
}

}  // namespace
}  // namespace karst::core
