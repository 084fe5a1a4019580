// SPDX-License-Identifier: MIT
// From a camera as users state it to a view: what is nearer than the near plane is cut away, and nothing is.
#include "app/stage/camera_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace karst::app {
namespace {

WorldInfo wide_world(double voxel_size_m) {
  WorldInfo world;
  world.voxel_size_m = voxel_size_m;
  world.low_m = {-40 * voxel_size_m, 0, -40 * voxel_size_m};
  world.high_m = {40 * voxel_size_m, 10 * voxel_size_m, 40 * voxel_size_m};
  return world;
}

struct Planes {
  double near_m = 0;
  double far_m = 0;
};

// Of the matrix, whichever way depth runs.
Planes planes_of(const ViewState& view) {
  const double sign = view.reversed_depth ? -1 : 1;
  const double a = sign * view.clip_from_view[10];
  const double b = sign * view.clip_from_view[14];
  return {b / (a - 1), b / (a + 1)};
}

Planes planes_at(const WorldInfo& world, const glm::dvec3& position_m, double clearance_m,
                 const PictureShape& shape) {
  CameraPlace place;
  place.position_m = position_m;
  ViewState view;
  EXPECT_TRUE(place_view(place, world, {}, shape, clearance_m, view).ok());
  EXPECT_EQ(view.reversed_depth, shape.reversed_depth);
  return planes_of(view);
}

// From the eye to the corners of the near plane's picture.
double reach_of(double near_m, const PictureShape& shape) {
  const bool on_its_side = (shape.quarter_turns & 1) != 0;
  const double aspect =
      on_its_side ? double{shape.height * 1.0} / shape.width : double{shape.width * 1.0} / shape.height;
  const double up = std::tan(shape.fov_y_deg * (3.14159265358979323846 / 360));
  return near_m * std::sqrt(1 + up * up * (1 + aspect * aspect));
}

TEST(PlaceView, TheNearPlaneCutsNothing) {
  const PictureShape shapes[] = {{1280, 720, 60, 0, false}, {1280, 720, 60, 1, true}, {64, 64, 170, 0, true}};
  for (const double voxel : {0.5, 10.0, 256.0, 2000.0}) {
    const WorldInfo world = wide_world(voxel);
    for (const PictureShape& shape : shapes) {
      for (double clearance = 2; clearance < kClearance * voxel; clearance *= 1.37) {
        const Planes planes = planes_at(world, {0, 5 * voxel, 0}, clearance, shape);
        EXPECT_LE(reach_of(planes.near_m, shape), std::max(clearance, reach_of(0.125, shape)));
        EXPECT_LE(planes.near_m, voxel / 32 * 1.0000001);
        EXPECT_GE(planes.far_m, 40 * voxel * std::sqrt(2));
      }
    }
  }
}

TEST(PlaceView, AnArmsLengthFromRock) {
  const PictureShape shape{1280, 720, 60, 0, true};
  for (const double voxel : {1.0, 256.0, 2000.0}) {
    EXPECT_LE(planes_at(wide_world(voxel), {0, 5 * voxel, 0}, 0.3, shape).near_m, 0.1250001) << voxel;
    EXPECT_GE(planes_at(wide_world(voxel), {0, 5 * voxel, 0}, 0, shape).near_m, voxel < 2 ? 0.03 : 0.0625);
  }
}

// A flight down to the ground has few near planes, each a half of the one before.
TEST(PlaceView, NearMovesInStepsOfTwo) {
  const WorldInfo world = wide_world(256);
  const PictureShape shape{1280, 720, 60, 0, true};
  double last = 8;  // 1/32 voxel
  int steps = 0;
  for (double clearance = 64; clearance > 0.01; clearance *= 0.99) {
    const double near_m = planes_at(world, {0, 1280, 0}, clearance, shape).near_m;
    if (std::abs(near_m - last) < 1e-6) continue;
    EXPECT_NEAR(near_m, last / 2, 1e-6);
    last = near_m;
    ++steps;
  }
  EXPECT_EQ(steps, 7);
}

TEST(PlaceView, FromOutsideNearIsFarAway) {
  const WorldInfo world = wide_world(10);
  for (const PictureShape& shape :
       {PictureShape{1280, 720, 60, 0, false}, PictureShape{1280, 720, 150, 0, true}}) {
    const Planes planes = planes_at(world, {0, 1100, 0}, 2.5, shape);
    EXPECT_GT(reach_of(planes.near_m, shape), 500);
    EXPECT_LT(reach_of(planes.near_m, shape), 1000);
    EXPECT_GT(planes.far_m, planes.near_m);
  }
}

}  // namespace
}  // namespace karst::app
