// SPDX-License-Identifier: MIT
// Editing through the public headers: the next frame and the next answer are those of the edited world.
#include <gtest/gtest.h>

#include "tests/library/host.h"

namespace karst {
namespace {

using test::Pixels;

constexpr int kWidth = 192;
constexpr int kHeight = 144;

Needs edit_needs() {
  Needs needs;
  needs.edit_patches = 4'000;
  needs.undo_bytes = 4u << 20;
  needs.queries = 1;
  return needs;
}

class Edits : public test::HostTest {
 protected:
  Edits() : HostTest(kWidth, kHeight) {}
  void begin(std::vector<std::byte> file = test::cave_world_file()) {
    open(edit_needs(), {}, {}, std::move(file));
    ASSERT_TRUE(host_->world->take_editor(editor_).ok());
    ASSERT_TRUE(host_->world->take_query(query_).ok());
  }
  void stop() {
    host_->world->release(editor_);
    host_->world->release(query_);
    close();
  }
  void TearDown() override {
    if (host_ != nullptr && host_->world != nullptr) stop();
  }
  std::vector<std::byte> saved() { return test::saved_by(*editor_); }
  // On the ground in the middle, and a view down on it.
  Hit middle() {
    const WorldInfo& info = host_->world->info();
    Hit hit;
    const Vec3 at = host_->world->from_world({0.55 * info.low_m.x + 0.45 * info.high_m.x, info.high_m.y + 1,
                                              0.5 * (info.low_m.z + info.high_m.z)});
    EXPECT_TRUE(query_->ground(at, 0, Wait::for_file, hit));
    return hit;
  }
  ViewState view_of(Vec3 place) const {
    const Vec3 at = host_->world->to_world(place);
    return test::looking(*host_->world, {at.x - 9, at.y + 10, at.z + 5}, at, kWidth, kHeight);
  }
  Pixels shot(const ViewState& view, double work_ms = 0) {
    test::draw_frame(*renderer_, picture_, {view}, work_ms);
    return picture_.read();
  }

