// SPDX-License-Identifier: MIT
#include "bench/measure/standard_path.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

namespace karst::bench {
using namespace core;
namespace {

// 64 x 48 columns of ground at 3 voxels with a tower of 9.
struct World {
  GroundHeights ground{{64, 48}};
  LatticeBox box{{kStepsPerVoxel / 2, 0, kStepsPerVoxel / 2},
                 {63 * kStepsPerVoxel, 9 * kStepsPerVoxel, 47 * kStepsPerVoxel}};
  World() {
    ground.add({{0, 0, 0}, {64 * kStepsPerVoxel - 1, 3 * kStepsPerVoxel, 48 * kStepsPerVoxel - 1}});
    ground.add({{20 * kStepsPerVoxel, 0, 20 * kStepsPerVoxel},
                {20 * kStepsPerVoxel + 5, 9 * kStepsPerVoxel, 20 * kStepsPerVoxel + 5}});
  }
};

TEST(GroundHeights, HighestAround) {
  const World world;
  EXPECT_EQ(world.ground.highest(40, 40, 2), 3);
  EXPECT_EQ(world.ground.highest(20.5, 20.5, 0), 9);
  EXPECT_EQ(world.ground.highest(18.5, 22.5, 2), 9);
  EXPECT_EQ(world.ground.highest(17.5, 22.5, 2), 3);
  EXPECT_EQ(world.ground.highest(-100, 5, 2), 0);
}

// Where there are more voxels than columns, a column is a square of them.
TEST(GroundHeights, OfALargeWorld) {
  GroundHeights ground({1 << 15, 1 << 14});
  EXPECT_EQ(ground.shift(), 4);
  const int far = 30'000 * kStepsPerVoxel;
  ground.add({{far, 0, 0}, {far, 5 * kStepsPerVoxel, 0}});
  EXPECT_EQ(ground.highest(30'002.5, 3, 0), 5);
  EXPECT_EQ(ground.highest(30'020, 3, 2), 0);
  EXPECT_EQ(ground.highest(30'020, 3, 14), 5);
}

TEST(StandardPath, EveryFlightHasItsFramesAndValidCameras) {
  const World world;
  for (const auto name : kStandardPaths) {
    const auto path = make_standard_path(name, world.ground, world.box, 50);
    ASSERT_EQ(path.size(), 50u) << name;
    for (const CameraSettings& settings : path) {
      Camera camera;
      EXPECT_TRUE(make_camera(settings, camera).ok()) << name;
      const glm::dvec3 p = settings.position;
      EXPECT_GT(p.y, world.ground.highest(p.x, p.z, 0)) << name;
    }
    const auto again = make_standard_path(name, world.ground, world.box, 50);
    EXPECT_EQ(path[17].position, again[17].position) << name;
    EXPECT_EQ(path[17].yaw_deg, again[17].yaw_deg) << name;
  }
}

TEST(StandardPath, LoopsMoveEvenlyAndTeleportDoesNot) {
  const World world;
  for (const auto name : kStandardPaths) {
    const auto path = make_standard_path(name, world.ground, world.box, 60);
    double longest = 0;
    for (std::size_t i = 0; i < path.size(); ++i) {
      longest = std::max(longest, glm::length(path[i].position - path[(i + 1) % path.size()].position));
    }
    if (name == "teleport") {
      EXPECT_GT(longest, 15);
    } else {
      EXPECT_LT(longest, 8) << name;
    }
  }
}

TEST(StandardPath, LowStaysLowAndHighStaysHigh) {
  const World world;
  for (const CameraSettings& low : make_standard_path("low", world.ground, world.box, 60)) {
    EXPECT_LT(low.position.y - world.ground.highest(low.position.x, low.position.z, 8), 1.0);
  }
  for (const CameraSettings& high : make_standard_path("high", world.ground, world.box, 60)) {
    EXPECT_GT(high.position.y, 9 + 0.5 * 46);
    EXPECT_LT(high.pitch_deg, -30);
  }
}

}  // namespace
}  // namespace karst::bench
