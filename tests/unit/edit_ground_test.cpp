// SPDX-License-Identifier: MIT
// Edits of the ground's samples: an edited ground is one that was made from the edited samples, bit by bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "terrain/edit/brush.h"
#include "terrain/edit/ground/edit_ground.h"
#include "terrain/lod/morph.h"
#include "tests/support/edited_ground.h"

namespace karst::core {
namespace {

using Edited = test::EditedGround;
using test::expect_as_made;
using test::MemoryGround;

TEST(EditGround, IsAsAGroundMadeOfTheEditedSamples) {
  for (const auto& [wide, deep] : {std::pair<int, int>{150, 190}, {257, 129}, {300, 280}}) {
    Edited edited(wide, deep, 200);
    std::mt19937 random(static_cast<unsigned>(wide));
    int changed = 0;
    for (int n = 0; n < 300; ++n) {
      GroundChange change;
      const Status status =
          edited.editor.apply(test::random_ground_edit(random, wide, deep), nullptr, change);
      ASSERT_TRUE(status.ok()) << status.what() << " " << status.field();
      changed += change.changed ? 1 : 0;
      if (n % 60 != 59 && n > 2) continue;
      expect_as_made(edited, "after an edit");
      ASSERT_FALSE(HasFailure()) << n;
    }
    EXPECT_GT(changed, 150);
  }
}

// What sizes beyond the exact ones state, all of them but the finest while they wait to be measured, is no
// less than what is there: the samples' deviation from the size's own surface, home, at all samples of a
// node.
class CoarseSizes : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(EditGround, CoarseSizes, testing::Bool());
TEST_P(CoarseSizes, NeverSayLessThanIsThere) {
  Edited edited(300, 280, 200);
  std::mt19937 random(3);
  for (int n = 0; n < 200; ++n) {
    Edit edit = test::random_ground_edit(random, 300, 280);
    edit.strength *= 3;
    GroundChange change;
    ASSERT_TRUE(edited.editor.apply(edit, nullptr, change).ok());
  }
  ASSERT_FALSE(edited.editor.is_settled());
  if (GetParam()) edited.settle();
  const std::vector<std::int32_t> samples = edited.samples();
  const GroundInfo& info = edited.file().info();
  const auto at = [&](std::int64_t i, std::int64_t k) {
    return 2.0 * samples[static_cast<std::size_t>(std::min<std::int64_t>(k, 279) * 300 +
                                                  std::min<std::int64_t>(i, 299))];
  };
  ASSERT_GT(info.top_size(), kReferenceSizes);
  int nodes = 0, raised = 0;
  for (int size = EditGround::kExactAtOnce + 1; size <= info.top_size(); ++size) {
    for (int z = 0; z < nodes_along(info, 1, size); ++z) {
      for (int x = 0; x < nodes_along(info, 0, size); ++x) {
        const NodeKey key{size, x, z};
        const double most = test::most_off_node(key, 300, 280, at);
        const NodeMeasure& own = edited.tile(tile_of(key)).nodes[node_in_tile(key)];
        const NodeMeasure& file = edited.file().tile(tile_of(key)).nodes[node_in_tile(key)];
        ++nodes;
        raised += size > kReferenceSizes && own.thresholds[4] > file.thresholds[4] ? 1 : 0;
        for (int n = 0; n < kDemands; ++n) {
          const double steps =
              double{threshold_steps(own.thresholds[n])} * std::ldexp(1.0, info.page_size(size));
          EXPECT_GE(steps, demand(n) * most) << size << " " << x << " " << z << " " << n;
        }
      }
    }
  }
  EXPECT_GT(nodes, 2);
  EXPECT_GT(raised, 0);
}

// Steps of one edit and of many, close to each other and far apart: also what coarse sizes keep of the file.
TEST(EditGround, StepsAreTakenBackAndAgainToTheBit) {
  Edited edited(300, 280, 128);
  std::vector<std::uint64_t> memory(1 << 20);
  UndoLog log;
  log.create(std::as_writable_bytes(std::span(memory)));
  std::mt19937 random(11);
  std::vector<std::vector<std::byte>> states = {edited.facts()};
  std::uint64_t edits = 0, parts = 0;
  GroundChange change;
  for (int n = 0; n < 40; ++n) {
    bool changed = false;
    Edit edit = test::random_ground_edit(random, 300, 280);
    log.begin();
    const std::uint64_t first = log.part_number();
    for (int dab = n % 2 == 0 ? 0 : n; dab >= 0; --dab) {
      ASSERT_TRUE(edited.editor.apply(edit, &log, change).ok());
      changed = changed || change.changed;
      edits += change.changed;
      // A line of dabs, or here and there.
      if (n % 4 == 1) {
        edit = test::random_ground_edit(random, 300, 280);
      } else {
        edit.place += glm::dvec3(2, 0, 1);
        edit.to += glm::dvec3(2, 0, 1);
      }
    }
    log.end();
    parts += log.part_number() - first;
    if (changed) states.push_back(edited.facts());
  }
  EXPECT_GT(parts, 60u) << "of " << edits;
  EXPECT_LT(parts, edits * 6 / 10) << "of " << edits;
  ASSERT_EQ(log.undo_steps(), states.size() - 1);
  ASSERT_EQ(log.lost_steps(), 0u);
  const auto exchange = [&](UndoPart part) { edited.editor.exchange(part, change); };
  for (int round = 0; round < 2; ++round) {
    for (std::size_t n = states.size() - 1; n > 0; --n) {
      ASSERT_TRUE(log.undo(exchange));
      ASSERT_TRUE(edited.facts() == states[n - 1]) << n;
    }
    EXPECT_EQ(expect_as_made(edited, "after all was taken back"), 0u);
    for (std::size_t n = 1; n < states.size(); ++n) {
      ASSERT_TRUE(log.redo(exchange));
      ASSERT_TRUE(edited.facts() == states[n]) << n;
    }
    expect_as_made(edited, "after all was done again");
  }
}

// Not by what heights there are anywhere under the brush.
TEST(EditGround, AWideBrushMayGoOverMountains) {
  const MemoryGround::Heights slopes = [](std::int64_t i, std::int64_t k) {
    return static_cast<std::int32_t>(40'000 * std::sin(0.02 * static_cast<double>(i)) *
                                     std::cos(0.02 * static_cast<double>(k)));
  };
  Edited edited(300, 280, 200, slopes);
  Edit hill;
  hill.tool = EditTool::extrude;
  hill.shape = BrushShape::cylinder;
  hill.place = {150, 0, 140};
  hill.radius = 130;
  hill.strength = 6;
  GroundChange change;
  const Status status = edited.editor.apply(hill, nullptr, change);
  ASSERT_TRUE(status.ok()) << status.what();
  ASSERT_GT(change.greatest - change.least, 8 * 4096) << "more than a node spans";
  expect_as_made(edited, "after a hill");
  const std::vector<std::int32_t> before = edited.samples();
  // A step of more than a node of size 1 spans, within a node of size 0 it fits.
  hill.tool = EditTool::level;
  hill.shape = BrushShape::box;
  hill.half = {20, 900, 20};
  hill.place = {150, 19, 140};
  EXPECT_FALSE(edited.editor.apply(hill, nullptr, change).ok());
  EXPECT_EQ(edited.samples(), before);
}

TEST(EditGround, ErrorsChangeNothing) {
  Edited edited(150, 129, 9);
  const std::vector<std::int32_t> before = edited.samples();
  std::vector<std::uint64_t> memory(1 << 12);
  UndoLog log;
  log.create(std::as_writable_bytes(std::span(memory)));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Edit good;
  good.tool = EditTool::extrude;
  good.shape = BrushShape::cylinder;
  good.place = {20, 0, 20};
  good.radius = 5;
  const auto refuse = [&](const char* field, const Edit& edit) {
    GroundChange change;
    log.begin();
    const Status status = edited.editor.apply(edit, &log, change);
    EXPECT_EQ(log.open_part(), CellKind::none) << field;
    log.end();
    EXPECT_EQ(log.undo_steps() + log.lost_steps(), 0u) << field;
    EXPECT_FALSE(status.ok()) << field;
    EXPECT_STREQ(status.field(), field);
    EXPECT_FALSE(change.changed);
    EXPECT_EQ(edited.samples(), before) << field;
  };
  const auto with = [&](auto Edit::*member, auto value) {
    Edit edit = good;
    edit.*member = value;
    return edit;
  };
  refuse("tool", with(&Edit::tool, EditTool::paint));
  refuse("shape", with(&Edit::shape, BrushShape::voxel));
  refuse("place", with(&Edit::place, glm::dvec3(nan, 0, 0)));
  refuse("radius_m", with(&Edit::radius, 0.0));
  refuse("radius_m", with(&Edit::radius, nan));
  refuse("strength_m", with(&Edit::strength, nan));
  refuse("strength_m", with(&Edit::strength, 1e6));
  refuse("strength_m", with(&Edit::strength, 200.0));  // too steep
  refuse("amount", with(&Edit::amount, 1.5));
  refuse("hardness", with(&Edit::hardness, -0.1));
  Edit noise = with(&Edit::tool, EditTool::noise);
  noise.wave = 0;
  refuse("wave_m", noise);
  Edit flat = with(&Edit::tool, EditTool::flatten);
  flat.up = {1, 0, 0};
  refuse("up", flat);
  // All of the ground, in a pool that is too small: nothing that was kept is lost for it.
  refuse("edit_tiles", with(&Edit::radius, 1e300));
  GroundChange change;
  const Status status = edited.editor.apply(with(&Edit::radius, 1e300), nullptr, change);
  EXPECT_EQ(status.code(), StatusCode::limit_reached);
  EXPECT_STREQ(status.field(), "edit_tiles");
  EXPECT_GT(status.value(), 9u);
  EXPECT_EQ(edited.samples(), before);
  // Beside the ground nothing happens; what is asked for in the middle does.
  EXPECT_TRUE(edited.editor.apply(with(&Edit::place, glm::dvec3(-900, 0, 0)), nullptr, change).ok());
  EXPECT_FALSE(change.changed);
  EXPECT_TRUE(edited.editor.apply(good, nullptr, change).ok());
  EXPECT_TRUE(change.changed);
}

TEST(EditGround, SimplexNoiseStaysWithinOneAndIsContinuous) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-50, 50);
  double least = 0, most = 0, sum = 0;
  for (int n = 0; n < 200'000; ++n) {
    const glm::dvec3 place(any(random), any(random), any(random));
    const double value = simplex_noise(place, 9);
    least = std::min(least, value);
    most = std::max(most, value);
    sum += value;
    ASSERT_NEAR(simplex_noise(place + glm::dvec3(1e-7, -1e-7, 1e-7), 9), value, 1e-5);
  }
  EXPECT_LT(most, 1.0) << "clamped";
  EXPECT_GT(least, -1.0) << "clamped";
  EXPECT_GT(most, 0.8);
  EXPECT_LT(least, -0.8);
  EXPECT_NEAR(sum / 200'000, 0, 0.01);
}

}  // namespace
}  // namespace karst::core
