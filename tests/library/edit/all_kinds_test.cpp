// SPDX-License-Identifier: MIT
// Random edits of all kinds in one world, through the public headers: voxels and heights of regions, heights
// of the ground around them, paint over both; strokes, undo and redo. The world is always, to the bit, what
// it was at that step, and what its file loads. KARST_EDITS: how many; default 120.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "tests/library/colours.h"
#include "tests/library/edit/live_world.h"
#include "tests/library/edit/rough_regions.h"
#include "tests/library/edit/saved_ground.h"
#include "tests/library/host.h"
#include "tests/support/edited_world.h"
#include "tests/support/heap_count.h"
#include "tests/support/live_mesh.h"

#include "scene/world/world_object.h"

namespace karst {
namespace {

using test::Random;

constexpr std::size_t kRegions = 2;

int edits_asked() {
  const char* const text = std::getenv("KARST_EDITS");
  return text != nullptr ? std::atoi(text) : 120;
}

std::vector<std::byte> world_file() {
  const core::MaterialSet set = test::three_colours();
  const std::vector<std::byte> textures = test::textures_of(set);
  return test::rough_regions_file(kRegions, core::WorldMaterials{set, textures});
}

Needs needs() {
  Needs needs;
  needs.queries = 1;
  needs.edit_patches = 1'500;
  needs.edit_tiles = 200;
  needs.undo_bytes = 1 << 20;
  needs.paint_width = 96;
  needs.paint_depth = 80;
  needs.shadow_maps = 0;
  return needs;
}

// An edit of the core as the public headers say it.
Edit told(const core::WorldObject& world, const core::Edit& edit) {
  const core::PlacementFrame& placement = world.placement;
  const double voxel_m = placement.world().voxel_size_m;
  Edit out;
  out.tool = static_cast<EditTool>(edit.tool);
  out.shape = static_cast<BrushShape>(edit.shape);
  out.octree_level = edit.octree_level;
  out.material = edit.material;
  out.place = placement.place_of_voxels(edit.place);
  out.to = placement.place_of_voxels(edit.to);
  out.half_m = {edit.half.x * voxel_m, edit.half.y * voxel_m, edit.half.z * voxel_m};
  out.up = {edit.up.x, edit.up.y, edit.up.z};
  out.radius_m = edit.radius * voxel_m;
  out.strength_m = edit.strength * voxel_m;
  out.amount = edit.amount;
  out.hardness = edit.hardness;
  out.wave_m = edit.wave * voxel_m;
  out.seed = edit.seed;
  return out;
}

enum Kind : std::size_t { kVoxels, kRegionHeights, kGround, kPaint, kKinds };
constexpr const char* kKindNames[] = {"voxels", "heights of regions", "heights of the ground", "paint"};

class Play {
 public:
  explicit Play(std::uint64_t seed) : file_(world_file()), live_(needs(), file_), random_{seed} {
    states_ = {live_.state()};
  }

  void run(int edits) {
    for (int round = 0; edits_ < edits; ++round) {
      // In turns more is done, and more taken back.
      const bool back = round / 40 % 2 == 1;
      const int what = random_.below(20);
      if (what < (back ? 4 : 12)) {
        step(random_.below(5) == 0 ? 2 + random_.below(5) : 1);
      } else {
        take(what < (back ? 14 : 15));
      }
      for (std::size_t n = 0; n < kRegions && round % 10 == 0; ++n)
        ASSERT_EQ(test::open_edges(live_.world(), n), 0u);
      if (round % 60 == 0) look_deeply();
      if (testing::Test::HasFailure()) FAIL() << "round " << round;
    }
    while (live_.editor->undo_state().undo_steps > 0 && !testing::Test::HasFailure()) take(true);
    look_deeply();
    while (live_.editor->undo_state().redo_steps > 0 && !testing::Test::HasFailure()) take(false);
    look_deeply();
    for (std::size_t kind = 0; kind < kKinds; ++kind)
      std::printf("%s: %d edits changed something, %d were refused\n", kKindNames[kind], changed[kind],
                  refused[kind]);
    std::printf("%d edits; %d steps taken back, %d done again, %llu forgotten\n", edits_, undone, redone,
                static_cast<unsigned long long>(live_.editor->undo_state().lost_steps));
  }

  int changed[kKinds] = {}, refused[kKinds] = {};
  int undone = 0, redone = 0;