  Editor* editor_ = nullptr;
  Query* query_ = nullptr;
};

TEST_F(Edits, AHoleIsDrawnAndAskedAtOnceAndSavedAsItIs) {
  begin();
  const Hit before = middle();
  const ViewState view = view_of(before.place);
  const Pixels intact = shot(view);
  shot(view);
  EXPECT_EQ(costs(*renderer_).generated, 0u);
  const std::uint64_t idle_bytes = costs(*renderer_).uploaded_bytes;

  Edit dig;
  dig.place = before.place;
  dig.radius_m = 3;
  EditResult result;
  ASSERT_TRUE(editor_->apply(dig, result).ok());
  EXPECT_TRUE(result.changed);
  EXPECT_EQ(result.version, 1u);
  EXPECT_GT(result.patches, 0u);
  EXPECT_LT(result.low.x, before.place.x - 2);
  EXPECT_GT(result.high.x, before.place.x + 2);
  // Nothing more to do there.
  EditResult again;
  ASSERT_TRUE(editor_->apply(dig, again).ok());
  EXPECT_FALSE(again.changed);
  EXPECT_EQ(again.version, 1u);

  // At once, even where the frame has no time.
  const Pixels dug = shot(view, 1e-6);
  EXPECT_GT(test::share_beyond(intact, dug, 8), 0.02);
  EXPECT_GT(costs(*renderer_).generated, 0u);
  EXPECT_LE(costs(*renderer_).generated, result.patches + 200u);
  const std::uint64_t edit_bytes = costs(*renderer_).uploaded_bytes - idle_bytes;
  std::printf("an edit of %u patches uploads %llu bytes, a frame without one %llu\n", result.patches,
              static_cast<unsigned long long>(edit_bytes), static_cast<unsigned long long>(idle_bytes));
  const Hit after = middle();
  EXPECT_GT(after.distance - before.distance, 1.5);

  // What is saved and loaded is drawn as it was, to the bit, and answers alike.
  const Pixels live = shot(view);
  const std::vector<std::byte> file = saved();
  const WorldInfo info = host_->world->info();
  stop();
  begin(file);
  EXPECT_EQ(host_->world->info().low_m.y, info.low_m.y);
  const Pixels loaded = shot(view);
  EXPECT_EQ(test::largest_difference(live, loaded), 0);
  const Hit same = middle();
  EXPECT_EQ(same.distance, after.distance);
  EXPECT_TRUE(saved() == file);
}

// Many edits, a frame after each: always what a world that is loaded would show.
TEST_F(Edits, FramesAreThoseOfTheWorldAsItIs) {
  begin();
  const ViewState view = view_of(middle().place);
  test::Random random{5};
  shot(view);
  const WorldInfo info = host_->world->info();
  const Vec3 size{info.high_m.x - info.low_m.x, info.high_m.y - info.low_m.y, info.high_m.z - info.low_m.z};
  for (int n = 0; n < 40; ++n) {
    Edit edit;
    // Voxels and heights of patches.
    edit.tool = static_cast<EditTool>(random.below(static_cast<int>(EditTool::paint)));
    edit.strength_m = random.unit() - 0.5;
    edit.place = host_->world->from_world({info.low_m.x + random.unit() * size.x,
                                           info.low_m.y + random.unit() * size.y,
                                           info.low_m.z + random.unit() * size.z});
    edit.radius_m = 1 + 2 * random.unit();
    EditResult result;
    ASSERT_TRUE(editor_->apply(edit, result).ok());
    middle();                  // its patches are ready before the next edit
    if (n % 3 == 0) continue;  // several before a frame
    test::draw_frame(*renderer_, picture_, {view}, n % 2 == 0 ? 0 : 1);
  }
  const Pixels live = shot(view);
  const auto answers = [&] {
    std::vector<double> all;
    test::Random asked{9};
    for (int n = 0; n < 300; ++n) {
      const double x = info.low_m.x + asked.unit() * size.x, z = info.low_m.z + asked.unit() * size.z;
      Hit hit;
      const bool found =
          query_->ground(host_->world->from_world({x, info.high_m.y + 9, z}), 0, Wait::for_file, hit);
      all.push_back(found ? hit.distance : -1);
    }
    return all;
  };
  const std::vector<double> asked = answers();
  const std::vector<std::byte> file = saved();
  stop();
  begin(file);
  EXPECT_EQ(test::largest_difference(live, shot(view)), 0);
  EXPECT_TRUE(answers() == asked);
}

// What is drawn, asked and saved is that of before, and that of after.
TEST_F(Edits, StepsAreTakenBackAndDoneAgain) {
  begin();
  const Hit at = middle();
  const ViewState view = view_of(at.place);
  struct Seen {
    Pixels pixels;
    double distance;
    std::vector<std::byte> file;
  };
  const auto see = [&] { return Seen{shot(view), middle().distance, saved()}; };
  const auto expect_seen = [&](const Seen& seen) {
    EXPECT_EQ(test::largest_difference(shot(view), seen.pixels), 0);
    EXPECT_EQ(middle().distance, seen.distance);
    EXPECT_TRUE(saved() == seen.file);
  };
  std::vector<Seen> seen = {see()};
  Edit edit;
  EditResult result;
  for (unsigned step = 0; step < 3; ++step) {
    if (step == 1) editor_->begin_stroke();
    for (int n = 0; n < (step == 1 ? 3 : 1); ++n) {
      edit.tool = step == 2 ? EditTool::fill : EditTool::clear;
      edit.place = {at.place.x + n, at.place.y - step, at.place.z};
      edit.radius_m = 2.5;
      ASSERT_TRUE(editor_->apply(edit, result).ok());
      EXPECT_TRUE(result.changed);
      EXPECT_TRUE(result.can_undo);
    }
    editor_->end_stroke();
    EXPECT_EQ(editor_->undo_state().undo_steps, step + 1);
    seen.push_back(see());
  }
  const std::uint64_t version = result.version;
  for (std::size_t n = 3; n-- > 0;) {
    ASSERT_TRUE(editor_->undo(result).ok());
    EXPECT_TRUE(result.changed);
    EXPECT_GT(result.patches, 0u);
    EXPECT_EQ(result.version, version + 3 - n);
    EXPECT_LT(result.low.x, at.place.x);
    EXPECT_GT(result.high.x, at.place.x);
    expect_seen(seen[n]);
  }
  ASSERT_TRUE(editor_->undo(result).ok());
  EXPECT_FALSE(result.changed);
  EXPECT_EQ(editor_->undo_state().redo_steps, 3u);
  for (std::size_t n = 1; n <= 3; ++n) {
    ASSERT_TRUE(editor_->redo(result).ok());
    expect_seen(seen[n]);
  }
  EXPECT_EQ(editor_->undo_state().redo_steps, 0u);
  EXPECT_EQ(editor_->undo_state().lost_steps, 0u);
}

// A long stroke is taken back in pieces: frames and queries between them see some of its edits whole, and in
// the end the world is what it was. What comes in between finishes it first.
TEST_F(Edits, ALongStrokeIsTakenBackInPieces) {
  begin();
  const Hit at = middle();
  const std::vector<std::byte> intact = saved();
  EditResult result;
  constexpr int kEdits = 8;
  std::vector<double> distances = {at.distance};
  editor_->begin_stroke();
  for (int n = 0; n < kEdits; ++n) {
    Edit edit;
    edit.place = {at.place.x + n - 4, at.place.y, at.place.z};
    edit.radius_m = 1.5 + 0.25 * n;
    ASSERT_TRUE(editor_->apply(edit, result).ok());
    ASSERT_TRUE(result.changed);
    distances.push_back(middle().distance);
  }
  editor_->end_stroke();
  const std::vector<std::byte> dug = saved();
  EXPECT_FALSE(editor_->undo_state().is_taking);
  for (int n = kEdits; n-- > 0;) {
    EXPECT_EQ(editor_->undo_state().undo_steps, 1u);
    const std::uint64_t version = result.version;
    ASSERT_TRUE(editor_->undo(result, 0).ok());
    EXPECT_TRUE(result.changed);
    EXPECT_EQ(result.version, version + 1);
    EXPECT_EQ(editor_->undo_state().is_taking, n > 0);
    ASSERT_EQ(middle().distance, distances[static_cast<std::size_t>(n)]);
  }
  EXPECT_EQ(editor_->undo_state().undo_steps, 0u);
  EXPECT_TRUE(saved() == intact);
  for (int n = 1; n <= 3; ++n) {
    ASSERT_TRUE(editor_->redo(result, 0).ok());
    EXPECT_EQ(middle().distance, distances[static_cast<std::size_t>(n)]);
  }
  EXPECT_TRUE(editor_->undo_state().is_taking);
  EXPECT_EQ(editor_->undo_state().redo_steps, 1u);
  // Saving does the rest first; the other way is all of it and back.
  EXPECT_TRUE(saved() == dug);
  EXPECT_EQ(editor_->undo_state().undo_steps, 1u);
  ASSERT_TRUE(editor_->undo(result, 0).ok());
  ASSERT_TRUE(editor_->redo(result).ok());
  EXPECT_EQ(editor_->undo_state().redo_steps, 0u);
  EXPECT_TRUE(saved() == dug);
}

// What an edit changes is its result; what was left of a step is told afterwards.
TEST_F(Edits, AnEditFinishesAStep) {
  begin();
  const Hit at = middle();
  EditResult result;
  editor_->begin_stroke();
  for (int n = 0; n < 4; ++n) {
    Edit edit;
    edit.place = {at.place.x + 2 * n, at.place.y, at.place.z};
    edit.radius_m = 1.5;
    ASSERT_TRUE(editor_->apply(edit, result).ok());
  }
  editor_->end_stroke();
  ASSERT_TRUE(editor_->undo(result, 0).ok());
  ASSERT_TRUE(editor_->undo_state().is_taking);
  Edit small;
  small.place = at.place;
  small.radius_m = 1.2;
  ASSERT_TRUE(editor_->apply(small, result).ok());
  EXPECT_TRUE(result.changed);
  EXPECT_LT(result.high.x, at.place.x + 4);
  ASSERT_TRUE(editor_->is_pending());
  editor_->advance(result);
  EXPECT_TRUE(result.changed);
  EXPECT_GT(result.high.x, at.place.x + 5);
  EXPECT_FALSE(editor_->is_pending());
  EXPECT_EQ(editor_->undo_state().undo_steps, 1u);
  EXPECT_EQ(editor_->undo_state().redo_steps, 0u);
  EXPECT_FALSE(editor_->undo_state().is_taking);
}

// A stroke of dabs on heights of patches: seen, asked, taken back and done again.
TEST_F(Edits, HeightsOfPatchesAreOneStroke) {
  begin();
  const Hit before = middle();
  const ViewState view = view_of(before.place);
  const Pixels intact = shot(view);
  const std::vector<std::byte> file = saved();
  EditResult result;
  editor_->begin_stroke();
  for (int dab = 0; dab < 3; ++dab) {
    Edit raise;
    raise.tool = EditTool::extrude;
    raise.place = before.place;
    raise.radius_m = 4;
    raise.strength_m = 0.3;
    ASSERT_TRUE(editor_->apply(raise, result).ok());
    EXPECT_TRUE(result.changed);
    EXPECT_TRUE(result.can_undo);
    EXPECT_GT(result.patches, 0u);
  }
  editor_->end_stroke();
  EXPECT_GT(before.distance - middle().distance, 0.8);
  EXPECT_GT(test::share_beyond(intact, shot(view, 1e-6), 8), 0.02);
  const Pixels up = shot(view);
  EXPECT_EQ(editor_->undo_state().undo_steps, 1u);
  ASSERT_TRUE(editor_->undo(result).ok());
  EXPECT_TRUE(result.changed);
  EXPECT_EQ(test::largest_difference(shot(view), intact), 0);
  EXPECT_EQ(middle().distance, before.distance);
  EXPECT_TRUE(saved() == file);
  ASSERT_TRUE(editor_->redo(result).ok());
  EXPECT_EQ(test::largest_difference(shot(view), up), 0);
}

TEST_F(Edits, WhatThePlanHasNoRoomForIsTold) {
  open();
  Editor* none = nullptr;
  Status status = host_->world->take_editor(none);
  EXPECT_EQ(status.code(), StatusCode::invalid_argument);
  EXPECT_STREQ(status.field(), "edit_patches");
  EXPECT_EQ(none, nullptr);
  close();
  begin();
  status = host_->world->take_editor(none);
  EXPECT_EQ(status.code(), StatusCode::limit_reached);
  Edit huge;
  huge.place = middle().place;
  huge.radius_m = 0.0 / 0.0;
  EditResult result;
  status = editor_->apply(huge, result);
  EXPECT_STREQ(status.field(), "radius_m");
  EXPECT_FALSE(result.changed);
}

}  // namespace
}  // namespace karst
