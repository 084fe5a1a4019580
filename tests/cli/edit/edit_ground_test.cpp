// SPDX-License-Identifier: MIT
// karst edit on grounds as a user runs it: raise, smooth, level; the same bytes for the same script, and a
// whole world that may be edited again.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/process.h"

namespace karst {
namespace {

using test::ProcessResult;
using test::run_process;

constexpr const char* kHill =
    R"({"tool": "extrude", "shape": "cylinder", "place_m": [500, 0, -300], "radius_m": 400,)"
    R"( "strength_m": 90})"
    "\n"
    R"({"tool": "noise", "shape": "cylinder", "place_m": [-900, 0, 700], "radius_m": 300, "strength_m": 20,)"
    R"( "wave_m": 120, "seed": 5})"
    "\n";
constexpr const char* kFlat =
    R"({"tool": "level", "shape": "box", "place_m": [-1500, 120, -1500], "half_m": [300, 900, 300]})"
    "\n";

class KarstEditGround : public testing::Test {
 protected:
  void SetUp() override { bake("w.karst", {}); }
  void bake(const std::string& name, const std::vector<std::string>& more) {
    constexpr int kSide = 400;
    std::string samples;
    for (int z = 0; z < kSide; ++z) {
      for (int x = 0; x < kSide; ++x) {
        const auto height = static_cast<std::int16_t>(300 + 150 * std::sin(0.03 * x) * std::cos(0.025 * z) +
                                                      (x * 7 + z * 13) % 5);
        samples += static_cast<char>(height & 255);
        samples += static_cast<char>(height >> 8);
      }
    }
    folder_.write("dem.bil", samples);
    folder_.write("dem.hdr", "ncols 400\nnrows 400\nnbits 16\npixeltype signedint\nbyteorder I\n");
    std::vector<std::string> words = {
        folder_.path("dem.bil"), "--pixel-size", "10", "--materials", "none", "--quiet", "-o",
        folder_.path(name)};
    words.insert(words.end(), more.begin(), more.end());
    const ProcessResult made = run_process(KARST_BAKE_PATH, words);
    ASSERT_EQ(made.code, 0) << made.err;
  }
  ProcessResult edit(const std::string& script, const std::string& output,
                     const std::string& input = "w.karst") {
    folder_.write("s.json", script);
    return run_process(KARST_APP_PATH, {"edit", folder_.path(input), "--script", folder_.path("s.json"), "-o",
                                        folder_.path(output)});
  }
  std::string bytes(const std::string& name) const { return test::read_text(folder_.path(name)); }

