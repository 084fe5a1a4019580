// SPDX-License-Identifier: MIT
// Folds: found where they are, taken out, and shared vertices stay equal.
#include "bake/voxels/repair_folds.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <vector>

#include "terrain/patch/heights.h"
#include "terrain/patch/shared_vertices.h"
#include "tests/support/test_world.h"

namespace karst::bake {
using namespace core;
namespace {

constexpr int kLevel = 3;

RepairFolds repair_job(const test::TestWorld& world, std::vector<std::int16_t>& heights) {
  RepairFolds repair;
  repair.surface = world.surface();
  repair.level = kLevel;
  repair.heights = heights;
  return repair;
}

std::size_t disagreements(const Surface& surface, const std::vector<std::int16_t>& heights) {
  const int side = patch_side(kLevel);
  const auto at = [&](GridVertex v) {
    const std::size_t block = static_cast<std::size_t>(patch_vertices(kLevel));
    return heights[std::size_t{v.patch} * block + static_cast<std::size_t>(v.j * side + v.i)];
  };
  std::size_t count = 0;
  for (PatchId p = 0; p < surface.patches.size(); ++p) {
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        for_each_copy(surface.patches, kLevel, {p, i, j}, [&](GridVertex copy) {
          count += at(copy) != at({p, i, j});
        });
      }
    }
  }
  return count;
}

TEST(RepairFolds, RefusesEachWrongField) {
  test::TestWorld world = test::TestWorld::noise(1, {8, 8, 8}, 0.5, 3.0, false);
  world.roughen(kLevel, 1, 100);
  std::vector<std::int16_t> heights = world.height_samples();
  const RepairFolds good = repair_job(world, heights);
  ASSERT_TRUE(good.validate().ok());
  RepairFolds repair = good;
  repair.level = 7;
  EXPECT_STREQ(repair.validate().field(), "level");
  repair = good;
  repair.heights = repair.heights.first(1);
  EXPECT_STREQ(repair.validate().field(), "heights");
  repair = good;
  repair.most_folded = 2;
  EXPECT_STREQ(repair.validate().field(), "most_folded");
  repair = good;
  repair.max_passes = 0;
  EXPECT_STREQ(repair.validate().field(), "max_passes");
}

TEST(RepairFolds, LeavesSmoothGroundAlone) {
  test::TestWorld world({16, 12, 16}, [](glm::ivec3 v) { return v.y < 5 + v.x / 8; });
  world.set_heights(kLevel, [](glm::dvec3) { return 500.0; });
  std::vector<std::int16_t> heights = world.height_samples();
  const RepairFolds::Result result = repair_job(world, heights).run();
  EXPECT_EQ(result.folded_before, 0u);
  EXPECT_EQ(result.vertices_moved, 0u);
  EXPECT_EQ(heights, world.height_samples());
}

TEST(RepairFolds, TakesFoldsOut) {
  test::TestWorld world = test::TestWorld::noise(8, {14, 14, 14}, 0.5, 4.0, false);
  world.roughen(kLevel, 3, 4000);
  std::vector<std::int16_t> heights = world.height_samples();
  ASSERT_EQ(disagreements(world.surface(), heights), 0u);
  const RepairFolds::Result result = repair_job(world, heights).run();
  EXPECT_GT(result.folded_before, 100u);
  EXPECT_EQ(result.folded_after, 0u);
  EXPECT_GT(result.vertices_moved, 100u);
  EXPECT_EQ(disagreements(world.surface(), heights), 0u);
  // A second look finds none.
  EXPECT_EQ(repair_job(world, heights).run().folded_before, 0u);
}

TEST(RepairFolds, LeavesGroundAloneThatFoldsEverywhere) {
  test::TestWorld world = test::TestWorld::noise(8, {40, 20, 40}, 0.5, 2.0, false);
  world.roughen(kLevel, 3, 28000);
  std::vector<std::int16_t> heights = world.height_samples();
  RepairFolds repair = repair_job(world, heights);
  const RepairFolds::Result result = repair.run();
  const double triangles = 2.0 * static_cast<double>(repair.surface.patches.size()) * 64;
  std::printf("%.3f of the triangles are folded\n", static_cast<double>(result.folded_before) / triangles);
  EXPECT_GT(static_cast<double>(result.folded_before), repair.most_folded * triangles);
  EXPECT_EQ(result.folded_after, result.folded_before);
  EXPECT_EQ(result.passes, 0);
  EXPECT_EQ(heights, world.height_samples());
  // So much and no less.
  repair.most_folded = static_cast<double>(result.folded_before) / triangles;
  repair.max_passes = 1;
  EXPECT_GT(repair.run().vertices_moved, 0u);
}

TEST(RepairFolds, IsBoundedWhereFoldsDoNotEnd) {
  // Steps of heights that no averaging takes out in a few passes; the surface is larger than the least
  // visits.
  test::TestWorld world = test::TestWorld::noise(8, {40, 20, 40}, 0.5, 2.0, false);
  world.roughen(kLevel, 3, 28000);
  std::vector<std::int16_t> heights = world.height_samples();
  RepairFolds repair = repair_job(world, heights);
  const auto patches = static_cast<std::uint64_t>(repair.surface.patches.size());
  repair.most_folded = 1;
  repair.visits_per_patch = 1;
  repair.least_visits = 0;
  const RepairFolds::Result few = repair.run();
  EXPECT_GT(few.folded_after, 0u);
  EXPECT_LE(few.passes, 8) << patches;
  EXPECT_EQ(disagreements(world.surface(), heights), 0u);
  // What is told to be left is what is there.
  EXPECT_EQ(repair_job(world, heights).run().folded_before, few.folded_after);
}

}  // namespace
}  // namespace karst::bake
