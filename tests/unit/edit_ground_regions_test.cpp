// SPDX-License-Identifier: MIT
// Heights of a ground with regions are edited beside them, and thresholds go on holding what the regions ask
// for, also where those have grown.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/ground_editor.h"

namespace karst::core {
namespace {

using test::GroundEditor;
using test::MemoryGround;
using test::MemoryRegion;

constexpr std::int64_t kWide = 330, kDeep = 290;
constexpr double kSteps = 4096;  // a node of size 0 is two voxels wide

std::int32_t height_of(std::int64_t i, std::int64_t k) {
  const double x = double(i), z = double(k);
  return static_cast<std::int32_t>(20'000 + 7'000 * std::sin(0.07 * x) * std::cos(0.05 * z) +
                                   900 * std::sin(0.9 * x + 0.4 * z));
}

std::vector<MemoryRegion> regions(double more_error = 0, double more_reach = 0) {
  const double error = 6.0 * kStepsPerVoxel, reach = 30.0 * kStepsPerVoxel;
  return {{21, 17, 20, 13, {error + more_error, reach + more_reach}, 40, 0},
          {13, 15, 50, 40, {error, reach}, 40, 0}};
}

MemoryGround ground(const MemoryGround::Heights& heights, const std::vector<MemoryRegion>& of) {
  return MemoryGround(kWide, kDeep, kSteps, kSteps, heights, of);
}

// What a node of a size, or one of its descendants that its threshold looks at, has of regions.
bool is_near_region(const GroundInfo& info, NodeKey node) {
  for (const GroundRegion& region : info.regions()) {
    const std::int64_t at[2] = {node.x, node.z};
    bool near = true;
    for (int axis = 0; axis < 2; ++axis) {
      near = near && (at[axis] + 2) << node.size >= region.nodes.low[axis] &&
             (at[axis] - 1) << node.size <= region.nodes.high[axis];
    }
    if (near) return true;
  }
  return false;
}

TEST(EditGroundRegions, IsAsAGroundMadeOfTheEditedSamplesBesideThem) {
  const MemoryGround file = ground(height_of, regions());
  GroundEditor edited(file, 400);
  test::Random random{5};
  int refused = 0, changed = 0;
  constexpr EditTool kTools[] = {EditTool::extrude, EditTool::smooth, EditTool::noise, EditTool::level};
  for (int n = 0; n < 300; ++n) {
    Edit edit;
    edit.tool = kTools[random.below(4)];
    edit.shape = BrushShape::cylinder;
    edit.place = {kSteps / kStepsPerVoxel * (random.unit() * kWide - 45), 5,
                  kSteps / kStepsPerVoxel * (random.unit() * kDeep - 30)};
    edit.radius = 1 + 7 * random.unit();
    edit.strength = 2 * random.unit() - 1;
    edit.amount = random.unit();
    GroundChange change;
    const Status status = edited.edits.apply(edit, nullptr, change);
    if (status.ok()) {
      changed += change.changed ? 1 : 0;
      continue;
    }
    ASSERT_EQ(status.code(), StatusCode::limit_reached) << status.what() << status.field();
    EXPECT_STREQ(status.field(), "edit_patches");
    EXPECT_FALSE(change.changed);
    ++refused;
  }
  EXPECT_GT(changed, 150);
  EXPECT_GT(refused, 10);
  // Where regions stand nothing has changed.
  for (const GroundRegion& region : file.info().regions()) {
    const GridRect samples = samples_of(region);
    for (std::int64_t k = samples.low[1]; k <= samples.high[1]; ++k) {
      for (std::int64_t i = samples.low[0]; i <= samples.high[0]; ++i)
        ASSERT_EQ(edited.sample(i, k), height_of(i, k));
    }
  }
  std::vector<std::int32_t> samples;
  for (std::int64_t k = 0; k < kDeep; ++k) {
    for (std::int64_t i = 0; i < kWide; ++i) samples.push_back(edited.sample(i, k));
  }
  const MemoryGround made =
      ground([&](std::int64_t i, std::int64_t k) { return samples[static_cast<std::size_t>(k * kWide + i)]; },
             regions());
  // While nodes wait to be measured, too.
  ASSERT_FALSE(edited.edits.is_settled());
  edited.each_node([&](NodeKey node) {
    const NodeMeasure& other = made.tile(tile_of(node)).nodes[node_in_tile(node)];
    for (int n = 0; n < kDemands; ++n)
      EXPECT_GE(edited.measure(node).thresholds[n], other.thresholds[n])
          << node.size << ' ' << node.x << ' ' << node.z;
  });
  for (GroundChange rest; !edited.edits.is_settled();) edited.edits.settle_some(rest);
  int same = 0, higher = 0;
  edited.each_node([&](NodeKey node) {
    const NodeMeasure& own = edited.measure(node);
    const NodeMeasure& other = made.tile(tile_of(node)).nodes[node_in_tile(node)];
    EXPECT_EQ(own.low, other.low);
    EXPECT_EQ(own.high, other.high);
    for (int n = 0; n < kDemands; ++n) {
      EXPECT_GE(own.thresholds[n], other.thresholds[n]) << node.size << ' ' << node.x << ' ' << node.z;
      if (node.size <= kReferenceSizes && !is_near_region(file.info(), node)) {
        EXPECT_EQ(own.thresholds[n], other.thresholds[n]) << node.size << ' ' << node.x << ' ' << node.z;
        ++same;
      } else {
        higher += own.thresholds[n] > other.thresholds[n] ? 1 : 0;
      }
    }
  });
  std::printf("%d thresholds away from regions are the same, %d others are higher\n", same, higher);
  EXPECT_GT(same, 1'000);
}

// A region grows and shrinks, with edits of heights beside it and beneath it in between: once it is settled
// thresholds of exact sizes are those of a ground that is baked with what the region is now, to the bit,
// coarser ones no less; before that none is less. Where growth is taken back it is the file again.
TEST(EditGroundRegions, ThresholdsFollowARegion) {
  const MemoryGround file = ground(height_of, regions());
  GroundEditor edited(file, 400);
  ASSERT_TRUE(edited.edits.reserve_region(0).ok());
  ASSERT_TRUE(edited.edits.reserve_region(1).ok());
  std::vector<std::uint64_t> memory(1 << 17);
  UndoLog log;
  log.create(std::as_writable_bytes(std::span(memory)));
  const auto settle = [&] {
    for (GroundChange rest; !edited.edits.is_settled();) edited.edits.settle_some(rest);
  };
  std::vector<std::uint16_t> last;
  std::size_t exact = 0, higher = 0;
  for (const int step : {0, 1, 2, 3, 2, 1, 0}) {
    // The other one is known as it is.
    RegionGrowth own, other;
    own.way = other.way = 1;
    own.error = 1;
    own.now = {(6.0 + 3 * step * step) * kStepsPerVoxel, (30.0 + 2 * step) * kStepsPerVoxel};
    other.now = {6.0 * kStepsPerVoxel, 30.0 * kStepsPerVoxel};
    log.begin();
    GroundChange change;
    edited.edits.grow_region(0, own, &log, change);
    edited.edits.grow_region(1, other, nullptr, change);
    log.end();
    if (step == 1) {
      Edit edit;
      edit.tool = EditTool::extrude;
      edit.shape = BrushShape::cylinder;
      edit.place = {18, 5, 27};  // beside the region, and in it
      edit.radius = 3;
      ASSERT_TRUE(edited.edits.apply(edit, nullptr, change, true).ok());
      EXPECT_TRUE(change.changed);
    }
    std::vector<std::int32_t> samples;
    for (std::int64_t k = 0; k < kDeep; ++k) {
      for (std::int64_t i = 0; i < kWide; ++i) samples.push_back(edited.sample(i, k));
    }
    std::vector<MemoryRegion> of = regions();
    of[0].measure = own.now;
    const MemoryGround made = ground(
        [&](std::int64_t i, std::int64_t k) { return samples[static_cast<std::size_t>(k * kWide + i)]; }, of);
    for (const bool settled : {false, true}) {
      if (settled) settle();
      std::vector<std::uint16_t> now;
      edited.each_node([&](NodeKey node) {
        const NodeMeasure& live = edited.measure(node);
        const NodeMeasure& baked = made.tile(tile_of(node)).nodes[node_in_tile(node)];
        for (int n = 0; n < kDemands; ++n) {
          ASSERT_GE(live.thresholds[n], baked.thresholds[n])
              << settled << ' ' << node.size << ' ' << node.x << ' ' << node.z;
          if (settled && node.size <= kReferenceSizes) {
            ASSERT_EQ(live.thresholds[n], baked.thresholds[n]) << node.size << ' ' << node.x << ' ' << node.z;
            ++exact;
          } else {
            higher += live.thresholds[n] > baked.thresholds[n] ? 1 : 0;
          }
          now.push_back(live.thresholds[n]);
        }
      });
      if (HasFatalFailure()) FAIL() << step;
      if (!settled) continue;
      EXPECT_NE(now, last);
      last = now;
    }
    // Nothing more to allow for: nothing changes.
    edited.edits.grow_region(0, own, nullptr, change);
    EXPECT_FALSE(change.changed);
  }
  std::printf("%zu thresholds are those of a baked ground, %zu are higher\n", exact, higher);
  // Before anything grew.
  GroundEditor fresh(file, 400);
  ASSERT_TRUE(fresh.edits.reserve_region(0).ok());
  RegionGrowth grown;
  grown.way = grown.error = 9;
  grown.now = {90.0 * kStepsPerVoxel, 40.0 * kStepsPerVoxel};
  GroundChange change;
  UndoLog steps;
  steps.create(std::as_writable_bytes(std::span(memory)));
  steps.begin();
  fresh.edits.grow_region(0, grown, &steps, change);
  steps.end();
  std::size_t raised = 0;
  const auto count_raised = [&] {
    raised = 0;
    fresh.each_node([&](NodeKey node) {
      if (!(fresh.measure(node) == file.tile(tile_of(node)).nodes[node_in_tile(node)])) ++raised;
    });
  };
  count_raised();
  EXPECT_GT(raised, 10u);
  ASSERT_TRUE(steps.undo([&](UndoPart part) { EXPECT_EQ(fresh.edits.exchange_growth(part), 0u); }));
  RegionGrowth back = fresh.edits.growth(0);
  EXPECT_FALSE(back.exists());
  back.now = {};
  fresh.edits.grow_region(0, back, nullptr, change);
  for (GroundChange rest; !fresh.edits.is_settled();) fresh.edits.settle_some(rest);
  count_raised();
  EXPECT_EQ(raised, 0u);
}

TEST(EditGroundRegions, RoomForThresholdsIsAskedForFirst) {
  const MemoryGround file = ground(height_of, regions());
  GroundEditor edited(file, 3);
  const Status status = edited.edits.reserve_region(1);
  EXPECT_EQ(status.code(), StatusCode::limit_reached);
  EXPECT_STREQ(status.field(), "edit_tiles");
  EXPECT_GT(status.value(), 3u);
  EXPECT_EQ(edited.edits.overlay().tiles().size(), 0u);
}

}  // namespace
}  // namespace karst::core