  test::Folder folder_;
};

TEST_F(KarstEditGround, TheSameScriptMakesTheSameBytesAndAWholeWorld) {
  ASSERT_EQ(edit("[]", "same.karst").code, 0);
  EXPECT_TRUE(bytes("same.karst") == bytes("w.karst"));
  const ProcessResult result = edit(kHill, "a.karst");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("2 edits (0 changed nothing)"), std::string::npos) << result.out;
  EXPECT_FALSE(bytes("a.karst") == bytes("w.karst"));
  EXPECT_LT(bytes("a.karst").size(), 3 * bytes("w.karst").size());
  const ProcessResult info = run_process(KARST_APP_PATH, {"info", folder_.path("a.karst")});
  EXPECT_EQ(info.code, 0) << info.err;
  ASSERT_EQ(edit(kHill, "b.karst").code, 0);
  EXPECT_TRUE(bytes("a.karst") == bytes("b.karst"));
  // In place; and saved again it stays what it is.
  ASSERT_EQ(edit(kHill, "w.karst").code, 0);
  EXPECT_TRUE(bytes("a.karst") == bytes("w.karst"));
  ASSERT_EQ(edit("[]", "c.karst").code, 0);
  EXPECT_TRUE(bytes("a.karst") == bytes("c.karst"));
}

// What is levelled has one height whatever was there before.
TEST_F(KarstEditGround, EditedWorldsAreEditedAgain) {
  ASSERT_EQ(edit(std::string(kHill) + kFlat, "at_once.karst").code, 0);
  ASSERT_EQ(edit(kHill, "w.karst").code, 0);
  ASSERT_EQ(edit(kFlat, "w.karst").code, 0);
  const auto picture = [&](const std::string& world) {
    const std::string out = folder_.path(world + ".png");
    const ProcessResult drawn = run_process(
        KARST_APP_PATH,
        {"render", folder_.path(world), "-o", out, "--size", "200x150", "--camera", "-600,900,-600,315,-35"});
    EXPECT_EQ(drawn.code, 0) << drawn.err;
    return test::read_text(out);
  };
  const std::string twice = picture("w.karst");
  EXPECT_TRUE(twice == picture("at_once.karst"));
  ASSERT_EQ(edit(kHill, "hill.karst", "at_once.karst").code, 0);
  EXPECT_FALSE(twice == picture("hill.karst"));
}

// A DEM in UTM keeps its coordinates, and looks as before but for the hill.
TEST_F(KarstEditGround, AGeoreferencedDem) {
  const std::string dem = KARST_DATA_DIR "/bigtujunga.tif";
  if (!std::filesystem::exists(dem)) GTEST_SKIP() << dem << " is not there";
  ASSERT_EQ(
      run_process(KARST_BAKE_PATH, {dem, "--materials", "none", "--quiet", "-o", folder_.path("utm.karst")})
          .code,
      0);
  const std::string hill = R"({"tool": "extrude", "shape": "cylinder", "place_m": [3000, 0, -1500],)"
                           R"( "radius_m": 1200, "strength_m": 700})";
  ASSERT_EQ(edit(hill, "hill.karst", "utm.karst").code, 0);
  EXPECT_LT(bytes("hill.karst").size(), bytes("utm.karst").size() * 5 / 4);
  const auto drawn = [&](const std::string& world, const char* camera) {
    const std::string out = folder_.path("picture.png");
    const ProcessResult result = run_process(
        KARST_APP_PATH, {"render", folder_.path(world), "-o", out, "--size", "240x160", "--camera", camera});
    EXPECT_EQ(result.code, 0) << result.err;
    return test::read_text(out);
  };
  for (const char* const place : {"3000,3500,2500,0,-35", "@-118.12,34.28,6000,0,-45"})
    EXPECT_FALSE(drawn("utm.karst", place) == drawn("hill.karst", place)) << place;
  const char* const away = "-9000,4000,0,90,-60";
  EXPECT_TRUE(drawn("utm.karst", away) == drawn("hill.karst", away));
  const ProcessResult info = run_process(KARST_APP_PATH, {"info", folder_.path("hill.karst")});
  EXPECT_NE(info.out.find("EPSG:32611"), std::string::npos) << info.out;
}

// More tiles than there is room for at first.
TEST_F(KarstEditGround, AScriptOverAllOfTheGround) {
  const ProcessResult result = edit(
      R"({"tool": "extrude", "shape": "cylinder", "place_m": [0, 0, 0], "radius_m": 9000, "strength_m": 30,)"
      R"( "hardness": 1})",
      "all.karst");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(run_process(KARST_APP_PATH, {"info", folder_.path("all.karst")}).code, 0);
}

TEST_F(KarstEditGround, FailuresSayWhatIsWrongAndWriteNothing) {
  const auto refused = [&](const std::string& script, const char* words,
                           const std::string& input = "w.karst") {
    const ProcessResult result = edit(script, "out.karst", input);
    EXPECT_EQ(result.code, 1) << script;
    EXPECT_NE(result.err.find(words), std::string::npos) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_FALSE(std::filesystem::exists(folder_.path("out.karst")));
  };
  refused(std::string(kHill) +
              R"({"tool": "extrude", "place_m": [0, 300, 0], "radius_m": 30, "strength_m": 900000})",
          "edit 2");
  refused(R"({"tool": "clear", "place_m": [0, 300, 0], "radius_m": 30})", "edit 0");
  bake("globe.karst", {"--basis", "cylinder:2000"});
  refused(kHill, "curved", "globe.karst");
}

}  // namespace
}  // namespace karst
