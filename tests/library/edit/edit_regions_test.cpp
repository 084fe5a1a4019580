// SPDX-License-Identifier: MIT
// Edits of voxels in regions of a ground: all that follows is what a file of the edited world loads, and the
// rims stay.
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "terrain/edit/regions/region_growth.h"
#include "terrain/edit/undo/take_part.h"
#include "terrain/patch/displacement.h"
#include "tests/library/edit/rough_regions.h"
#include "tests/support/edited_world.h"
#include "tests/support/ground_editor.h"
#include "tests/support/heap_count.h"

namespace karst::core {
namespace {

using test::kRegionError;
using test::LoadedWorld;
using test::MemoryGround;
using test::rough_regions_file;
using test::rough_regions_ground;
using test::rough_regions_height;

constexpr std::uint32_t kRoom = 1'500;

// Somewhere in a region, or at its sides.
Edit random_edit(test::Random& random, const WorldPart& part) {
  Edit edit = test::random_voxel_edit(random, part.extent, part.octree->depth());
  const glm::dvec3 inwards = 0.5 * glm::dvec3(part.extent) - edit.place;
  const glm::dvec3 shift = glm::dvec3(part.corner) + (random.below(4) == 0 ? 0.0 : 0.6) * inwards;
  edit.place += shift;
  edit.to += shift;
  return edit;
}

TEST(EditRegions, HundredsOfEditsAreWhatAFileLoads) {
  for (const std::size_t count : {1u, 3u}) {
    LoadedWorld live(rough_regions_file(count), kRoom);
    World& world = live.world;
    ASSERT_TRUE(world.is_editable());
    ASSERT_EQ(world.parts().size(), count);
    test::expect_as_loaded(live);
    test::Random random{17 + count};
    std::vector<std::uint32_t> changed(count), refused(count);
    for (int n = 0; n < 250; ++n) {
      const std::size_t at = static_cast<std::size_t>(random.below(static_cast<int>(count)));
      EditChange change;
      const std::size_t before = test::heap_calls();
      const Status status = edit_shape(world, random_edit(random, world.parts()[at]), change);
      EXPECT_EQ(test::heap_calls(), before);
      if (!status.ok()) {
        // It reaches the outermost voxels alone.
        ASSERT_STREQ(status.field(), "place") << status.what();
        ++refused[at];
        continue;
      }
      if (!change.changed) continue;
      ++changed[change.part];
      EXPECT_EQ(change.part, at);
      for (const PatchId patch : change.touched) ASSERT_EQ(world.part_number(patch), at);
      for (const PatchId patch : change.vanished) ASSERT_EQ(world.part_number(patch), at);
      test::expect_as_loaded(live);
      if (testing::Test::HasFatalFailure()) FAIL() << count << " regions, edit " << n;
    }
    for (std::size_t n = 0; n < count; ++n) {
      EXPECT_GT(changed[n], 80u / count);
      EXPECT_GT(refused[n], 0u);
    }
  }
}

// Of all regions, in one log.
TEST(EditRegions, EditsAreTakenBackAndDoneAgainToTheBit) {
  LoadedWorld live(rough_regions_file(3), kRoom);
  test::Random random{41};
  std::vector<std::uint64_t> memory(1 << 18);
  UndoLog log;
  log.create(std::as_writable_bytes(std::span(memory)));
  std::vector<std::vector<std::byte>> states = {live.save()};
  std::array<int, 3> changed{};
  while (states.size() < 60) {
    const auto at = static_cast<std::size_t>(random.below(3));
    log.begin();
    EditChange change;
    const Status status = edit_shape(live.world, random_edit(random, live.world.parts()[at]), &log, change);
    log.end();
    if (!status.ok() || !change.changed) continue;
    ++changed[change.part];
    states.push_back(live.save());
  }
  for (const int of_part : changed) EXPECT_GT(of_part, 9);
  ASSERT_EQ(log.lost_steps(), 0u);
  const auto take = [&](bool back) {
    return [&, back](UndoPart part) {
      take_part(live.world, part, back, [&](const EditChange& change) {
        EXPECT_TRUE(change.changed);
        for (const PatchId patch : change.touched) EXPECT_EQ(live.world.part_number(patch), change.part);
      });
    };
  };
  for (std::size_t n = states.size() - 1; n > 0; --n) {
    ASSERT_TRUE(log.undo(take(true)));
    ASSERT_TRUE(live.save() == states[n - 1]) << n;
    if (n % 10 == 0) test::expect_as_loaded(live);
  }
  for (std::size_t n = 1; n < states.size(); ++n) {
    ASSERT_TRUE(log.redo(take(false)));
    ASSERT_TRUE(live.save() == states[n]) << n;
  }
  test::expect_as_loaded(live);
}

// The outermost voxels of a region stay, whatever is larger than it.
TEST(EditRegions, SidesAndTheLowestVoxelsStay) {
  for (const EditTool tool : {EditTool::clear, EditTool::fill}) {
    LoadedWorld live(rough_regions_file(1), 4'000);
    World& world = live.world;
    const WorldPart& part = world.parts()[0];
    std::vector<bool> before;
    const auto each = [&](const auto& visit) {
      for (int z = 0; z < part.extent.z; ++z) {
        for (int y = 0; y < part.extent.y; ++y) {
          for (int x = 0; x < part.extent.x; ++x) visit(glm::ivec3(x, y, z));
        }
      }
    };
    each([&](glm::ivec3 v) { before.push_back(part.octree->filled(v)); });
    Edit all;
    all.tool = tool;
    all.place = glm::dvec3(part.extent) / 2.0;
    all.radius = 1000;
    EditChange change;
    const Status status = edit_shape(world, all, change);
    ASSERT_TRUE(status.ok()) << status.what() << status.value();
    EXPECT_TRUE(change.changed);
    std::size_t at = 0;
    each([&](glm::ivec3 v) {
      const bool side = v.x < kSideVoxels || v.z < kSideVoxels || v.x >= part.extent.x - kSideVoxels ||
                        v.z >= part.extent.z - kSideVoxels;
      const bool end = tool == EditTool::clear ? v.y == 0 : v.y == part.extent.y - 1;
      const bool stays = side || end;
      EXPECT_EQ(part.octree->filled(v), stays ? before[at] : tool == EditTool::fill);
      ++at;
    });
    test::expect_as_loaded(live);
  }
}

TEST(EditRegions, WhatIsBesideThemIsTold) {
  LoadedWorld live(rough_regions_file(2), kRoom);
  World& world = live.world;
  const std::vector<std::byte> before = live.save();
  Edit edit;
  edit.radius = 2;
  const auto refused = [&](glm::dvec3 place, double radius, const char* field) {
    edit.place = place;
    edit.radius = radius;
    EditChange change;
    const Status status = edit_shape(world, edit, change);
    EXPECT_EQ(status.code(), StatusCode::invalid_argument);
    EXPECT_STREQ(status.field(), field) << status.what();
    EXPECT_FALSE(change.changed);
  };
  refused({-20, 8, 5}, 2, "place");
  refused({1, 8, 5}, 1.9, "place");  // the outermost voxels alone
  refused({8, 60, 5}, 2, "place");
  refused({18, 8, 8}, 30, "place");  // both
  edit.octree_level = 9;
  refused({8, 8, 5}, 2, "octree_level");
  EXPECT_TRUE(live.save() == before);
  // Without room there are no edits.
  LoadedWorld plain(rough_regions_file(2));
  EXPECT_FALSE(plain.world.is_editable());
  EXPECT_EQ(plain.world.free_patches(), 0u);
}

// Points of a region's surface, and how far the ground that stands for it is from them: as it is baked.
double measured_error(const LoadedWorld& live, std::size_t n,
                      const std::function<double(double, double)>& height) {
  const WorldPart& part = live.world.parts()[n];
  const int level = live.world.info().level;
  std::vector<glm::dvec3> points;
  std::vector<glm::ivec3> places(static_cast<std::size_t>(patch_vertices(level)));
  double most = 0;
  for (PatchId p = 0; p < part.patches(); ++p) {
    if (part.surface.is_free(p)) continue;
    displaced_positions(part.surface, live.world.heights(), level, p, places);
    const glm::dvec3 at = glm::dvec3(patch_origin(part.surface.volume_of(p)));
    for (const glm::ivec3 place : places) {
      points.push_back((at + glm::dvec3(place)) / double{kStepsPerVoxel});
      most = std::max(most, points.back().y - height(points.back().x, points.back().z));
    }
  }
  for (double z = 0.5; z <= part.extent.z - 0.5; z += 0.5) {
    for (double x = 0.5; x <= part.extent.x - 0.5; x += 0.5) {
      const glm::dvec3 from(x, height(x, z), z);
      double nearest = 1e9;
      for (const glm::dvec3& point : points) nearest = std::min(nearest, glm::length(point - from));
      most = std::max(most, nearest);
    }
  }
  return most * kStepsPerVoxel;
}

// Of the ground as it is edited, voxels, as nodes of size 0 have it; the first region begins at node (9, 7).
double edited_height(test::GroundEditor& edited, double x, double z) {
  const double fx = 2 * (x - 0.5) + 4 * 9, fz = 2 * (z - 0.5) + 4 * 7;
  const auto i = static_cast<std::int64_t>(fx), k = static_cast<std::int64_t>(fz);
  const double u = fx - static_cast<double>(i), v = fz - static_cast<double>(k);
  const auto h = [&](int a, int b) {
    return double{kVertexStep} * edited.sample(i + a, k + b) / kStepsPerVoxel;
  };
  if ((i + k) % 2 == 0) {
    return u > v ? h(0, 0) + u * (h(1, 0) - h(0, 0)) + v * (h(1, 1) - h(1, 0))
                 : h(0, 0) + v * (h(0, 1) - h(0, 0)) + u * (h(1, 1) - h(0, 1));
  }
  return u + v < 1 ? h(0, 0) + u * (h(1, 0) - h(0, 0)) + v * (h(0, 1) - h(0, 0))
                   : h(1, 1) + (1 - u) * (h(0, 1) - h(1, 1)) + (1 - v) * (h(1, 0) - h(1, 1));
}

// What thresholds allow for is no less than how far the region is from the ground after each edit, of voxels
// and of heights in it and beneath it; nor is what follows from the columns alone.
TEST(EditRegions, GrowthIsNoLessThanIsMeasured) {
  const MemoryGround ground = rough_regions_ground(3);
  LoadedWorld live(rough_regions_file(3), kRoom);
  test::GroundEditor edited(ground, 200);
  test::Random random{77};
  double tightest = 0, closest = 0, grown = 0, measured = 0;
  int count = 0;
  for (int n = 0; n < 120; ++n) {
    const auto at = static_cast<std::size_t>(random.below(3));
    const WorldPart& part = live.world.parts()[at];
    Edit edit = random_edit(random, part);
    if (n % 2 == 0) edit.tool = EditTool::clear;
    edit.radius *= 1.5;
    ASSERT_TRUE(edited.edits.reserve_region(at).ok());
    EditChange change;
    LatticeBox box{};
    if (n % 4 < 3) {
      if (!edit_shape(live.world, edit, change).ok() || !change.changed) continue;
      box = change.box;
    } else {
      edit = test::random_heights_edit(random, part.extent);
      edit.place += glm::dvec3(part.corner);
      edit.shape = BrushShape::cylinder;
      edit.tool = n % 8 < 4 ? EditTool::extrude : EditTool::noise;
      edit.radius = 2 + 3 * random.unit();
      edit.strength *= 3;
      GroundChange below;
      // Nothing is beneath the others.
      if (!edited.edits.apply(edit, nullptr, below, true).ok() || !below.changed) continue;
      ASSERT_TRUE(edit_heights(live.world, at, edit, nullptr, change).ok());
      box = change.box;
      const auto wide = glm::ivec3(kStepsPerVoxel * 6, 0, kStepsPerVoxel * 6);
      const auto middle = glm::ivec3((edit.place - glm::dvec3(part.corner)) * double{kStepsPerVoxel});
      if (!change.changed) box = {middle, middle};
      join(box, {glm::ivec3(middle.x, 0, middle.z) - wide, glm::ivec3(middle.x, 0, middle.z) + wide});
    }
    const FindRegionGrowth find{&live.world, &edited.edits, at, box};
    const RegionGrowth growth = find.run();
    EXPECT_GE(growth.error, edited.edits.growth(at).error);
    GroundChange raised;
    edited.edits.grow_region(at, growth, nullptr, raised);
    const double is = measured_error(live, at, [&](double x, double z) {
      return edited_height(edited, x + part.corner.x, z + part.corner.z) - part.corner.y;
    });
    ASSERT_LE(is, kRegionError + growth.error + 0.3 * kStepsPerVoxel) << n;
    ColumnsOfRegion columns;
    while (!find.step(columns)) {
    }
    const RegionMeasure now = find.run(columns).now;
    ASSERT_LE(is, now.error + 0.3 * kStepsPerVoxel) << n;
    ASSERT_LE(now.error, growth.now.error);
    tightest = std::max(tightest, is / (kRegionError + growth.error));
    closest = std::max(closest, is / now.error);
    grown = std::max(grown, growth.error), measured = std::max(measured, is);
    ++count;
  }
  std::printf(
      "%d edits: a region is %.2f of what is allowed for off at most, %.2f of what its columns say; "
      "%.2f voxels; grown by %.2f\n",
      count, tightest, closest, measured / kStepsPerVoxel, grown / kStepsPerVoxel);
  EXPECT_GT(count, 50);
  EXPECT_GT(measured, kRegionError);
}

}  // namespace
}  // namespace karst::core
