// SPDX-License-Identifier: MIT
#include "bench/measure/elevation_grid.h"

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <png.h>

#include "tests/support/process.h"

namespace karst::bench {
namespace {

std::string png_of(png_uint_32 format, png_uint_32 columns, png_uint_32 rows, const void* pixels) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = columns;
  image.height = rows;
  image.format = format;
  png_alloc_size_t bytes = 0;
  EXPECT_NE(png_image_write_to_memory(&image, nullptr, &bytes, 0, pixels, 0, nullptr), 0);
  std::string png(bytes, '\0');
  EXPECT_NE(png_image_write_to_memory(&image, png.data(), &bytes, 0, pixels, 0, nullptr), 0);
  return png;
}

constexpr std::uint16_t kSamples[6] = {0, 1000, 65535, 7, 256, 50000};

TEST(ReadElevation, SixteenBits) {
  const test::Folder folder;
  const std::string path = folder.write("a.png", png_of(PNG_FORMAT_LINEAR_Y, 3, 2, kSamples));
  ElevationGrid grid;
  ASSERT_EQ(read_elevation_png(path, 2.5, 0.5, grid).text(), "");
  EXPECT_EQ(grid.columns, 3);
  EXPECT_EQ(grid.rows, 2);
  EXPECT_EQ(grid.spacing_x_m, 2.5);
  EXPECT_EQ(grid.heights_m, (std::vector<float>{0, 500, 32767.5f, 3.5f, 128, 25000}));
}

TEST(ReadElevation, WhatIsNoElevation) {
  const test::Folder folder;
  const std::string grey = png_of(PNG_FORMAT_LINEAR_Y, 3, 2, kSamples);
  const std::vector<std::uint8_t> colours(3 * 2 * 3);
  ElevationGrid grid;
  const auto refused = [&](const std::string& bytes, const std::string& why) {
    const std::string path = folder.write("bad.png", bytes);
    EXPECT_EQ(read_elevation_png(path, 1, 1, grid).text(), path + ": " + why);
  };
  refused("not a picture", "not a PNG file");
  refused(png_of(PNG_FORMAT_RGB, 3, 2, colours.data()), "not grey of 8 or 16 bits");
  refused(png_of(PNG_FORMAT_LINEAR_Y, 1, 2, kSamples), "not 2..32768 samples a side");
  refused(grey.substr(0, grey.size() - 30), "cut short");
  EXPECT_NE(read_elevation_png(folder.path("none.png"), 1, 1, grid).text(), "");
}

TEST(ElevationGrid, RangeHoldsBothDiagonals) {
  ElevationGrid grid;
  grid.columns = grid.rows = 2;
  grid.spacing_x_m = 10;
  grid.spacing_z_m = 20;
  grid.heights_m = {0, 4, 2, 0};  // a saddle
  const ElevationGrid::Range middle = grid.range(0, 0);
  EXPECT_DOUBLE_EQ(middle.low_m, 0);   // from the first sample to the last
  EXPECT_DOUBLE_EQ(middle.high_m, 3);  // between the other two
  const ElevationGrid::Range corner = grid.range(5, -10);
  EXPECT_DOUBLE_EQ(corner.low_m, 4);
  EXPECT_DOUBLE_EQ(corner.high_m, 4);
  const ElevationGrid::Range beyond = grid.range(50, -100);
  EXPECT_DOUBLE_EQ(beyond.low_m, 4);
}

TEST(ElevationGrid, InsideLeavesAMargin) {
  ElevationGrid grid;
  grid.columns = 11;
  grid.rows = 5;
  grid.spacing_x_m = grid.spacing_z_m = 2;
  EXPECT_TRUE(grid.inside(6, 0, 2));
  EXPECT_FALSE(grid.inside(6.1, 0, 2));
  EXPECT_FALSE(grid.inside(0, 0.1, 2));
}

}  // namespace
}  // namespace karst::bench
