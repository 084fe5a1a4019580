// SPDX-License-Identifier: MIT
// Bakes and draws the samples and a real elevation model, and compares with the stored pictures; see
// README.md.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/golden/cases.h"
#include "tests/golden/picture.h"
#include "tests/support/elsewhere.h"
#include "tests/support/process.h"

namespace karst::test {

static void PrintTo(const GoldenWorld& world, std::ostream* out) {
  *out << world.name;
}

}  // namespace karst::test

namespace karst::core {
namespace {

using test::Folder;
using test::GoldenView;
using test::GoldenWorld;
using test::ProcessResult;
using test::Words;

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

class Golden : public testing::TestWithParam<GoldenWorld> {
 protected:
  void draw_and_compare(const GoldenView& view) {
    const std::string name = view.picture;
    const std::string drawn = folder_.path(name + ".png");
    Words words = test::golden_words(world_, view, drawn);
    words.insert(words.end(), {"--stats", "-"});
    const ProcessResult result = test::run_process(app_, words);
    ASSERT_EQ(result.code, 0) << result.err;
    const bool pinned = pinned_ = pinned_driver(result.out);
    const std::string stored = images_ + "/" + name + ".png";
    if (std::getenv("KARST_UPDATE_GOLDEN") != nullptr) {
      ASSERT_TRUE(pinned) << "pictures are stored on the pinned driver only";
      std::filesystem::copy_file(drawn, stored, std::filesystem::copy_options::overwrite_existing);
    }
    const test::RgbPicture actual = test::read_png(drawn);
    const test::RgbPicture expected = test::read_png(stored);
    ASSERT_EQ(actual.width, test::kGoldenWidth);
    ASSERT_EQ(actual.height, test::kGoldenHeight);
    ASSERT_EQ(expected.width, test::kGoldenWidth) << stored;
    ASSERT_EQ(expected.height, test::kGoldenHeight) << stored;
    const test::Difference difference = test::compare(actual, expected);
    const bool same = pinned ? difference.largest == 0 : test::close_enough(difference);
    EXPECT_TRUE(same) << name << ": mean " << difference.mean << ", largest " << difference.largest << ", "
                      << difference.far_apart * 100 << " % far apart; drawn: " << keep(drawn, name);
  }

  // Draws the view once more, with options.
  test::RgbPicture draw_with(const GoldenView& view, const Words& options) {
    const std::string drawn = folder_.path("again.png");
    Words words = test::golden_words(world_, view, drawn);
    words.insert(words.end(), options.begin(), options.end());
    const ProcessResult result = test::run_process(app_, words);
    EXPECT_EQ(result.code, 0) << result.err;
    return test::read_png(drawn);
  }

  // What pixels and patches skip changes no bit where the driver rounds one expression alike in two programs;
  // others contract multiplications and additions as each program comes.
  void check_same(const test::RgbPicture& picture, const test::RgbPicture& other, const std::string& what) {
    const test::Difference difference = test::compare(picture, other);
    EXPECT_LE(difference.largest, pinned_ ? 0 : 1) << what;
    EXPECT_LE(difference.mean, 1e-3) << what;
  }

  // 16 bits where they are enough, and shading pixels while they are drawn, change little.
  void check_shading(const GoldenView& view) {
    const test::RgbPicture picture = draw_with(view, {});
    for (const char* skips : {"triplanar", "blend", "detail", "sun", "material", "cave",
                              "triplanar,blend,detail,sun,material,cave,cascades"}) {
      check_same(picture, draw_with(view, {"--no-skip", skips}),
                 std::string(view.picture) + " without skipping " + skips);
    }
    for (const char* shown : {"cascades", "levels"}) {
      EXPECT_GT(test::compare(picture, draw_with(view, {"--show", shown})).mean, 5.0) << shown;
    }
    const test::RgbPicture forward = draw_with(view, {"--shading", "forward"});
    // Not the frustum: what is out of view of a ground takes the room of what is in it.
    check_same(forward,
               draw_with(view, {"--shading", "forward", "--no-skip",
                                "backface,occlusion,triplanar,blend,detail,sun,material,cave,cascades"}),
               std::string(view.picture) + " forward without skipping");
    const test::Difference way = test::compare(draw_with(view, {"--shading", "deferred"}), forward);
    std::printf("%s: forward against deferred: mean %.4f, at most %d of 255, %.4f %% beyond 1\n",
                view.picture, way.mean, static_cast<int>(way.largest), way.beyond_one * 100);
    EXPECT_LE(way.mean, pinned_ ? 0.02 : 0.03);
    EXPECT_LE(way.beyond_one, 1e-3);
    const test::Difference precision =
        test::compare(draw_with(view, {"--precision", "medium"}), draw_with(view, {"--precision", "high"}));
    std::printf("%s: medium against high precision: mean %.3f, at most %d of 255\n", view.picture,
                precision.mean, static_cast<int>(precision.largest));
    EXPECT_LE(precision.mean, 1.0);
    EXPECT_LE(precision.largest, 4);
  }

  bool pinned_ = true;
  Folder folder_;
  std::string world_;
  const std::string app_ = test::path_from("KARST_APP_PATH", KARST_APP_PATH);
  const std::string images_ = test::path_from("KARST_GOLDEN_IMAGES", KARST_SOURCE_DIR "/tests/golden/images");
};

TEST_P(Golden, Picture) {
  const GoldenWorld& c = GetParam();
  if (std::getenv("KARST_WORLDS") == nullptr && !c.bake[0].starts_with("--") &&
      !std::filesystem::exists(c.bake[0])) {
    GTEST_SKIP() << c.bake[0] << " is not there; set KARST_DATA_DIR";
  }
  const test::BakedWorld baked = test::baked_world(folder_, c.name, KARST_BAKE_PATH, c.bake);
  if (baked.path.empty()) GTEST_SKIP() << baked.missing;
  world_ = baked.path;
  for (const GoldenView& view : c.views) draw_and_compare(view);
  check_shading(c.views.back());
}

INSTANTIATE_TEST_SUITE_P(Worlds, Golden, testing::ValuesIn(test::kGoldenWorlds),
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