 private:
  core::Edit random_edit(Kind& kind) {
    kind = static_cast<Kind>(std::min(random_.below(10) * 2 / 5, 3));
    const core::WorldPart& part =
        live_.world().parts()[static_cast<std::size_t>(random_.below(static_cast<int>(kRegions)))];
    if (kind == kVoxels || kind == kRegionHeights) {
      core::Edit edit = kind == kVoxels ? test::random_voxel_edit(random_, part.extent, part.octree->depth())
                                        : test::random_heights_edit(random_, part.extent);
      const glm::dvec3 inwards = 0.5 * glm::dvec3(part.extent) - edit.place;
      const glm::dvec3 shift = glm::dvec3(part.corner) + (random_.below(4) == 0 ? 0.0 : 0.6) * inwards;
      edit.place += shift;
      edit.to += shift;
      return edit;
    }
    // Anywhere: also over regions.
    const core::GroundInfo& info = live_.world().ground();
    core::Edit edit = test::random_heights_edit(random_, glm::ivec3(1));
    const double size[2] = {double(info.samples[0] - 1) * info.steps[0] / core::kStepsPerVoxel,
                            double(info.samples[1] - 1) * info.steps[1] / core::kStepsPerVoxel};
    const double low[2] = {double(info.corner[0]) * core::kVertexStep / core::kStepsPerVoxel,
                           double(info.corner[1]) * core::kVertexStep / core::kStepsPerVoxel};
    edit.place = {low[0] + size[0] * random_.unit(), 8 + 6 * random_.unit(),
                  low[1] + size[1] * random_.unit()};
    edit.to = edit.place + 12.0 * (glm::dvec3(random_.unit(), random_.unit(), random_.unit()) - 0.5);
    edit.half = glm::dvec3(random_.unit(), 1, random_.unit()) * 5.0 + 0.1;
    edit.radius = 0.5 + 5 * random_.unit();
    if (kind == kPaint) {
      edit.tool = core::EditTool::paint;
      edit.material = random_.below(4) == 0 ? kNoMaterial : static_cast<std::uint8_t>(random_.below(3));
    }
    return edit;
  }

  void step(int edits) {
    const UndoState before = live_.editor->undo_state();
    bool any = false;
    live_.editor->begin_stroke();
    for (int n = 0; n < edits; ++n) {
      Kind kind = kVoxels;
      const Edit edit = told(live_.object(), random_edit(kind));
      EditResult result;
      const std::uint64_t calls = test::heap_calls();
      const Status status = live_.editor->apply(edit, result);
      ASSERT_EQ(test::heap_calls(), calls);
      ASSERT_TRUE(status.ok() || !result.changed);
      ++edits_;
      changed[kind] += result.changed;
      refused[kind] += !status.ok();
      any = any || result.changed;
    }
    live_.editor->end_stroke();
    const UndoState after = live_.editor->undo_state();
    if (!any) {
      ASSERT_EQ(after.undo_steps, before.undo_steps);
      ASSERT_EQ(after.redo_steps, before.redo_steps);
      if (random_.below(4) == 0) {
        ASSERT_EQ(live_.state(), states_[now_]);
      }
      return;
    }
    ASSERT_EQ(after.redo_steps, 0u);
    states_.resize(now_ + 1);
    if (after.undo_steps == 0) {
      // Too large to be taken back.
      states_.clear();
      now_ = 0;
    } else {
      ++now_;
    }
    states_.push_back(live_.state());
  }

  void take(bool back) {
    const UndoState before = live_.editor->undo_state();
    const bool can = (back ? before.undo_steps : before.redo_steps) > 0;
    EditResult result;
    const std::uint64_t calls = test::heap_calls();
    const Status status = back ? live_.editor->undo(result) : live_.editor->redo(result);
    ASSERT_EQ(test::heap_calls(), calls);
    ASSERT_TRUE(status.ok()) << status.what() << " " << status.field();
    if (!can) {
      ASSERT_FALSE(result.changed);
      return;
    }
    now_ = back ? now_ - 1 : now_ + 1;
    ++(back ? undone : redone);
    // Not always, so that steps meet what others left for later.
    if (random_.below(2) == 0) {
      ASSERT_EQ(live_.state(), states_[now_]);
    }
  }

  // Saved, loaded, and measured from scratch.
  void look_deeply() {
    const std::vector<std::byte> saved = live_.saved();
    test::expect_live_tiles(live_.object(), saved, file_);
    test::LiveWorld fresh(needs(), saved);
    ASSERT_EQ(fresh.state(), live_.state());
    ASSERT_TRUE(test::measured_facts_of(fresh.world()) == test::facts_of(fresh.world()));
    for (std::size_t n = 0; n < kRegions; ++n) {
      test::expect_same_part(live_.world().parts()[n], fresh.world().parts()[n]);
      if (testing::Test::HasFatalFailure()) return;
    }
    ASSERT_TRUE(fresh.saved() == saved);
  }

  std::vector<std::byte> file_;
  test::LiveWorld live_;
  Random random_;
  std::vector<std::uint64_t> states_;  // of steps, the oldest first
  std::size_t now_ = 0;
  int edits_ = 0;
};

TEST(AllKindsOfEdits, AreWhatTheyWereAtEachStep) {
  Play play(31);
  const int edits = edits_asked();
  play.run(edits);
  EXPECT_GT(play.changed[kVoxels], edits / 12);
  EXPECT_GT(play.changed[kRegionHeights], edits / 30);
  EXPECT_GT(play.changed[kGround], edits / 30);
  EXPECT_GT(play.changed[kPaint], edits / 15);
  EXPECT_GT(play.undone, edits / 5);
  EXPECT_GT(play.redone, edits / 10);
}

}  // namespace
}  // namespace karst
