// SPDX-License-Identifier: MIT
// Editor::start(): a hole where there is only ground, begun in one call and done in parts. Until the last of
// them nothing has changed, and then the world is what one call would have made of it.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/library/colours.h"
#include "tests/library/edit/live_world.h"
#include "tests/library/ground/ground_to_dig.h"
#include "tests/library/host.h"
#include "tests/support/heap_count.h"

#include "scene/world/world_object.h"

namespace karst {
namespace {

using test::apply;
using test::ball;
using test::file_to_dig;
using test::height;
using test::LiveWorld;
using test::needs_to_dig;

EditResult start(LiveWorld& live, const Edit& edit) {
  EditResult result;
  const Status status = live.editor->start(edit, result);
  EXPECT_TRUE(status.ok()) << status.what() << " " << status.field() << " " << status.value();
  return result;
}

// Until it is there; how many calls that takes. told: what the last one said.
int advance(LiveWorld& live, EditResult& told, int most = 1'000'000) {
  told = {};
  int calls = 0;
  for (; calls < most && live.editor->is_pending(); ++calls) live.editor->advance(told);
  return calls;
}

void expect_same(const EditResult& a, const EditResult& b) {
  EXPECT_EQ(a.changed, b.changed);
  for (const auto& [one, other] : {std::pair{a.low, b.low}, {a.high, b.high}}) {
    EXPECT_EQ(one.x, other.x);
    EXPECT_EQ(one.y, other.y);
    EXPECT_EQ(one.z, other.z);
  }
  EXPECT_EQ(a.patches, b.patches);
  EXPECT_EQ(a.nodes, b.nodes);
  EXPECT_EQ(a.version, b.version);
  EXPECT_EQ(a.can_undo, b.can_undo);
  EXPECT_EQ(a.pending, b.pending);
}

// Elevation of what a ray from above meets, metres over the ground's corner.
double ground_at(LiveWorld& live, Query& query, double x, double z) {
  const World& world = *live.host.world;
  const Vec3 origin = world.info().origin_m;
  const auto at = [&](double y) {
    return world.from_world({origin.x + 0.5 + x, origin.y + y, origin.z + 0.5 + z});
  };
  Hit hit;
  EXPECT_TRUE(query.ray(at(100), at(-50), Wait::for_file, hit));
  return world.to_world(hit.place).y - origin.y;
}

// Whatever is done between its parts, the world is what one call makes of it, and told alike.
TEST(PendingDig, IsWhatOneCallMakes) {
  const std::vector<std::byte> file = file_to_dig();
  LiveWorld whole(needs_to_dig(), file);
  const Edit hole = ball(*whole.host.world, 60, 60, 5, 1);
  const EditResult made = apply(whole, hole);
  EXPECT_FALSE(made.pending);
  EXPECT_FALSE(whole.editor->is_pending());
  const std::uint64_t state = whole.state();
  const std::vector<std::byte> saved = whole.saved();
  EXPECT_FALSE(saved == file);
  int most_calls = 0;
  for (int way = 0; way < 3; ++way) {
    LiveWorld live(needs_to_dig(), file);
    const std::uint64_t calls = test::heap_calls();
    const EditResult begun = start(live, hole);
    EXPECT_TRUE(begun.pending);
    EXPECT_FALSE(begun.changed);
    EXPECT_EQ(begun.version, 0u);
    EXPECT_TRUE(live.editor->is_pending());
    EditResult told;
    int parts = 0;
    for (; live.editor->is_pending(); ++parts) {
      // As frames do between.
      if (way == 1) live.object().editor.settle(0.2);
      if (way == 2 && parts % 3 == 1) live.settle();
      EXPECT_FALSE(told.changed);
      EXPECT_EQ(live.world().ground().region_count, 0);
      EXPECT_EQ(live.editor->undo_state().undo_steps, 0u);
      live.editor->advance(told);
    }
    EXPECT_EQ(test::heap_calls(), calls);
    expect_same(told, made);
    EXPECT_EQ(live.editor->undo_state().undo_steps, 1u);
    EXPECT_EQ(live.state(), state);
    EXPECT_TRUE(live.saved() == saved);
    most_calls = std::max(most_calls, parts);
    live.editor->advance(told);
    EXPECT_FALSE(told.changed);
    // And back, as the other one.
    EditResult back, other;
    ASSERT_TRUE(live.editor->undo(back).ok());
    if (way > 0) continue;
    ASSERT_TRUE(whole.editor->undo(other).ok());
    expect_same(back, other);
    EXPECT_EQ(live.state(), whole.state());
    ASSERT_TRUE(whole.editor->redo(other).ok());
  }
  EXPECT_GE(most_calls, 6);
}

// No part does more than it may, counted in patches.
TEST(PendingDig, PartsAreCounted) {
  using core::MakeRegion;
  Needs needs = needs_to_dig();
  needs.region_patches = 4'000;
  LiveWorld live(needs, file_to_dig());
  start(live, ball(*live.host.world, 60, 60, 8, 2));
  const MakeRegion& make = live.object().editor.dig.make;
  const auto of_patch = static_cast<std::uint32_t>(core::patch_vertices(live.world().info().level));
  ASSERT_GT(make.patches, 2 * MakeRegion::kFitted / of_patch);
  EXPECT_EQ(make.fitted, 0u);
  std::uint32_t parts = 0, loose_parts = 0;
  for (EditResult told; live.editor->is_pending(); ++parts) {
    const std::uint32_t fitted = make.fitted, measured = make.measured;
    const bool staged = live.world().is_staged(0);
    const std::uint32_t loose = staged ? live.world().edit(0).queue->loose() : 0;
    loose_parts += loose > 0;
    live.editor->advance(told);
    if (loose > 0) {
      EXPECT_LE(loose - live.world().edit(0).queue->loose(), core::PendingDig::kFitted);
    }
    EXPECT_LE((make.fitted - fitted) * of_patch, MakeRegion::kFitted);
    EXPECT_LE((make.measured - measured) * of_patch, MakeRegion::kBounded);
    EXPECT_TRUE(make.fitted == fitted || make.measured == measured);
  }
  EXPECT_EQ(make.fitted, make.patches);
  EXPECT_EQ(make.measured, make.patches);
  const auto calls = [&](std::uint32_t vertices) {
    return (make.patches + vertices / of_patch - 1) / (vertices / of_patch);
  };
  // Boxes, the hole, its boxes, and to show it.
  EXPECT_GE(loose_parts, 2u);
  EXPECT_EQ(parts, calls(MakeRegion::kFitted) + calls(MakeRegion::kBounded) + 3 + loose_parts);
}

// Errors come in the first call, which then has changed nothing.
TEST(PendingDig, RefusesAtOnce) {
  const std::vector<std::byte> file = file_to_dig();
  const auto refused = [&](LiveWorld& live, const Edit& edit, const char* field) {
    EditResult result;
    const std::uint64_t before = live.state();
    EXPECT_STREQ(live.editor->start(edit, result).field(), field);
    EXPECT_FALSE(result.changed);
    EXPECT_FALSE(result.pending);
    EXPECT_FALSE(live.editor->is_pending());
    EXPECT_EQ(live.editor->undo_state().undo_steps, 0u);
    EXPECT_EQ(live.state(), before);
    const core::World& world = live.world();
    EXPECT_FALSE(world.is_staged(world.ground().regions().size()));
    EXPECT_EQ(live.object().ground_edits->info().region_count, world.ground().region_count);
  };
  LiveWorld live(needs_to_dig(), file);
  const World& world = *live.host.world;
  refused(live, ball(world, 5, 60, 3), "place");
  refused(live, ball(world, 75, 60, 40), "region_patches");
  Edit voxel = ball(world, 75, 60, 3);
  voxel.shape = BrushShape::voxel;
  refused(live, voxel, "place");  // 512 voxels wide
  voxel.octree_level = 10;
  refused(live, voxel, "octree_level");
  EditResult result;
  EXPECT_TRUE(live.editor->start(ball(world, 75, 60, 3, -30), result).ok());
  EXPECT_FALSE(result.pending || result.changed);
  Needs few = needs_to_dig();
  few.edit_tiles = 2;
  LiveWorld tight(few, file);
  refused(tight, ball(*tight.host.world, 75, 60, 3), "edit_tiles");
  few = needs_to_dig();
  few.edit_patches = 8;
  LiveWorld small(few, file);
  refused(small, ball(*small.host.world, 75, 60, 3), "edit_patches");
  few = needs_to_dig();
  few.region_patches = 450;
  LiveWorld narrow(few, file);
  refused(narrow, ball(*narrow.host.world, 75, 60, 5), "region_patches");
  EXPECT_TRUE(live.saved() == file);
  EXPECT_TRUE(tight.saved() == file);
  EXPECT_TRUE(small.saved() == file);
  EXPECT_TRUE(narrow.saved() == file);
  // There is room for it all the same.
  EXPECT_TRUE(start(live, ball(world, 75, 60, 3)).pending);
  EXPECT_GT(advance(live, result), 4);
  EXPECT_TRUE(result.changed);
}

// Queries see nothing of it, and then all.
TEST(PendingDig, QueriesSeeAllOrNothing) {
  LiveWorld live(needs_to_dig(), file_to_dig());
  const World& world = *live.host.world;
  Query* query = nullptr;
  ASSERT_TRUE(live.host.world->take_query(query).ok());
  const double before = ground_at(live, *query, 60, 60), beside = ground_at(live, *query, 57, 61);
  start(live, ball(world, 60, 60, 4));
  EditResult told;
  while (live.editor->is_pending()) {
    EXPECT_EQ(ground_at(live, *query, 60, 60), before);
    EXPECT_EQ(ground_at(live, *query, 57, 61), beside);
    EXPECT_TRUE(
        query->inside(world.from_world({world.info().origin_m.x + 60.5, world.info().origin_m.y + before - 1,
                                        world.info().origin_m.z + 60.5}),
                      Wait::for_file));
    live.editor->advance(told);
  }
  EXPECT_LT(ground_at(live, *query, 60, 60), height(60, 60) - 3);
  EXPECT_LT(ground_at(live, *query, 57, 61), beside - 1);
  live.host.world->release(query);
}

// What else is done meanwhile comes after it.
TEST(PendingDig, OtherCallsComeAfterIt) {
  const std::vector<std::byte> file = file_to_dig();
  const auto hole = [](const LiveWorld& live) { return ball(*live.host.world, 60, 60, 4, 1); };
  LiveWorld whole(needs_to_dig(), file);
  const EditResult dug = apply(whole, hole(whole));
  for (const int parts : {0, 2, 4}) {
    EditResult told;
    {
      LiveWorld live(needs_to_dig(), file);
      start(live, hole(live));
      advance(live, told, parts);
      EXPECT_TRUE(live.saved() == whole.saved());
      EXPECT_TRUE(live.editor->is_pending());
      EXPECT_EQ(advance(live, told), 1);
      expect_same(told, dug);
    }
    {
      LiveWorld live(needs_to_dig(), file), other(needs_to_dig(), file);
      start(live, hole(live));
      advance(live, told, parts);
      EditResult back;
      ASSERT_TRUE(live.editor->undo(back).ok());
      EXPECT_TRUE(back.changed);
      EXPECT_EQ(live.editor->undo_state().redo_steps, 1u);
      EXPECT_EQ(advance(live, told), 1);
      expect_same(told, dug);
      apply(other, hole(other));
      ASSERT_TRUE(other.editor->undo(back).ok());
      EXPECT_EQ(live.state(), other.state());
    }
    {
      // Edits of all kinds, one of which makes a region, too.
      LiveWorld live(needs_to_dig(), file), other(needs_to_dig(), file);
      std::vector<Edit> edits;
      edits.push_back(hole(live));
      edits.push_back(ball(*live.host.world, 62, 60, 2, 4));
      edits.push_back(ball(*live.host.world, 100, 70, 3, 1));
      edits.push_back(ball(*live.host.world, 80, 66, 9));
      edits.back().tool = EditTool::extrude;
      edits.push_back(ball(*live.host.world, 30, 95, 3, 1));
      edits.push_back(ball(*live.host.world, 32, 95, 1, 3));
      edits.back().tool = EditTool::fill;
      for (std::size_t n = 0; n < edits.size(); ++n) {
        // As strokes of two.
        for (LiveWorld* const one : {&live, &other}) {
          if (n % 2 == 0) one->editor->begin_stroke();
        }
        apply(other, edits[n]);
        start(live, edits[n]);
        advance(live, told, parts);
        for (LiveWorld* const one : {&live, &other}) {
          if (n % 2 == 1) one->editor->end_stroke();
        }
      }
      advance(live, told);
      EXPECT_EQ(live.editor->undo_state().undo_steps, 3u);
      EXPECT_EQ(other.editor->undo_state().undo_steps, 3u);
      EXPECT_EQ(live.state(), other.state());
      for (EditResult back; live.editor->undo_state().undo_steps > 0;) {
        ASSERT_TRUE(live.editor->undo(back).ok());
        ASSERT_TRUE(other.editor->undo(back).ok());
        ASSERT_EQ(live.state(), other.state());
      }
    }
  }
}

// A stroke that ends before its last edit is there has it.
TEST(PendingDig, IsOfItsStroke) {
  LiveWorld live(needs_to_dig(), file_to_dig());
  Edit rise = ball(*live.host.world, 100, 90, 5);
  rise.tool = EditTool::extrude;
  live.editor->begin_stroke();
  apply(live, rise);
  start(live, ball(*live.host.world, 60, 60, 3));
  live.editor->end_stroke();
  EXPECT_EQ(live.editor->undo_state().undo_steps, 0u);
  EditResult told;
  advance(live, told);
  EXPECT_TRUE(told.changed);
  EXPECT_EQ(live.editor->undo_state().undo_steps, 1u);
  ASSERT_TRUE(live.editor->undo(told).ok());
  EXPECT_EQ(live.editor->undo_state().undo_steps, 0u);
  EXPECT_EQ(live.editor->undo_state().redo_steps, 1u);
  // And one that begins meanwhile does not.
  start(live, ball(*live.host.world, 110, 60, 3));
  live.editor->begin_stroke();
  apply(live, rise);
  live.editor->end_stroke();
  EXPECT_EQ(live.editor->undo_state().undo_steps, 2u);
}

// A large hole in a region is there at once; boxes of its patches, and what follows from them, come in parts.
// In the end all is what one call makes of it, whatever was done between.
TEST(PendingDig, LargeHolesInRegions) {
  Needs needs = needs_to_dig();
  needs.region_patches = 4'000;
  needs.edit_patches = 4'000;
  const std::vector<std::byte> file = file_to_dig();
  const auto prepare = [&](LiveWorld& live) { apply(live, ball(*live.host.world, 60, 60, 9, -6)); };
  LiveWorld whole(needs, file);
  const Edit hole = ball(*whole.host.world, 60, 60, 8, 3);
  prepare(whole);
  EXPECT_EQ(whole.world().ground().region_count, 1);
  const EditResult made = apply(whole, hole);
  ASSERT_GT(made.patches, 2 * core::PendingDig::kExact);
  const std::uint64_t state = whole.state();
  for (int way = 0; way < 3; ++way) {
    LiveWorld live(needs, file);
    Query* query = nullptr;
    ASSERT_TRUE(live.host.world->take_query(query).ok());
    prepare(live);
    if (way == 2) live.settle();
    const EditResult begun = start(live, hole);
    EXPECT_TRUE(begun.changed && begun.pending);
    EXPECT_LE(begun.low.y, made.low.y);
    EXPECT_GE(begun.high.y, made.high.y);
    EXPECT_EQ(begun.patches, made.patches);
    const core::MeasureQueue& queue = *live.world().edit(0).queue;
    EXPECT_GT(queue.loose(), 100u);
    // Boxes hold the exact ones, and errors are no less: so says what measures from scratch.
    EXPECT_LT(ground_at(live, *query, 60, 60), height(60, 60) - 8);
    EditResult told;
    for (int parts = 0; live.editor->is_pending(); ++parts) {
      const std::uint32_t loose = queue.loose();
      if (way == 1) live.settle();
      EXPECT_EQ(queue.loose(), loose);  // not by frames
      EXPECT_EQ(live.editor->undo_state().undo_steps, 1u);
      live.editor->advance(told);
      EXPECT_FALSE(told.changed);
      ASSERT_LT(parts, 100);
    }
    EXPECT_EQ(queue.loose(), 0u);
    EXPECT_EQ(live.editor->undo_state().undo_steps, 2u);
    EXPECT_EQ(live.state(), state);
    EditResult back, other;
    ASSERT_TRUE(live.editor->undo(back).ok());
    if (way == 0) {
      ASSERT_TRUE(whole.editor->undo(other).ok());
      EXPECT_EQ(live.state(), whole.state());
      ASSERT_TRUE(whole.editor->redo(other).ok());
    }
    // And what comes meanwhile comes after it.
    start(live, hole);
    EXPECT_GT(queue.loose(), 100u);
    ASSERT_TRUE(live.editor->undo(back).ok());
    EXPECT_EQ(queue.loose(), 0u);
    start(live, hole);
    EXPECT_TRUE(live.saved() == whole.saved());
    EXPECT_EQ(live.state(), state);
    live.host.world->release(query);
  }
}

class PendingDigPictures : public test::HostTest {
 protected:
  PendingDigPictures() : HostTest(160, 120) {}
};

// In frames with a limit of time no pixel looks through while it is pending and while its vertices are made,
// of which no frame makes more than it may; then it is seen.
TEST_F(PendingDigPictures, AreClosedInEachFrame) {
  const core::MaterialSet set = test::three_colours();
  const std::vector<std::byte> textures = test::textures_of(set);
  Needs needs = needs_to_dig();
  needs.region_patches = 4'000;
  needs.edit_patches = 4'000;
  open(needs, {.axes = Axes::east_up_south}, {}, file_to_dig(core::WorldMaterials{set, textures}));
  World& world = *host_->world;
  Editor* editor = nullptr;
  ASSERT_TRUE(world.take_editor(editor).ok());
  const Vec3 origin = world.info().origin_m;
  ViewState view = test::looking(world, {origin.x + 60, origin.y + 40, origin.z + 78},
                                 {origin.x + 60, origin.y + 8, origin.z + 60}, 160, 120);
  view.error_px = 0.05;  // so that nodes around the region are as fine before as after
  const core::Residency& residency = static_cast<core::WorldObject&>(world).terrain.residency;
  const auto frame = [&](double work_ms = 1e-3) {
    FrameResult result;
    const std::uint32_t before = residency.pool().resident();
    EXPECT_EQ(holes(view, work_ms, result), 0u);
    EXPECT_LE(residency.pool().resident() - before, 512u + 8u);  // and what the view wants in no time
    return result;
  };
  frame(0);
  for (int n = 0; n < 4; ++n) frame();
  const test::Pixels plain = picture_.read();
  EditResult told;
  ASSERT_TRUE(editor->start(ball(world, 60, 60, 11, 2), told).ok());
  ASSERT_TRUE(told.pending);
  int pending = 0, unseen = 0;
  for (; editor->is_pending(); ++pending) {
    frame();
    EXPECT_EQ(test::share_beyond(picture_.read(), plain, 0), 0.0);
    editor->advance(told);
  }
  EXPECT_TRUE(told.changed);
  for (FrameResult result = frame(); residency.fresh_parts() != 0; result = frame(), ++unseen) {
    EXPECT_NE(result.limits & kLimitWork, 0u);
    EXPECT_LE(test::share_beyond(picture_.read(), plain, 8), 0.01);
    ASSERT_LT(unseen, 100);
  }
  EXPECT_GT(residency.pool().resident(), 512u);
  EXPECT_GE(unseen, 1);
  EXPECT_GE(pending, 8);
  EXPECT_GT(test::share_beyond(picture_.read(), plain, 8), 0.02);
  for (int n = 0; (frame(2).limits & kLimitWork) != 0; ++n) ASSERT_LT(n, 10'000);
  const test::Pixels live = picture_.read();
  const std::vector<std::byte> saved = test::saved_by(*editor);
  world.release(editor);
  close();
  open(needs, {.axes = Axes::east_up_south}, {}, saved);
  FrameResult result;
  EXPECT_EQ(holes(view, 0, result), 0u);
  EXPECT_LE(test::share_beyond(picture_.read(), live, 8), 0.01);
  close();
}

}  // namespace
}  // namespace karst
