// SPDX-License-Identifier: MIT
// Worlds with a ground, from a DEM to the file and back.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "app/files/file_source.h"
#include "karst/plan.h"
#include "karst/world.h"
#include "terrain/file/world_reader.h"
#include "tests/support/process.h"
#include "tiles/decode_tile.h"

namespace karst {
namespace {

using namespace core;

using test::Folder;

// ESRI's raw raster of whole metres.
// west: of its first column, from that of others beside it, in samples of 10 m.
void write_dem(const std::string& name, int wide, int deep, const std::function<int(int, int)>& height,
               int west = 0) {
  std::ofstream samples(name + ".bil", std::ios::binary);
  for (int k = 0; k < deep; ++k) {
    for (int i = 0; i < wide; ++i) {
      const auto value = static_cast<std::int16_t>(height(i, k));
      samples.write(reinterpret_cast<const char*>(&value), sizeof value);
    }
  }
  std::ofstream(name + ".hdr") << "ncols " << wide << "\nnrows " << deep
                               << "\nnbits 16\npixeltype signedint\nbyteorder I\nnodata -9999\nulxmap "
                               << 10 * west << "\nulymap 0\nxdim 10\nydim 10\n";
}

int hills(int i, int k) {
  return static_cast<int>(400 + 200 * std::sin(i / 17.0) * std::cos(k / 23.0) + (i * 7 + k * 13) % 5);
}

std::vector<std::byte> read_all(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> text{std::istreambuf_iterator<char>(file), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

struct Walk {
  const WorldReader& reader;
  std::function<void(NodeKey, const Tile&)> visit;
  std::vector<std::byte> room = std::vector<std::byte>(tiles::decode_tile_room());

  void run(NodeKey key, const TilePlace& place) {
    std::vector<std::byte> bytes(place.bytes);
    ASSERT_TRUE(reader.read_tile(place, bytes).ok());
    Tile tile;
    const Status status = tiles::decode_tile(reader.ground(), key, place, bytes, room, tile);
    ASSERT_TRUE(status.ok()) << status.what();
    visit(key, tile);
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      if (tile.children[quadrant].exists()) run(key.child(quadrant), tile.children[quadrant]);
    }
  }
};

std::string bake(const std::vector<std::string>& words, int expected = 0) {
  const test::ProcessResult result = test::run_process(KARST_BAKE_PATH, words);
  EXPECT_EQ(result.code, expected) << result.err;
  return expected == 0 ? result.out : result.err;
}

TEST(GroundWorld, HoldsTheSamplesOfTheDem) {
  const Folder folder;
  constexpr int kWide = 211, kDeep = 150;
  write_dem(folder.path("dem"), kWide, kDeep, hills);
  bake({folder.path("dem.bil"), "--ground", "--pixel-size", "10", "--materials", "none", "-o",
        folder.path("w")});
  const std::vector<std::byte> file = read_all(folder.path("w"));
  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
  ASSERT_TRUE(reader.verify().ok());
  const GroundInfo& ground = reader.ground();
  ASSERT_EQ(ground.samples[0], kWide);
  ASSERT_EQ(ground.samples[1], kDeep);
  EXPECT_EQ(reader.info().patches, 0u);
  const double step_m = reader.info().voxel_size_m / kStepsPerVoxel;
  EXPECT_DOUBLE_EQ(ground.steps[0] * step_m, 10);
  EXPECT_DOUBLE_EQ(reader.info().origin_m[0], -5.0 * (kWide - 1));
  int leaves = 0;
  double most_off = 0;
  Walk walk{reader, [&](NodeKey key, const Tile& tile) {
              if (key.size > 0) return;
              ++leaves;
              for (int k = 0; k <= kTileQuads; ++k) {
                for (int i = 0; i <= kTileQuads; ++i) {
                  const int column = key.x * kTileQuads + i;
                  const int row = key.z * kTileQuads + k;
                  if (column >= kWide || row >= kDeep) continue;
                  const double height_m =
                      reader.info().origin_m[1] + kVertexStep * step_m * tile.height(i, k);
                  most_off = std::max(most_off, std::abs(height_m - hills(column, row)));
                }
              }
            }};
  walk.run({ground.top_size(), 0, 0}, reader.root_tile());
  EXPECT_EQ(leaves, 4 * 3);
  EXPECT_LE(most_off, 0.5 * kVertexStep * step_m * 1.001);
}

// Wider than elevation that is held in memory may be.
TEST(GroundWorld, PartsAndCropsOfALongDemAreTheSameWorld) {
  constexpr int kWide = 40'000, kDeep = 9, kFirst = 39'900, kTaken = 100;
  const Folder whole, alone, parts;
  write_dem(whole.path("dem"), kWide, kDeep, hills);
  write_dem(alone.path("dem"), kTaken, kDeep, [](int i, int k) { return hills(i + kFirst, k); });
  const auto made = [](const Folder& folder, std::vector<std::string> words) {
    words.insert(words.end(), {"--ground", "--pixel-size", "10", "--materials", "none", "-o",
                               folder.path("w"), "--quiet"});
    bake(words);
    return read_all(folder.path("w"));
  };
  const std::vector<std::byte> cropped =
      made(whole, {whole.path("dem.bil"), "--crop", "39900,0,100,9", "--max-samples", "1000000000000"});
  EXPECT_EQ(cropped, made(alone, {alone.path("dem.bil")}));
  write_dem(parts.path("dem"), 30'000, kDeep, hills);
  write_dem(
      parts.path("east"), 10'000, kDeep, [](int i, int k) { return hills(i + 30'000, k); }, 30'000);
  EXPECT_EQ(made(parts, {parts.path("dem.bil"), parts.path("east.bil")}),
            made(whole, {whole.path("dem.bil")}));
}

TEST(GroundWorld, IsTheSameWithAnyNumberOfThreads) {
  const Folder folder;
  write_dem(folder.path("dem"), 300, 170, hills);
  bake(
      {folder.path("dem.bil"), "--ground", "--pixel-size", "10", "--threads", "1", "-o", folder.path("one")});
  bake({folder.path("dem.bil"), "--ground", "--pixel-size", "10", "--threads", "3", "-o",
        folder.path("three")});
  EXPECT_EQ(read_all(folder.path("one")), read_all(folder.path("three")));
}

// A cliff of 900 m between samples of 1 m takes longer steps than a hill does.
TEST(GroundWorld, ASteepDemHasShorterStepsBetweenSamples) {
  const Folder folder;
  write_dem(folder.path("dem"), 80, 70, [](int i, int) { return i < 40 ? 0 : 900; });
  bake({folder.path("dem.bil"), "--ground", "--pixel-size", "1", "--materials", "none", "-o",
        folder.path("w")});
  const std::vector<std::byte> file = read_all(folder.path("w"));
  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
  const double steps = reader.ground().steps[0];
  EXPECT_LT(steps, 100);
  // Half of the cliff lies below and above the middle, at most four voxels.
  EXPECT_LE(450 * steps, 4 * kStepsPerVoxel);
  EXPECT_GT(2 * 450 * steps, 3 * kStepsPerVoxel);
}

// Not what the lattice makes of them.
TEST(GroundWorld, TheHeightsOfTheDemAreReported) {
  const Folder folder;
  write_dem(folder.path("dem"), 60, 50, [](int i, int k) { return i == 7 && k == 9 ? 1449 : 571 + i % 5; });
  const std::string report = bake({folder.path("dem.bil"), "--ground", "--pixel-size", "10000", "--materials",
                                   "none", "-o", folder.path("w")});
  EXPECT_NE(report.find("heights       571 to 1449 m"), std::string::npos) << report;
}

TEST(GroundWorld, LongStepsOfHeightsAreTold) {
  const Folder folder;
  const auto warning = [&](const char* pixel_size) {
    const test::ProcessResult result =
        test::run_process(KARST_BAKE_PATH, {folder.path("dem.bil"), "--ground", "--pixel-size", pixel_size,
                                            "--materials", "none", "-o", folder.path("w"), "--quiet"});
    EXPECT_EQ(result.code, 0) << result.err;
    return result.err;
  };
  write_dem(folder.path("dem"), 80, 70, [](int i, int) { return i < 40 ? i : 900 + i; });
  EXPECT_EQ(warning("30"), "");
  EXPECT_NE(warning("0.2").find("neighbours are steep"), std::string::npos);
  write_dem(folder.path("dem"), 30, 30, [](int i, int k) { return 500 + (i + k) % 7; });
  EXPECT_EQ(warning("30"), "");
  EXPECT_NE(warning("30000").find("leave --ground away"), std::string::npos);
  write_dem(folder.path("dem"), 30, 30, [](int, int) { return 500; });
  EXPECT_EQ(warning("30000"), "");
}

TEST(GroundWorld, VoidsAreFilled) {
  const Folder folder;
  write_dem(folder.path("dem"), 90, 80,
            [](int i, int k) { return i > 30 && i < 50 && k > 20 && k < 60 ? -9999 : hills(i, k); });
  bake({folder.path("dem.bil"), "--ground", "--pixel-size", "10", "--materials", "none", "-o",
        folder.path("w")});
  const std::vector<std::byte> file = read_all(folder.path("w"));
  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
  const double vertex_m = reader.info().voxel_size_m * kVertexStep / kStepsPerVoxel;
  EXPECT_GT(reader.ground().low * vertex_m, 150);
}

TEST(GroundWorld, WhatNeedsVoxelsIsRefused) {
  const Folder folder;
  write_dem(folder.path("dem"), 20, 20, hills);
  for (const auto& [option, value] : {std::pair("--voxel", "10"), std::pair("--levels", "2"),
                                      std::pair("--max-carve", "9"), std::pair("--nodata", "hole")}) {
    const std::string message = bake(
        {folder.path("dem.bil"), "--ground", "--pixel-size", "10", option, value, "-o", folder.path("w")}, 2);
    EXPECT_NE(message.find("leave --ground"), std::string::npos) << message;
    EXPECT_FALSE(std::filesystem::exists(folder.path("w")));
  }
}

TEST(GroundWorld, DamageIsFound) {
  const Folder folder;
  write_dem(folder.path("dem"), 150, 90, hills);
  bake({folder.path("dem.bil"), "--ground", "--pixel-size", "10", "--materials", "none", "-o",
        folder.path("w")});
  const std::vector<std::byte> whole = read_all(folder.path("w"));
  for (std::size_t at = 0; at < whole.size(); at += at < 1'000 ? 7 : 211) {
    std::vector<std::byte> file = whole;
    file[at] ^= std::byte{4};
    WorldReader reader;
    Status status = reader.open(ByteSource::of(file));
    if (status.ok()) status = reader.verify();
    ASSERT_NE(status.code(), StatusCode::ok) << at;
  }
}

// A place that is not in the section is no reason to read beyond it.
TEST(GroundWorld, PlacesOutsideOfTheTilesAreCorrupt) {
  const Folder folder;
  write_dem(folder.path("dem"), 20, 20, hills);
  bake({folder.path("dem.bil"), "--ground", "--pixel-size", "10", "--materials", "none", "-o",
        folder.path("w")});
  const std::vector<std::byte> file = read_all(folder.path("w"));
  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
  std::vector<std::byte> bytes(64);
  for (const std::uint64_t offset : {reader.tile_bytes(), reader.tile_bytes() - 63, ~std::uint64_t{0}}) {
    EXPECT_EQ(reader.read_tile({offset, 64, 0}, bytes).code(), StatusCode::corrupt) << offset;
  }
}

TEST(GroundWorld, IsPlannedAndLoadedWithoutPatches) {
  const Folder folder;
  write_dem(folder.path("dem"), 150, 90, hills);
  bake({folder.path("dem.bil"), "--ground", "--pixel-size", "10", "-o", folder.path("w")});
  app::FileSource file;
  ASSERT_TRUE(file.open(folder.path("w")).ok());
  Plan plan;
  const Status planned = make_plan(file.source(), plan);
  ASSERT_TRUE(planned.ok()) << planned.what() << ' ' << planned.field();
  std::vector<std::byte> room(static_cast<std::size_t>(plan.cpu_bytes) + kMemoryAlignment);
  void* at = room.data();
  std::size_t space = room.size();
  std::align(kMemoryAlignment, static_cast<std::size_t>(plan.cpu_bytes), at, space);
  karst::World* world = nullptr;
  const Status status = karst::World::create(
      plan, file.source(), {static_cast<std::byte*>(at), static_cast<std::size_t>(plan.cpu_bytes)}, world);
  ASSERT_TRUE(status.ok()) << status.what() << ' ' << status.field();
  EXPECT_EQ(world->info().patches, 0u);
  world->destroy();
}

}  // namespace
}  // namespace karst
