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
  const Config config = World::config_for(reader.info(), reader.info().level, info);
  Budget budget;
  World::add_to(budget, config);
  test::AlignedBytes memory(budget.cpu_bytes());
  Arena arena(memory.bytes());
  World world;
  ASSERT_TRUE(world.create(config, arena).ok());
  const Status loaded = world.load(ByteSource::of(with));
  ASSERT_TRUE(loaded.ok()) << loaded.field() << ": " << loaded.what();
  EXPECT_EQ(world.rim().edges().size(), info.regions()[0].rim_edges);

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
  const std::string apart = refused(
      R"([{"shape": "box", "op": "empty", "center": [-9000, 1000, 0], "size": [50, 4000, 50]},
          {"shape": "box", "op": "empty", "center": [9000, 1000, 0], "size": [50, 4000, 50]}])",
      {"--voxel", "7.5"});
  EXPECT_NE(apart.find("nearer to each other"), std::string::npos) << apart;
  const std::string tall =
      refused(R"([{"shape": "box", "op": "empty", "center": [0, -3000, 0], "size": [50, 9000, 50]}])",
              {"--voxel", "7.5"});
  EXPECT_NE(tall.find("--voxel"), std::string::npos) << tall;
}

}  // namespace
}  // namespace karst::core
