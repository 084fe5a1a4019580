// SPDX-License-Identifier: MIT
// Samples in their ground: both sides have the same heights where they meet, and the ground ends level.
#include "bake/samples/sample_ground.h"

#include "bake/elevation/elevation_solid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace karst::bake {
namespace {

TEST(SampleGround, NodesAreAroundTheMiddleAndVoxelsDivideThem) {
  for (const SampleName& name : sample_names()) {
    const Sample sample = make_sample(name.name, 2);
    for (const double voxel_m : {4.0, 8.0, 10.0, 100.0}) {
      SampleGrid grid;
      ASSERT_TRUE(SampleGrid::around(sample, voxel_m, grid).ok()) << name.name << ' ' << voxel_m;
      EXPECT_DOUBLE_EQ(std::ldexp(voxel_m, grid.node_voxels_log2), 4 * grid.spacing_m);
      for (int axis = 0; axis < 2; ++axis) {
        EXPECT_GE(grid.first_node[axis], 1);
        EXPECT_EQ(4 * (2 * grid.first_node[axis] + grid.nodes[axis]) + 1, grid.samples[axis]);
        EXPECT_LE((grid.nodes[axis] << grid.node_voxels_log2) + 1, 512);
      }
    }
  }
}

TEST(SampleGround, HeightsDoNotDependOnThreadsAndEndLevel) {
  const Sample sample = make_sample("hills", 2);
  SampleGrid grid;
  ASSERT_TRUE(SampleGrid::around(sample, 64, grid).ok());
  const Elevation one = sample_elevation(sample, grid, 1), three = sample_elevation(sample, grid, 3);
  EXPECT_EQ(one.heights_m, three.heights_m);
  const auto [low, high] = std::minmax_element(one.heights_m.begin(), one.heights_m.end());
  EXPECT_GT(*high - *low, 20.0f);
  for (int n = 0; n < one.width; ++n) {
    EXPECT_EQ(one.heights_m[static_cast<std::size_t>(n)], one.heights_m[0]);
    EXPECT_EQ(one.heights_m[one.heights_m.size() - 1 - static_cast<std::size_t>(n)], one.heights_m[0]);
  }
}

TEST(SampleGround, TheSampleIsTheGroundAtItsSidesAndItselfInside) {
  const Sample sample = make_sample("canyon", 2);
  SampleGrid grid;
  ASSERT_TRUE(SampleGrid::around(sample, sample.voxel_m, grid).ok());
  const Elevation elevation = sample_elevation(sample, grid, 2);
  const ElevationSolid ground(elevation, false);
  const Box box = grid.rectangle_m();
  const double width_m = 3.5 * sample.voxel_m;
  const SampleInGround joined(*sample.solid, ground.surface(), box, width_m);
  int inside_differs = 0;
  for (int n = 0; n <= 200; ++n) {
    const double t = n / 200.0;
    const double x = box.min.x + t * (box.max.x - box.min.x), z = box.min.z + t * (box.max.z - box.min.z);
    for (const glm::dvec3 side : {glm::dvec3(x, 0, box.min.z), glm::dvec3(x, 0, box.max.z),
                                  glm::dvec3(box.min.x, 0, z), glm::dvec3(box.max.x, 0, z)}) {
      const double height = ground.surface().at(side.x, side.z);
      for (const double away : {-30.0, -1.0, 0.0, 1.0, 30.0})
        EXPECT_EQ(joined.value_m({side.x, height + away, side.z}), height - (height + away)) << n;
      // Slopes are the ground's too: a hundredth of the way in next to nothing is the sample's.
      const glm::dvec3 in = side * (1 - 0.01 * width_m / std::max(box.max.x, box.max.z));
      const double below = ground.surface().at(in.x, in.z) - height;
      EXPECT_NEAR(joined.value_m({in.x, height, in.z}), below, 0.05) << n;
    }
    const glm::dvec3 middle(0.7 * x, sample.content_m.min.y + t * 100, 0.7 * z);
    EXPECT_EQ(joined.value_m(middle), sample.solid->value_m(middle));
    inside_differs +=
        std::abs(joined.value_m(middle) - (ground.surface().at(middle.x, middle.z) - middle.y)) > 1 ? 1 : 0;
  }
  // Else the sample would be its ground.
  EXPECT_GT(inside_differs, 20);
}

}  // namespace
}  // namespace karst::bake
