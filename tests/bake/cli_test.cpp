// SPDX-License-Identifier: MIT
// karst-bake as a user runs it: exit codes, one clear line for each mistake, and nothing half written.
#include "tests/bake/bake_files.h"
#include "tests/support/process.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

namespace karst::bake {
namespace {

using Words = std::vector<std::string>;

class BakeCli : public ::testing::Test {
 protected:
  BakeCli() {
    std::vector<std::int16_t> heights;
    for (int k = 0; k < 40 * 30; ++k)
      heights.push_back(static_cast<std::int16_t>(100 + k % 40 + 2 * (k / 40)));
    dem_ = folder_.write(
        "dem.tif", TiffBuilder(40, 30, 16, 2, std::string(bytes_of(heights))).pixel_scale(5, 5).bytes());
    no_size_ =
        folder_.write("no_size.tif", TiffBuilder(40, 30, 16, 2, std::string(bytes_of(heights))).bytes());
    world_ = folder_.path("world.karst");
    before_ = folder_.names();
  }

  test::ProcessResult run(const Words& words) const { return test::run_process(KARST_BAKE_PATH, words); }

  void expect_failure(int code, const Words& words, const std::string& mentions) const {
    const test::ProcessResult result = run(words);
    EXPECT_EQ(result.code, code) << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(result.err.rfind("karst-bake: ", 0), 0u) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_NE(result.err.find(mentions), std::string::npos) << result.err;
    EXPECT_EQ(folder_.names(), before_) << "something was left behind";
  }

