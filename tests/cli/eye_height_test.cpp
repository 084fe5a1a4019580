// SPDX-License-Identifier: MIT
// Pictures from a person's height over voxels that are a hundred times larger.
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "app/files/png_file.h"
#include "app/files/whole_file.h"
#include "tests/support/process.h"
#include "tests/support/test_world.h"

namespace karst::app {
namespace {

// Level ground, voxels of 256 m: a picture straight down from a person's height shows nothing else.
TEST(EyeHeight, NoSkyBelowAPerson) {
  test::TestWorld ground({12, 8, 12}, [](glm::ivec3 v) { return v.y < 4; });
  ground.roughen(3, 1, 0);
  ground.voxel_size_m = 256;
  const test::Folder folder;
  const std::string world = folder.write("world.karst", ground.file());
  const auto drawn = [&](const std::string& camera) {
    const test::ProcessResult result = test::run_process(
        KARST_APP_PATH, {"render", world, "-o", folder.path("a.png"), "--size", "64x36", "--camera", camera},
        {});
    EXPECT_EQ(result.code, 0) << result.err;
    WholeFile file;
    PngPicture picture;
    EXPECT_EQ(file.open(folder.path("a.png"), WholeFile::kMostText).text(), "");
    EXPECT_EQ(decode_png(file.bytes(), 64, 1 << 20, picture).text(), "");
    int blue = 0;
    for (std::size_t n = 0; n + 3 < picture.rgba.size(); n += 4)
      blue += picture.rgba[n + 2] > picture.rgba[n];
    return blue;
  };
  EXPECT_EQ(drawn("1500,~0.5,1500,10,90"), 64 * 36);
  for (const char* camera : {"1500,~1.7,1500,10,-90", "1500,~1.7,1500,10,-40", "1500,~0.25,1500,10,-60"})
    EXPECT_EQ(drawn(camera), 0) << camera;
}

// A world without materials is of one plain one, whose two textures say the same at any distance: from less
// than a metre a pixel to 200.
TEST(EyeHeight, PlainGroundHasOneColourNearAndFar) {
  test::TestWorld ground({64, 8, 64}, [](glm::ivec3 v) { return v.y < 4; });
  ground.roughen(2, 1, 0);
  ground.voxel_size_m = 30;
  const test::Folder folder;
  const std::string world = folder.write("world.karst", ground.file());
  std::vector<std::uint8_t> first;
  for (const char* height : {"~1.7", "~10", "~100", "~500", "~1000", "~1900"}) {
    const test::ProcessResult result =
        test::run_process(KARST_APP_PATH,
                          {"render", world, "-o", folder.path("a.png"), "--size", "16x9", "--shadows", "0",
                           "--haze", "10000000", "--camera", std::string("960,") + height + ",960,0,-90"},
                          {});
    ASSERT_EQ(result.code, 0) << result.err;
    WholeFile file;
    PngPicture picture;
    ASSERT_EQ(file.open(folder.path("a.png"), WholeFile::kMostText).text(), "");
    ASSERT_EQ(decode_png(file.bytes(), 16, 1 << 20, picture).text(), "");
    const std::size_t middle = std::size_t{4} * (16 * 4 + 8);
    if (first.empty()) first.assign(picture.rgba.data() + middle, picture.rgba.data() + middle + 3);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(picture.rgba[middle + c], first[c], 2) << height;
  }
}

}  // namespace
}  // namespace karst::app
