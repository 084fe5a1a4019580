// SPDX-License-Identifier: MIT
// Regions from shapes and a DEM to the file and back.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "terrain/file/world_reader.h"
#include "terrain/world/world.h"
#include "tests/support/process.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

using test::Folder;

const std::string kDem = std::string(KARST_DATA_DIR) + "/bigtujunga.tif";

std::string bake(std::vector<std::string> words, int expected = 0) {
  words.insert(words.begin(), kDem);
  const test::ProcessResult result = test::run_process(KARST_BAKE_PATH, words);
  EXPECT_EQ(result.code, expected) << result.err;
  return expected == 0 ? result.out : result.err;
}

void write(const std::string& path, const std::string& text) {
  std::ofstream(path) << text;
}

std::vector<std::byte> read_all(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> text{std::istreambuf_iterator<char>(file), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

// A tunnel of 300 m into a steep slope, and a chamber at its end.
constexpr const char* kCave = R"([
  {"shape": "capsule", "op": "empty", "radius": 20, "blend": 6,
   "points": [[2550, 1664, 4420], [2550, 1668, 4330], [2530, 1672, 4270], [2560, 1676, 4200]]},
  {"shape": "sphere", "op": "empty", "center": [2570, 1682, 4170], "radius": 46, "blend": 8}
])";

// A world in memory of its own.
struct Loaded {
  static std::uint64_t bytes(const Config& config) {
    Budget budget;
    World::add_to(budget, config);
    return budget.cpu_bytes();
  }
  Loaded(const WorldReader& reader, std::span<const std::byte> file)
      : config(World::config_for(reader.info(), reader.info().level, reader.ground())),
        memory(bytes(config)) {
    Arena arena(memory.bytes());
    status = world.create(config, arena);
    if (status.ok()) status = world.load(ByteSource::of(file));
  }

  Config config;
  test::AlignedBytes memory;
  World world;
  Status status;
};

// The whole DEM; of a crop its centre is another.
TEST(RegionWorld, VoxelsStandWhereTheCaveIsAndNowhereElse) {
  const Folder folder;
  write(folder.path("cave.json"), kCave);
  const std::vector<std::string> ground = {"--ground", "--materials", "none", "--quiet", "-o"};
  const auto made = [&](const char* name, std::vector<std::string> more) {
    std::vector<std::string> words = ground;
    words.push_back(folder.path(name));
    words.insert(words.end(), more.begin(), more.end());
    bake(words);
    return read_all(folder.path(name));
  };
  const std::vector<std::byte> with = made("with", {"--carve", folder.path("cave.json"), "--threads", "1"});
  const std::vector<std::byte> without = made("without", {});
  EXPECT_EQ(with, made("again", {"--carve", folder.path("cave.json"), "--threads", "3"}));

  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(with)).ok());
  ASSERT_TRUE(reader.verify().ok());
  const GroundInfo& info = reader.ground();
  EXPECT_EQ(info.lattice_size, 4);
  EXPECT_DOUBLE_EQ(reader.info().voxel_size_m, 7.5);
  EXPECT_DOUBLE_EQ(info.steps[0] * reader.info().voxel_size_m / kStepsPerVoxel, 30);
  const double sample_m =
      static_cast<double>(info.corner[0]) * kVertexStep * reader.info().voxel_size_m / kStepsPerVoxel;
  EXPECT_NEAR(reader.info().origin_m[0] + sample_m, -15.0 * static_cast<double>(info.samples[0] - 1), 1e-6);

  // Loading finds the rim that the file states.
  const Loaded loaded(reader, with);
  ASSERT_TRUE(loaded.status.ok()) << loaded.status.field() << ": " << loaded.status.what();
  EXPECT_EQ(loaded.world.rim().edges().size(), info.regions()[0].rim_edges);

  // What voxels of that size cost for all of the DEM, from what they cost for a part of it around the cave.
  bake({"--crop", "640,424,64,64", "--voxel", "7.5", "--levels", "2", "--materials", "none", "--quiet", "-o",
        folder.path("voxels")});
  const auto part = static_cast<double>(std::filesystem::file_size(folder.path("voxels")));
  const double all = part * (1196.0 * 642) / (63.0 * 63);
  const auto region = static_cast<double>(with.size() - without.size());
  std::printf(
      "FIGURE the region takes %.0f bytes, the ground %zu, voxels of 7.5 m for all of it %.3g: %.2g %%\n",
      region, without.size(), all, 100 * (region + static_cast<double>(without.size())) / all);
  EXPECT_LT(region + static_cast<double>(without.size()), 0.02 * all);
}

