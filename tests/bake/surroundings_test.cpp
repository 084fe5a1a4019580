// SPDX-License-Identifier: MIT
// The sea's bed, the rim, and the level of the water in a baked world.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include "bake/surroundings/sink_sea.h"
#include "bake/surroundings/trace_rim.h"
#include "tests/bake/bake_files.h"
#include "tests/bake/bake_jobs.h"
#include "tests/support/process.h"
#include "tests/support/test_world.h"
#include "tests/support/world_io.h"

namespace karst::bake {
namespace {

Elevation flat(int width, int height, float height_m) {
  Elevation e;
  e.width = width;
  e.height = height;
  e.heights_m.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), height_m);
  e.valid.assign(e.heights_m.size(), 1);
  e.spacing_x_m = 10;
  e.spacing_z_m = 20;
  return e;
}

TEST(SinkSea, GetsDeeperWithTheDistanceFromLand) {
  Elevation e = flat(40, 30, 7);
  e.heights_m[e.at(20, 15)] = 9;  // an island
  for (int j = 0; j < 30; ++j) e.heights_m[e.at(0, j)] = 8;
  e.heights_m[e.at(35, 3)] = 7.2f;  // as high as the water, nearly
  e.heights_m[e.at(36, 28)] = -50;  // a bed that is known
  const std::vector<float> before = e.heights_m;
  EXPECT_EQ((SinkSea{7}.run(e)), before.size() - 32);
  for (int j = 0; j < 30; ++j) {
    for (int i = 0; i < 40; ++i) {
      const std::size_t n = e.at(i, j);
      const bool is_land = before[n] > 7.5f || before[n] < 0;
      if (is_land) {
        EXPECT_EQ(e.heights_m[n], before[n]);
        continue;
      }
      double away_m = std::min(10.0 * i, std::hypot(10.0 * (i - 20), 20.0 * (j - 15)));
      away_m = std::min(away_m, std::hypot(10.0 * (i - 36), 20.0 * (j - 28)));
      const double depth_m = 7 - double{e.heights_m[n]};
      EXPECT_GE(depth_m, 0.999 * SinkSea::kSlope * away_m) << i << ' ' << j;
      EXPECT_LE(depth_m, std::min(1.2 * SinkSea::kSlope * away_m, SinkSea::kDepthM)) << i << ' ' << j;
    }
  }
}

TEST(SinkSea, AnImageOfWaterAloneIsDeep) {
  Elevation e = flat(4, 4, -3);
  EXPECT_EQ((SinkSea{-3}.run(e)), 16u);
  for (const float h : e.heights_m) EXPECT_EQ(h, -3 - static_cast<float>(SinkSea::kDepthM));
  e = flat(4, 4, -2);
  EXPECT_EQ((SinkSea{-3}.run(e)), 0u);
}

// A slope to the east: the rim is its border, at its heights, once around.
TEST(Rim, RunsClockwiseAlongTheBorder) {
  const glm::ivec3 extent(9, 8, 6);
  karst::test::TestWorld world(extent, [](glm::ivec3 v) { return v.y < 2 + v.x / 3; });
  world.set_heights(3, [](glm::dvec3) { return 500.0; });
  const std::vector<glm::ivec3> rim = trace_rim(world.surface(), world.heights(), extent);
  ASSERT_EQ(rim.size(), 8u * (8 + 5));
  double area = 0;  // positive where it runs from x to z
  for (std::size_t n = 0; n < rim.size(); ++n) {
    const glm::dvec3 a = glm::dvec3(rim[n]) / double{kStepsPerVoxel};
    const glm::dvec3 b = glm::dvec3(rim[(n + 1) % rim.size()]) / double{kStepsPerVoxel};
    area += 0.5 * (a.x * b.z - b.x * a.z);
    // Displaced by 500 steps at most, off one of the sides.
    const double off =
        std::min({std::abs(a.x - 0.5), std::abs(a.x - 8.5), std::abs(a.z - 0.5), std::abs(a.z - 5.5)});
    EXPECT_LE(off, 0.07) << n;
    const double ground = 2 + std::floor(std::clamp(a.x, 0.6, 8.4)) / 3;
    EXPECT_NEAR(a.y, ground, 1.2) << n;
    EXPECT_LE(std::hypot(b.x - a.x, b.z - a.z), 0.5) << n;
  }
  EXPECT_NEAR(area, 8 * 5, 2);
  // The corner where north and west meet is the first point, and lies on the ground.
  EXPECT_NEAR(rim[0].x, kStepsPerVoxel / 2, 500);
  EXPECT_NEAR(rim[0].z, kStepsPerVoxel / 2, 500);
  EXPECT_NEAR(rim[0].y, 2 * kStepsPerVoxel, 501);
}

TEST(Rim, IsEmptyWhereASideHasNoGround) {
  const glm::ivec3 extent(6, 6, 6);
  const karst::test::TestWorld world(
      extent, [](glm::ivec3 v) { return v.y < 3 && v.x > 1 && v.x < 4 && v.z > 1 && v.z < 4; });
  EXPECT_TRUE(trace_rim(world.surface(), world.heights(), extent).empty());
}

class WaterBake : public ::testing::Test {
 protected:
  // An island of 60 m in a sea at 0.
  Bake job() const {
    std::vector<float> heights;
    for (int j = 0; j < 40; ++j) {
      for (int i = 0; i < 40; ++i) {
        const float away = std::hypot(static_cast<float>(i) - 20, static_cast<float>(j) - 20);
        heights.push_back(std::max(0.0f, 60 - 6 * away));
      }
    }
    const std::string bytes(bytes_of(heights));
    folder_.write("island.tif", TiffBuilder(40, 40, 32, 3, bytes).pixel_scale(10, 10).bytes());
    Bake result;
    result.materials.none = true;
    result.read.path = folder_.path("island.tif");
    result.voxel_m = 25;
    result.level = 3;
    return result;
  }

  test::Folder folder_;
};

TEST_F(WaterBake, LevelAndBedAreInTheWorld) {
  Bake bake = job();
  bake.water_m = 0;
  Bake::Report report;
  const std::vector<std::byte> file = world_of(bake, report);
  EXPECT_GT(report.sunk_samples, 1000u);
  core::WorldReader reader;
  ASSERT_TRUE(reader.open(core::ByteSource::of(file)).ok());
  const core::Surroundings& around = reader.surroundings();
  ASSERT_TRUE(around.has_water());
  EXPECT_NEAR(report.info.origin_m[1] + 25 * double{around.water_level}, 0, 1e-4);
  // The rim is the sea's bed: 200 m from the coast or less.
  EXPECT_EQ(around.rim_points, 16u * static_cast<std::uint32_t>(report.info.extent.x - 1));
  const double plain_m = report.info.origin_m[1] + 25 * double{around.plain_level};
  EXPECT_LT(plain_m, -4);
  EXPECT_GT(plain_m, -12);
}

TEST_F(WaterBake, WithoutTheOptionThereIsNone) {
  Bake::Report report;
  const std::vector<std::byte> file = world_of(job(), report);
  EXPECT_EQ(report.sunk_samples, 0u);
  core::WorldReader reader;
  ASSERT_TRUE(reader.open(core::ByteSource::of(file)).ok());
  EXPECT_FALSE(reader.surroundings().has_water());
  EXPECT_GT(reader.surroundings().rim_points, 0u);
}

}  // namespace
}  // namespace karst::bake
