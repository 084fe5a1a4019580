// SPDX-License-Identifier: MIT
// Edits of voxels in a loaded world: all that follows is what a file of the edited world loads.
#include "terrain/edit/shape/edit_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/edited_world.h"
#include "tests/support/heap_count.h"

namespace karst::core {
namespace {

using test::LoadedWorld;
using test::TestWorld;

constexpr std::uint32_t kRoom = 2'000;

TestWorld rough_world(std::uint64_t seed) {
  TestWorld world = TestWorld::noise(seed, {14, 11, 13}, 0.45, 5.0, false);
  world.roughen(2, seed + 7, 1500);
  return world;
}

TEST(EditShape, AThousandEditsAreWhatAFileLoads) {
  test::Random random{11};
  std::uint32_t changed = 0;
  for (std::uint64_t round = 0; round < 20; ++round) {
    LoadedWorld live(rough_world(round).file(), kRoom);
    World& world = live.world;
    test::expect_as_loaded(live);
    for (int edit = 0; edit < 50; ++edit) {
      EditChange change;
      const Edit made = test::random_voxel_edit(random, world.info().extent, world.octree().depth());
      const std::size_t before = test::heap_calls();
      const Status status = edit_shape(world, made, change);
      EXPECT_EQ(test::heap_calls(), before);
      ASSERT_TRUE(status.ok()) << status.what() << " " << status.field() << " " << status.value();
      changed += change.changed ? 1u : 0u;
      if (change.changed) test::expect_as_loaded(live);
      if (testing::Test::HasFatalFailure()) FAIL() << "round " << round << " edit " << edit;
    }
  }
  EXPECT_GT(changed, 500u);
}

// Between edits and their measures: boxes are exact, errors and reaches no less than what will be measured,
// cones hold all that was and will be. Whatever of it is measured between which edits, and voxels changing
// while the sky is found anew, in the end all is what a file loads.
TEST(EditShape, UntilItIsSettledAllIsOnTheSafeSide) {
  test::Random random{17};
  std::uint32_t waited = 0, sky = 0;
  for (std::uint64_t round = 0; round < 6; ++round) {
    LoadedWorld live(rough_world(round + 40).file(), kRoom);
    World& world = live.world;
    const std::size_t values = level_error_values(world.info().level);
    for (int edit = 0; edit < 25; ++edit) {
      EditChange change;
      const Edit made = test::random_voxel_edit(random, world.info().extent, world.octree().depth());
      ASSERT_TRUE(edit_shape(world, made, nullptr, change).ok());
      // At times until the sky is found, at times a few patches.
      const int most = random.below(3) == 0 ? 600 : random.below(60);
      for (int steps = most; steps > 0 && !world.is_settled(); --steps) {
        Settled done;
        settle_some(world, done);
        sky += done.sky_changed ? 1u : 0u;
      }
      const std::size_t patches = world.surface().patches.size();
      std::vector<std::uint16_t> errors(patches * values);
      std::vector<PatchBounds> bounds(patches);
      std::vector<NormalCone> cones(patches), shading(patches);
      test::measure_all(world, 0, {errors, bounds, cones, shading});
      for (PatchId p = 0; p < patches; ++p) {
        if (world.surface().is_free(p)) continue;
        for (int axis = 0; axis < 3; ++axis) {
          ASSERT_EQ(world.bounds()[p].min[axis], bounds[p].min[axis]);
          ASSERT_EQ(world.bounds()[p].max[axis], bounds[p].max[axis]);
        }
        for (std::size_t n = p * values; n < (p + 1) * values; ++n) {
          ASSERT_GE(world.level_errors().values[n], errors[n]) << "edit " << edit << " patch " << p;
          waited += world.level_errors().values[n] > errors[n] ? 1u : 0u;
        }
        ASSERT_TRUE(world.cones()[p] == cones[p] || world.cones()[p].sine == NormalCone::kNone);
        ASSERT_TRUE(world.shading_cones()[p] == shading[p] ||
                    world.shading_cones()[p].sine == NormalCone::kNone);
      }
      ASSERT_EQ(find_level_error_fault(world.info().level, world.level_errors().values),
                world.level_errors().values.size());
    }
    test::expect_as_loaded(live);
    if (testing::Test::HasFatalFailure()) FAIL() << "round " << round;
  }
  EXPECT_GT(waited, 100u);
  EXPECT_GT(sky, 3u);
}

// The voxels are those whose centres are in the shape, no others.
TEST(EditShape, ShapesAreWhatTheySay) {
  test::Random random{3};
  for (int n = 0; n < 40; ++n) {
    LoadedWorld live(rough_world(1).file(), kRoom);
    World& world = live.world;
    const glm::ivec3 extent = world.info().extent;
    const Edit edit = test::random_voxel_edit(random, extent, world.octree().depth());
    std::vector<bool> before;
    const auto read = [&](std::vector<bool>& out) {
      for (int z = 0; z < extent.z; ++z) {
        for (int y = 0; y < extent.y; ++y) {
          for (int x = 0; x < extent.x; ++x) out.push_back(world.octree().filled({x, y, z}));
        }
      }
    };
    read(before);
    EditChange change;
    ASSERT_TRUE(edit_shape(world, edit, change).ok());
    std::vector<bool> after;
    read(after);
    std::size_t at = 0;
    for (int z = 0; z < extent.z; ++z) {
      for (int y = 0; y < extent.y; ++y) {
        for (int x = 0; x < extent.x; ++x, ++at) {
          const glm::dvec3 c = glm::dvec3(x, y, z) + 0.5;
          bool in = false;
          if (edit.shape == BrushShape::voxel) {
            const double side = std::ldexp(1.0, world.octree().depth() - edit.octree_level);
            in = glm::floor(c / side) == glm::floor(edit.place / side);
          } else if (edit.shape == BrushShape::box) {
            const glm::dvec3 away = glm::abs(c - edit.place);
            in = away.x <= edit.half.x && away.y <= edit.half.y && away.z <= edit.half.z;
          } else {
            const glm::dvec3 way = edit.shape == BrushShape::capsule ? edit.to - edit.place : glm::dvec3(0);
            const double l2 = glm::dot(way, way);
            const double t = l2 > 0 ? glm::clamp(glm::dot(c - edit.place, way) / l2, 0.0, 1.0) : 0.0;
            in = glm::length(c - edit.place - t * way) <= edit.radius;
          }
          const bool fill = edit.tool == EditTool::fill;
          const bool wanted = in && !(fill && y == extent.y - 1) ? fill : before[at];
          ASSERT_EQ(after[at], wanted) << x << " " << y << " " << z << " shape " << int(edit.shape);
        }
      }
    }
  }
}

// What finds no room or is nonsense changes nothing, to the bit.
TEST(EditShape, FailuresChangeNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Edit dig;
  dig.place = {7, 5, 6};
  dig.radius = 4;
  for (const std::uint32_t room : {60u, 200u}) {
    LoadedWorld live(rough_world(2).file(), room);
    const std::vector<std::byte> before = live.save();
    EditChange change;
    const Status status = edit_shape(live.world, dig, change);
    ASSERT_EQ(status.code(), StatusCode::limit_reached);
    EXPECT_STREQ(status.field(), "edit_patches");
    EXPECT_GT(status.value(), room);
    EXPECT_FALSE(change.changed);
    EXPECT_TRUE(live.save() == before);
    test::expect_as_loaded(live);
  }
  LoadedWorld live(rough_world(2).file(), kRoom);
  const std::vector<std::byte> before = live.save();
  const struct {
    const char* field;
    void (*spoil)(Edit& edit, double nan);
  } spoilt[] = {
      {"place", [](Edit& e, double n) { e.place.y = n; }},
      {"place", [](Edit& e, double) { e.place.x = 1e300; }},
      {"to", [](Edit& e, double n) { e.to.x = n; }},
      {"half_m", [](Edit& e, double) { e.half.z = -1; }},
      {"radius_m", [](Edit& e, double n) { e.radius = n; }},
      {"radius_m", [](Edit& e, double) { e.radius = -1; }},
      {"octree_level", [](Edit& e, double) { e.octree_level = 9; }},
      {"shape", [](Edit& e, double) { e.shape = BrushShape::cylinder; }},
      {"shape", [](Edit& e, double) { e.shape = static_cast<BrushShape>(77); }},
      {"tool", [](Edit& e, double) { e.tool = static_cast<EditTool>(77); }},
      {"amount", [](Edit& e, double n) { e.amount = n; }},
  };
  for (const auto& [field, spoil] : spoilt) {
    Edit edit = dig;
    spoil(edit, nan);
    EditChange change;
    const Status status = edit_shape(live.world, edit, change);
    ASSERT_EQ(status.code(), StatusCode::invalid_argument) << field;
    EXPECT_STREQ(status.field(), field);
  }
  EXPECT_TRUE(live.save() == before);
  // Larger than the world: all of it is rock, or all of it air.
  for (const EditTool tool : {EditTool::fill, EditTool::clear}) {
    dig.tool = tool;
    dig.radius = 1e5;
    EditChange change;
    const Status status = edit_shape(live.world, dig, change);
    ASSERT_TRUE(status.ok()) << status.field() << status.value();
    EXPECT_TRUE(change.changed);
    if (tool == EditTool::fill) test::expect_as_loaded(live);
  }
  EXPECT_EQ(live.world.free_patches(), live.world.patch_count());
  // Without room for edits there is none.
  LoadedWorld plain(rough_world(2).file());
  EditChange change;
  EXPECT_STREQ(edit_shape(plain.world, dig, change).field(), "world");
}

// What could not be taken back is not done: what is there before takes room, too.
TEST(EditShape, WhatGoesCountsAsWell) {
  Edit all;
  all.place = {7, 5, 6};
  all.radius = 1e5;
  const LoadedWorld plain(rough_world(2).file());
  const std::uint32_t patches = plain.world.patch_count();
  for (const std::uint32_t room : {patches - 1, patches}) {
    LoadedWorld live(rough_world(2).file(), room);
    const std::vector<std::byte> before = live.save();
    std::vector<std::uint64_t> memory(1 << 17);
    UndoLog log;
    log.create(std::as_writable_bytes(std::span(memory)));
    EditChange change;
    log.begin();
    const Status status = edit_shape(live.world, all, &log, change);
    log.end();
    if (room < patches) {
      ASSERT_EQ(status.code(), StatusCode::limit_reached);
      EXPECT_STREQ(status.field(), "edit_patches");
      EXPECT_EQ(status.value(), patches);
      EXPECT_EQ(log.undo_steps() + log.lost_steps(), 0u);
      EXPECT_TRUE(live.save() == before);
      continue;
    }
    ASSERT_TRUE(status.ok()) << status.field() << status.value();
    EXPECT_EQ(live.world.free_patches(), live.world.patch_count());
    ASSERT_TRUE(log.undo([&](UndoPart part) { undo_shape(live.world, part, change); }));
    EXPECT_EQ(change.touched.size(), patches);
    test::settle(live.world);
    EXPECT_TRUE(live.save() == before);
    test::expect_as_loaded(live);
    ASSERT_TRUE(log.redo([&](UndoPart part) { redo_shape(live.world, part, change); }));
    EXPECT_EQ(live.world.free_patches(), live.world.patch_count());
  }
}

}  // namespace
}  // namespace karst::core