  test::Folder folder_;
  std::string dem_, no_size_, world_;
  Words before_;
};

TEST_F(BakeCli, BakesAndReports) {
  const auto result =
      run({dem_, "-o", world_, "--voxel", "20", "--levels", "2", "--threads", "2", "--material-side", "16"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  for (const char* word : {"40 x 30 samples", "voxels", "patches", "rms",
                           "heights       100 to 197 m, over 195 x 145 m", "quantisation", "written"}) {
    EXPECT_NE(result.out.find(word), std::string::npos) << result.out;
  }
  EXPECT_EQ(test::read_text(world_).substr(0, 5), "KARST") << "the file's magic";
}

// A pool with room for little more than the coarsest version: the error that is aimed at grew to 65,536 times
// what was asked for, where a few times is as coarse as anything gets.
TEST_F(BakeCli, AFullPoolDoesNotWindUp) {
  ASSERT_EQ(run({"--sample", "canyon", "--no-ground", "--materials", "none", "--quiet", "-o", world_}).code,
            0);
  const test::ProcessResult drawn = test::run_process(
      KARST_APP_PATH, {"render", world_, "--vertex-memory", "2.2754", "--fov", "99.3", "--size", "734x734",
                       "--camera", "60,60,0,40,-12", "--shadows", "0", "--stats", "-"});
  ASSERT_EQ(drawn.code, 0) << drawn.err;
  const std::string name = "\"error_scale\": ";
  const std::size_t at = drawn.out.find(name);
  ASSERT_NE(at, std::string::npos) << drawn.out;
  const double scale = std::stod(drawn.out.substr(at + name.size()));
  EXPECT_GT(scale, 1);
  EXPECT_LT(scale, 100);
}

TEST_F(BakeCli, JsonAndStatsAreTheSame) {
  const std::string stats = folder_.path("stats.json");
  const auto result =
      run({dem_, "-o", world_, "--no-ground", "--json", "--stats", stats, "--material-side", "16"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(test::read_text(stats), result.out);
  for (const char* field :
       {"\"input\"", "\"size\"", "\"void_share\"", "\"voxels\"", "\"patches\"", "\"bytes\"", "\"seconds\"",
        "\"fit_m\"", "\"rms\"", "\"p999\"", "\"max\"", "\"quantisation_m\""}) {
    EXPECT_NE(result.out.find(field), std::string::npos) << field;
  }
  EXPECT_EQ(result.out.find("nan"), std::string::npos);
}

TEST_F(BakeCli, StagesSumToTheWhole) {
  const auto result = run({"--sample", "hills", "--no-ground", "-o", world_, "--json"});
  ASSERT_EQ(result.code, 0) << result.err;
  const auto number = [&](const std::string& field) {
    const std::size_t at = result.out.rfind("\"" + field + "\":");
    EXPECT_NE(at, std::string::npos) << field;
    return std::stod(result.out.substr(at + field.size() + 3));
  };
  double sum = 0;
  for (const char* stage : {"read", "voxels", "heights", "measure", "world"}) sum += number(stage);
  EXPECT_LE(sum, number("seconds"));
  EXPECT_GT(sum, 0.8 * number("seconds")) << "but for writing the file";
}

TEST_F(BakeCli, QuietSaysNothing) {
  const auto result = run({dem_, "-o", world_, "--quiet", "--materials", "none"});
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(result.out + result.err, "");
}

// Each was written over by the world or its statistics, and the exit code was 0.
TEST_F(BakeCli, OutputsAreNeitherInputsNorEachOther) {
  const std::string carve = folder_.write("carve.json", std::string(R"({"shapes": []})"));
  const std::string image = folder_.write("rock.png", std::string("not read"));
  const std::string materials = folder_.write(
      "materials.json", std::string(R"({"materials": [{"name": "rock", "albedo": "rock.png"}]})"));
  before_ = folder_.names();
  expect_failure(1, {dem_, "-o", dem_}, "is also DEM");
  expect_failure(1, {dem_, "-o", folder_.path("./dem.tif")}, "is also DEM");
  expect_failure(1, {dem_, "-o", world_, "--stats", dem_}, "is also DEM");
  expect_failure(1, {dem_, "-o", world_, "--stats", world_}, "is also --output");
  expect_failure(1, {dem_, "-o", carve, "--carve", carve}, "is also --carve");
  expect_failure(1, {dem_, "-o", materials, "--materials", materials}, "is also --materials");
  expect_failure(1, {dem_, "-o", image, "--materials", materials}, "is also an image of --materials");
}

TEST_F(BakeCli, WhatDoesNotReachStandardOutputIsAFailure) {
  for (const char* words : {"--help", "--version", "--print-manual completion"}) {
    const auto result =
        test::run_process("/bin/sh", {"-c", std::string(KARST_BAKE_PATH) + " " + words + " >/dev/full"});
    EXPECT_EQ(result.code, 1) << words;
    EXPECT_EQ(result.err.rfind("karst-bake: standard output: cannot write", 0), 0u) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  }
}

// Its report went into the file that had taken the number of standard output, and the exit code was 0.
TEST_F(BakeCli, ClosedStandardFilesAreNoneOfItsOwn) {
  for (const char* closed : {">&-", "2>&-", "<&- >&- 2>&-"}) {
    for (const char* more : {" --no-ground", " --ground"}) {
      const std::string words =
          " " + dem_ + " -o " + world_ + " --materials none --stats " + folder_.path("s.json") + more + " ";
      const auto result = test::run_process("/bin/sh", {"-c", KARST_BAKE_PATH + words + closed});
      const bool has_output = std::string(closed) == "2>&-";
      EXPECT_EQ(result.code, has_output ? 0 : 1) << closed << more << result.err;
      EXPECT_EQ(test::run_process(KARST_APP_PATH, {"info", world_}).code, 0) << closed << more;
      const std::string stats = test::read_text(folder_.path("s.json"));
      EXPECT_TRUE(stats.starts_with("{") && stats.ends_with("}\n")) << closed << more;
    }
  }
}

// Without a word of voxels a DEM is a ground, whatever its size; with one it is what it was asked for.
TEST_F(BakeCli, ADemIsAGroundUnlessVoxelsAreSaid) {
  const std::string carve = folder_.write(
      "carve.json",
      std::string(R"([{"shape": "sphere", "op": "empty", "center": [0, 150, 0], "radius": 8}])"));
  struct Case {
    Words more;
    bool ground, voxels;
  };
  const Case cases[] = {{{}, true, false},
                        {{"--ground"}, true, false},
                        {{"--water", "120"}, true, false},
                        {{"--carve", carve}, true, true},
                        {{"--carve", carve, "--voxel", "8"}, true, true},
                        {{"--carve", carve, "--no-ground"}, false, true},
                        {{"--no-ground"}, false, true},
                        {{"--voxel", "20"}, false, true},
                        {{"--levels", "3"}, false, true},
                        {{"--accept-fit"}, false, true},
                        {{"--nodata", "-1,hole"}, false, true}};
  for (const Case& c : cases) {
    Words words{dem_, "-o", world_, "--materials", "none", "--quiet"};
    words.insert(words.end(), c.more.begin(), c.more.end());
    const std::string said = c.more.empty() ? "nothing" : c.more.front();
    const auto baked = run(words);
    ASSERT_EQ(baked.code, 0) << said << ": " << baked.err;
    const std::string info = test::run_process(KARST_APP_PATH, {"info", world_, "--json"}).out;
    EXPECT_EQ(info.find("\"ground\": {") != std::string::npos, c.ground) << said << info;
    EXPECT_EQ(info.find("\"patches\": 0") == std::string::npos, c.voxels) << said << info;
  }
  before_ = folder_.names();
  expect_failure(2, {dem_, "-o", world_, "--ground", "--no-ground"}, "both --ground and --no-ground");
  expect_failure(2, {dem_, "-o", world_, "--basis", "geographic", "--no-ground"}, "--basis");
  expect_failure(2, {dem_, "-o", world_, "--ground", "--accept-fit"}, "--accept-fit");
}

TEST_F(BakeCli, HelpNamesEveryOptionAndSample) {
  const auto result = run({"--help"});
  EXPECT_EQ(result.code, 0);
  for (const char* word : {"--voxel", "--levels", "--z-scale", "--nodata", "--carve", "--sample",
                           "--pixel-size", "--crop", "--allow-8bit", "--threads", "--stats", "--json",
                           "--quiet", "canyon", "caves", "arches", "hills", "Examples"}) {
    EXPECT_NE(result.out.find(word), std::string::npos) << word;
  }
}

TEST_F(BakeCli, UsageErrors) {
  const auto usage = [&](const Words& words, const std::string& mentions) {
    expect_failure(2, words, mentions);
  };
  usage({}, "--help");
  usage({"-o", world_}, "DEM");
  usage({"-o", world_, "--"}, "DEM");
  usage({dem_}, "-o");
  usage({dem_, "--sample", "hills", "-o", world_}, "both");
  usage({"--sample", "moon", "-o", world_}, "canyon, caves, arches, hills");
  usage({"--sample", "hills", "-o", world_, "--crop", "0,0,9,9"}, "--crop");
  usage({dem_, "-o", world_, "--frobnicate"}, "frobnicate");
  usage({dem_, "-o", world_, "--voxel"}, "voxel");
  // Each start loads OpenImageIO's 260 libraries: a few values do for all options.
  const std::pair<const char*, const char*> values[] = {
      {"--voxel", "nan"}, {"--voxel", "0"},   {"--levels", "7"},       {"--levels", "2x"},
      {"--z-scale", "0"}, {"--threads", "0"}, {"--pixel-size", "inf"}, {"--pixel-size", ""}};
  for (const auto& [option, value] : values) usage({dem_, "-o", world_, option, value}, option);
  for (const char* value : {"5,", "deep", "hole,fill"})
    usage({dem_, "-o", world_, "--nodata", value}, "--nodata");
  for (const char* value : {"1,2,3", "0,0,1,9", "0,0,9.5,9"}) {
    usage({dem_, "-o", world_, "--crop", value}, "--crop");
  }
}

TEST_F(BakeCli, BadInput) {
  expect_failure(1, {folder_.path("missing.tif"), "-o", world_}, "missing.tif");
  expect_failure(1, {no_size_, "-o", world_}, "--pixel-size");
  expect_failure(1, {dem_, no_size_, "-o", world_}, "does not say where it lies");
  expect_failure(1, {dem_, "-o", world_, "--band", "2"}, "--band: the raster has 1");
  expect_failure(1, {dem_, "-o", world_, "--crop", "30,0,20,20"}, "--crop");
  expect_failure(1, {dem_, "-o", world_, "--voxel", "0.1"}, "--voxel");
  expect_failure(1, {dem_, "-o", world_, "--carve", folder_.path("none.json")}, "none.json");
  expect_failure(1, {dem_, "-o", world_, "--z-scale", "1e6"}, "dem.tif");
}

TEST_F(BakeCli, UnwritableOutputIsSeenBeforeTheWork) {
  expect_failure(1, {dem_, "-o", folder_.path("no/such/world.karst")}, "no/such");
  expect_failure(1, {dem_, "-o", folder_.path("")}, folder_.path(""));
  expect_failure(1, {dem_, "-o", world_, "--stats", folder_.path("no/stats.json")}, "no/stats.json");
}

TEST_F(BakeCli, AFailedBakeKeepsTheOldFile) {
  folder_.write("world.karst", std::string("what was there"));
  EXPECT_EQ(run({no_size_, "-o", world_}).code, 1);
  EXPECT_EQ(test::read_text(world_), "what was there");
  EXPECT_EQ(run({dem_, "-o", world_, "--materials", "none", "--no-ground"}).code, 0);
  EXPECT_NE(test::read_text(world_), "what was there");
}

TEST_F(BakeCli, AWorldThatIsNotItsElevationIsNone) {
  // Noise of 20 km between samples 30 m apart: no surface of voxels follows it.
  std::vector<float> heights;
  std::uint32_t state = 1;
  for (int k = 0; k < 32 * 32; ++k) {
    state = state * 1664525u + 1013904223u;
    heights.push_back(static_cast<float>(state >> 8) / (1 << 24) * 40'000 - 20'000);
  }
  const std::string steep = folder_.write(
      "steep.tif", TiffBuilder(32, 32, 32, 3, std::string(bytes_of(heights))).pixel_scale(30, 30).bytes());
  const Words words = {steep, "-o", world_, "--materials", "none", "--no-ground"};
  const auto failed = run(words);
  EXPECT_EQ(failed.code, 1);
  EXPECT_NE(failed.err.find("--accept-fit"), std::string::npos) << failed.err;
  EXPECT_NE(::access(world_.c_str(), F_OK), 0) << "no world";
  Words accepting = words;
  accepting.emplace_back("--accept-fit");
  const auto accepted = run(accepting);
  EXPECT_EQ(accepted.code, 0) << accepted.err;
  EXPECT_NE(accepted.err.find("warning: the ground misses the elevation"), std::string::npos) << accepted.err;
  EXPECT_EQ(::access(world_.c_str(), F_OK), 0);
}

TEST_F(BakeCli, VoidsWithoutATagAndCountsWithoutAScaleAreTold) {
  std::vector<float> heights;
  for (int k = 0; k < 40 * 30; ++k) heights.push_back(static_cast<float>(100 + k % 40));
  heights[300] = heights[301] = -9999;
  const std::string pit = folder_.write(
      "pit.tif", TiffBuilder(40, 30, 32, 3, std::string(bytes_of(heights))).pixel_scale(5, 5).bytes());
  const Words words = {pit, "-o", world_, "--materials", "none", "--accept-fit"};
  EXPECT_NE(run(words).err.find("--nodata -9999"), std::string::npos);
  Words told = words;
  told.insert(told.end(), {"--nodata", "-9999"});
  EXPECT_EQ(run(told).err, "");

  std::vector<std::uint16_t> counts;
  for (int k = 0; k < 40 * 30; ++k) counts.push_back(static_cast<std::uint16_t>(k % 40 * 1680));
  const std::string map = folder_.write(
      "map.tif", TiffBuilder(40, 30, 16, 1, std::string(bytes_of(counts))).pixel_scale(5, 5).bytes());
  before_ = folder_.names();
  expect_failure(1, {map, "-o", folder_.path("none.karst")}, "--z-scale");
  EXPECT_EQ(run({map, "-o", world_, "--materials", "none", "--z-scale", "0.001"}).err, "");
}

TEST_F(BakeCli, DamagedImagesGiveOneLine) {
  std::string png_bytes;
  {
    const IgnoreLeaks libraries_leak;
    write_image(folder_.path("a.png"), 8, 8, std::vector<float>(64, 500), "uint16");
    png_bytes = test::read_text(folder_.path("a.png"));
    png_bytes[40] = static_cast<char>(png_bytes[40] ^ 0x55);
  }
  folder_.write("a.png", png_bytes.substr(0, png_bytes.size() - 20));
  before_ = folder_.names();
  // The program's own leak check would speak where its libraries leak.
  const auto result =
      test::run_process(KARST_BAKE_PATH, {folder_.path("a.png"), "-o", world_, "--pixel-size", "1"},
                        {"ASAN_OPTIONS=detect_leaks=0"});
  EXPECT_EQ(result.code, 1);
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_NE(result.err.find("a.png"), std::string::npos);
  EXPECT_EQ(folder_.names(), before_);
}

}  // namespace
}  // namespace karst::bake
