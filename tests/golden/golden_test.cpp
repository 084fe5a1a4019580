// SPDX-License-Identifier: MIT
// Bakes and draws the samples and a real elevation model, and compares with the stored pictures; see
// README.md.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/golden/picture.h"
#include "tests/support/process.h"

namespace karst::core {
namespace {

using test::Folder;
using test::ProcessResult;
using Words = std::vector<std::string>;

// On other drivers; see README.md.
constexpr double kMostMean = 3.0;
constexpr double kMostFarApart = 0.02;

struct View {
  const char* picture;
  Words camera;
};

struct Case {
  const char* name;
  Words bake;
  std::vector<View> views;
};

// Level 3: a sixteenth of the samples' vertices, and no difference to be seen at this size.
const Case kCases[] = {
    {"canyon",
     {"--sample", "canyon", "--levels", "3"},
     {{"canyon", {}}, {"canyon_near", {"--camera", "60,70,60,85,5", "--sun", "200,30"}}}},
    {"caves",
     {"--sample", "caves", "--levels", "3"},
     {{"caves", {}},
      {"caves_hall", {"--camera", "-90,50,-10,-20,-6"}},
      {"caves_mouth", {"--camera", "-45,30,210,0,5"}}}},
    {"arches",
     {"--sample", "arches", "--levels", "3"},
     {{"arches", {}}, {"arches_near", {"--camera", "20,25,60,35,5", "--sun", "260,25"}}}},
    {"hills", {"--sample", "hills", "--levels", "3"}, {{"hills", {}}, {"hills_dusk", {"--sun", "285,4"}}}},
    {"bigtujunga",
     {KARST_DATA_DIR "/bigtujunga.tif", "--voxel", "256", "--levels", "3"},
     {{"bigtujunga", {}}, {"bigtujunga_near", {"--camera", "-4000,2600,6000,30,-14"}}}},
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

bool pinned_driver(const std::string& statistics) {
  return statistics.find("\"llvmpipe (LLVM 15.0.6, 256 bits)\"") != std::string::npos &&
         statistics.find("Mesa 22.3.6\"") != std::string::npos;
}

// Leaves what was drawn where it can be looked at.
std::string keep(const std::string& drawn, const std::string& name) {
  const std::filesystem::path kept =
      std::filesystem::temp_directory_path() / ("karst_golden_" + name + ".png");
  std::filesystem::copy_file(drawn, kept, std::filesystem::copy_options::overwrite_existing);
  return kept.string();
}

class Golden : public testing::TestWithParam<Case> {
 protected:
  void draw_and_compare(const View& view) {
    const std::string name = view.picture;
    const std::string drawn = folder_.path(name + ".png");
    Words words{"render", folder_.path("world.karst"), "-o", drawn, "--size", "320x180"};
    words.insert(words.end(), {"--error-px", "1", "--stats", "-"});
    words.insert(words.end(), view.camera.begin(), view.camera.end());
    const ProcessResult result = test::run_process(KARST_APP_PATH, words);
    ASSERT_EQ(result.code, 0) << result.err;
    const bool pinned = pinned_driver(result.out);
    const std::string stored = std::string(KARST_SOURCE_DIR "/tests/golden/images/") + name + ".png";
    if (std::getenv("KARST_UPDATE_GOLDEN") != nullptr) {
      ASSERT_TRUE(pinned) << "pictures are stored on the pinned driver only";
      std::filesystem::copy_file(drawn, stored, std::filesystem::copy_options::overwrite_existing);
    }
    const test::RgbPicture actual = test::read_png(drawn);
    const test::RgbPicture expected = test::read_png(stored);
    ASSERT_EQ(actual.width, 320);
    ASSERT_EQ(actual.height, 180);
    ASSERT_EQ(expected.width, 320) << stored;
    ASSERT_EQ(expected.height, 180) << stored;
    const test::Difference difference = test::compare(actual, expected);
    const bool same = pinned ? difference.largest == 0
                             : difference.mean <= kMostMean && difference.far_apart <= kMostFarApart;
    EXPECT_TRUE(same) << name << ": mean " << difference.mean << ", largest " << difference.largest << ", "
                      << difference.far_apart * 100 << " % far apart; drawn: " << keep(drawn, name);
  }

  // Draws the view once more, with options.
  test::RgbPicture draw_with(const View& view, const Words& options) {
    const std::string drawn = folder_.path("again.png");
    Words words{"render", folder_.path("world.karst"), "-o", drawn, "--size", "320x180", "--error-px", "1"};
    words.insert(words.end(), view.camera.begin(), view.camera.end());
    words.insert(words.end(), options.begin(), options.end());
    const ProcessResult result = test::run_process(KARST_APP_PATH, words);
    EXPECT_EQ(result.code, 0) << result.err;
    return test::read_png(drawn);
  }

  // What pixels and patches skip changes no bit; 16 bits where they are enough change little.
  void check_shading(const View& view) {
    const test::RgbPicture picture = draw_with(view, {});
    for (const char* skips : {"triplanar", "blend", "detail", "sun", "material", "cave",
                              "triplanar,blend,detail,sun,material,cave,cascades"}) {
      EXPECT_EQ(test::compare(picture, draw_with(view, {"--no-skip", skips})).largest, 0)
          << view.picture << " without skipping " << skips;
    }
    for (const char* shown : {"cascades", "levels"}) {
      EXPECT_GT(test::compare(picture, draw_with(view, {"--show", shown})).mean, 5.0) << shown;
    }
    const test::Difference precision = test::compare(picture, draw_with(view, {"--precision", "high"}));
    std::printf("%s: medium against high precision: mean %.3f, at most %d of 255\n", view.picture,
                precision.mean, static_cast<int>(precision.largest));
    EXPECT_LE(precision.mean, 1.0);
    EXPECT_LE(precision.largest, 4);
  }

  Folder folder_;
};

TEST_P(Golden, Picture) {
  const Case& c = GetParam();
  if (c.bake[0] != "--sample" && !std::filesystem::exists(c.bake[0])) {
    GTEST_SKIP() << c.bake[0] << " is not there; set KARST_DATA_DIR";
  }
  Words bake = c.bake;
  bake.insert(bake.end(), {"--quiet", "-o", folder_.path("world.karst")});
  const ProcessResult baked = test::run_process(KARST_BAKE_PATH, bake);
  ASSERT_EQ(baked.code, 0) << baked.err;
  for (const View& view : c.views) draw_and_compare(view);
  check_shading(c.views.back());
}

INSTANTIATE_TEST_SUITE_P(Worlds, Golden, testing::ValuesIn(kCases),
                         [](const auto& c) { return std::string(c.param.name); });

// The measure itself: that a difference is seen.
TEST(Compare, SeesDifferences) {
  test::RgbPicture a{2, 1, {10, 20, 30, 40, 50, 60}};
  test::RgbPicture b = a;
  EXPECT_EQ(test::compare(a, b).largest, 0);
  b.rgb[5] = 0;
  const test::Difference difference = test::compare(a, b);
  EXPECT_EQ(difference.largest, 60);
  EXPECT_DOUBLE_EQ(difference.mean, 10);
  EXPECT_DOUBLE_EQ(difference.far_apart, 1.0 / 6);
}

}  // namespace
}  // namespace karst::core
