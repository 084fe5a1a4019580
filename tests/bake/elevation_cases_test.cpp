// SPDX-License-Identifier: MIT
// Elevation that was once read wrongly and in silence, as it was reported: files of ../shared/cases. The same
// kinds are made by elevation_test.cpp and raster_test.cpp.
#include "bake/pipeline/bake.h"
#include "tests/support/process.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace karst::bake {
namespace {

class ElevationCases : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(path("ok_float32.tif"))) GTEST_SKIP() << folder_ << " is not there";
  }
  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  Bake job(const std::string& name, double voxel_m = 0, int level = 2) const {
    Bake result;
    result.materials.none = true;
    result.read.path = path(name);
    result.voxel_m = voxel_m;
    result.level = level;
    return result;
  }

  const std::string folder_ = KARST_DATA_DIR "/../cases";
};

Bake::Report report_of(const Bake& job) {
  Bake::Report report;
  std::vector<std::byte> world;
  EXPECT_EQ(job.run(report, {}, world).text(), "");
  return report;
}

std::string error_of(const Bake& job) {
  Bake::Report report;
  std::vector<std::byte> world;
  return job.run(report, {}, world).text();
}

// Hills, 570.6 to 1449 m, 64 x 64 samples of 30 m, in the same voxels whatever they are written as.
TEST_F(ElevationCases, HillsAreTheSameHoweverTheyAreWritten) {
  const struct {
    const char* name;
    double lowest_m;
    double off_m;
  } cases[] = {{"double_same_as_float.tif", 570.551, 0.001},
               {"double.tif", 570.551, 0.001},
               {"bits12.tif", 571, 0},
               {"scale_offset.tif", 570.55, 0.001},
               {"epsg2227_ftus.tif", 570.55, 0.2}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    const Bake::Report report = report_of(job(c.name, 150));
    EXPECT_NEAR(report.spacing_x_m, 30, 0.001);
    EXPECT_NEAR(report.spacing_z_m, 30, 0.001);
    EXPECT_NEAR(report.lowest_m, c.lowest_m, c.off_m + 1e-3);
    EXPECT_NEAR(report.highest_m, 1449, c.off_m + 1e-3);
    EXPECT_EQ(report.info.extent, glm::ivec3(13, 10, 13));
    EXPECT_EQ(report.info.origin_m[1], 150);
  }
}

TEST_F(ElevationCases, MasksAreVoids) {
  EXPECT_DOUBLE_EQ(report_of(job("internal_mask.tif", 150)).void_share, 0.3125);
}

TEST_F(ElevationCases, DegreesAreThoseOfTheirLatitude) {
  Bake crop = job("globe3deg.tif", 100'000);
  crop.accept_fit = true;
  const int window[] = {60, 8, 10, 10};
  std::copy(std::begin(window), std::end(window), crop.read.crop);
  Bake part = job("globe3deg_part.tif", 100'000);
  part.accept_fit = true;
  for (const Bake& one : {crop, part}) {
    const Bake::Report report = report_of(one);
    EXPECT_NEAR(report.spacing_x_m, 210'593, 1);
    EXPECT_NEAR(report.spacing_z_m, 333'745, 1);
  }
  for (const char* name : {"deg9122.tif", "esri.bil"}) {
    const Bake::Report report = report_of(job(name, 150));
    EXPECT_NEAR(report.spacing_x_m, 79.11, 0.01) << name;
    EXPECT_NEAR(report.spacing_z_m, 92.40, 0.01) << name;
    EXPECT_EQ(report.lowest_m, 571) << name;
  }
}

TEST_F(ElevationCases, TheSlopeIsTheSameHoweverItLies) {
  for (const char* name : {"ok_float32.tif", "web_mercator_60n.tif", "south_up.tif"}) {
    SCOPED_TRACE(name);
    const Bake::Report report = report_of(job(name, 240));
    EXPECT_EQ(report.info.extent, glm::ivec3(12, 9, 12));
    EXPECT_EQ(report.info.origin_m[0], -1440);
    EXPECT_EQ(report.info.origin_m[1], -480);
    EXPECT_EQ(report.info.origin_m[2], -1440);
  }
  Elevation north_up, south_up;
  ASSERT_EQ(job("ok_float32.tif").read.run(north_up).text(), "");
  ReadElevation read = job("south_up.tif").read;
  ASSERT_EQ(read.run(south_up).text(), "");
  EXPECT_EQ(north_up.heights_m, south_up.heights_m);
  read.pixel_size_m = 30;
  ASSERT_EQ(read.run(south_up).text(), "");
  EXPECT_EQ(north_up.heights_m, south_up.heights_m) << "a size turns no image";
}

TEST_F(ElevationCases, All512VoxelsMayBeUsed) {
  EXPECT_EQ(report_of(job("wide1030.tif", 2.01)).info.extent.x, 512);
}

TEST_F(ElevationCases, WhatCannotBeKnownIsToldAtOnce) {
  EXPECT_NE(error_of(job("steep.tif")).find("--accept-fit"), std::string::npos);
  EXPECT_NE(error_of(job("no_crs_degrees.tif")).find("--pixel-size"), std::string::npos);
  Bake heightmap = job("heightmap_full_range.png");
  heightmap.read.pixel_size_m = 30;
  EXPECT_NE(error_of(heightmap).find("--z-scale"), std::string::npos);
  Bake bomb = job("tile_bomb64.tif");
  bomb.read.pixel_size_m = 1;
  EXPECT_NE(error_of(bomb).find("4096 x 4096 samples in a file of 286 bytes"), std::string::npos);
  Bake untagged = job("untagged_m9999.tif");
  untagged.accept_fit = true;
  const Bake::Report report = report_of(untagged);
  ASSERT_FALSE(report.warnings.empty());
  EXPECT_NE(report.warnings[0].find("--nodata -9999"), std::string::npos);
}

}  // namespace
}  // namespace karst::bake