// Two shapes whose boxes touch share a region, one that is near enough joins them; others have their own. All
// lie on one lattice, and the file says what it says of the only region where there is one.
TEST(RegionWorld, ShapesThatAreFarApartHaveRegionsOfTheirOwn) {
  const Folder folder;
  write(folder.path("shapes.json"), R"([
    {"shape": "box", "op": "empty", "center": [-9000, 1000, 0], "size": [80, 4000, 80]},
    {"shape": "box", "op": "empty", "center": [-8930, 1000, 0], "size": [80, 4000, 80]},
    {"shape": "box", "op": "empty", "center": [-8700, 1000, 0], "size": [80, 4000, 80]},
    {"shape": "box", "op": "empty", "center": [9000, 1000, 100], "size": [80, 4000, 80]},
    {"shape": "sphere", "op": "empty", "center": [0, 9000, 0], "radius": 50}])");
  const std::string said = bake({"--ground", "--materials", "none", "--carve", folder.path("shapes.json"),
                                 "--voxel", "15", "-o", folder.path("w")});
  std::size_t told = 0;
  for (std::size_t at = said.find("region  "); at != std::string::npos; at = said.find("region  ", at + 1))
    ++told;
  EXPECT_EQ(told, 2u) << said;
  EXPECT_NE(said.find("1 of 5 do not meet the ground"), std::string::npos) << said;
  const std::vector<std::byte> file = read_all(folder.path("w"));
  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
  ASSERT_TRUE(reader.verify().ok());
  const GroundInfo& info = reader.ground();
  ASSERT_EQ(info.region_count, 2);
  EXPECT_EQ(reader.info().patches, info.regions()[0].patches + info.regions()[1].patches);
  const Loaded loaded(reader, file);
  ASSERT_TRUE(loaded.status.ok()) << loaded.status.field() << ": " << loaded.status.what();
  const World& world = loaded.world;
  ASSERT_EQ(world.parts().size(), 2u);
  for (std::size_t n = 0; n < 2; ++n) {
    EXPECT_EQ(world.parts()[n].rim->edges().size(), info.regions()[n].rim_edges);
    EXPECT_EQ(world.parts()[n].patches(), info.regions()[n].patches);
    // Where the shapes of the one and of the other are.
    const double at_m = reader.info().origin_m[0] + 15.0 * info.regions()[n].corner.x;
    EXPECT_LT(at_m, n == 0 ? -9040 : 8960);
    EXPECT_GT(at_m, n == 0 ? -9340 : 8660);
  }
  // Fewer are allowed than there are.
  Config less = loaded.config;
  less.max_regions = 1;
  Budget small;
  World::add_to(small, less);
  test::AlignedBytes room(small.cpu_bytes());
  Arena other(room.bytes());
  World refuses;
  ASSERT_TRUE(refuses.create(less, other).ok());
  EXPECT_STREQ(refuses.load(ByteSource::of(file)).field(), "max_regions");
}

TEST(RegionWorld, ShapesThatDoNotMeetTheGroundMakeNone) {
  const Folder folder;
  write(folder.path("air.json"), R"([{"shape": "sphere", "op": "empty", "center": [0, 9000, 0], "radius": 50},
    {"shape": "sphere", "op": "empty", "center": [2570, 600, 4170], "radius": 50}])");
  const std::string said = bake(
      {"--ground", "--materials", "none", "--carve", folder.path("air.json"), "-o", folder.path("with")});
  EXPECT_NE(said.find("2 of 2 do not meet the ground"), std::string::npos) << said;
  bake({"--ground", "--materials", "none", "--quiet", "-o", folder.path("without")});
  EXPECT_EQ(read_all(folder.path("with")), read_all(folder.path("without")));
}

TEST(RegionWorld, WhatCannotBeARegionIsRefused) {
  const Folder folder;
  const auto refused = [&](const std::string& shapes, std::vector<std::string> more) {
    write(folder.path("shapes.json"), shapes);
    std::vector<std::string> words = {
        "--ground", "--materials", "none", "--carve", folder.path("shapes.json"), "-o", folder.path("w")};
    words.insert(words.end(), more.begin(), more.end());
    const std::string message = bake(words, 1);
    EXPECT_FALSE(std::filesystem::exists(folder.path("w")));
    EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 1) << message;
    return message;
  };
  const std::string border =
      refused(R"([{"shape": "box", "op": "empty", "center": [17900, 1000, 0], "size": [50, 4000, 50]}])", {});
  EXPECT_NE(border.find("its border"), std::string::npos) << border;
  const std::string wide =
      refused(R"([{"shape": "box", "op": "empty", "center": [-500, 1000, 0], "size": [6000, 4000, 50]}])",
              {"--voxel", "7.5"});
  EXPECT_NE(wide.find("use a larger --voxel"), std::string::npos) << wide;
  const std::string tall =
      refused(R"([{"shape": "box", "op": "empty", "center": [0, -3000, 0], "size": [50, 9000, 50]}])",
              {"--voxel", "7.5"});
  EXPECT_NE(tall.find("--voxel"), std::string::npos) << tall;
}

}  // namespace
}  // namespace karst::core
