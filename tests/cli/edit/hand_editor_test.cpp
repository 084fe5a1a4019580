// SPDX-License-Identifier: MIT
// Edits by hand as events and frames make them, without a screen.
#include "app/editor/hand_editor.h"

#include <gtest/gtest.h>
#include <linux/input-event-codes.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "tests/cli/edit/hand_world.h"
#include "tests/library/ground_file.h"
#include "tests/support/memory_ground.h"

namespace karst::app {
namespace {

constexpr std::int64_t kFrame_ns = 16'666'667;
using Kind = InputEvent::Kind;

glm::dvec3 vec(Vec3 v) {
  return {v.x, v.y, v.z};
}

class HandEditorTest : public testing::Test {
 protected:
  void SetUp() override { open(4096); }
  void open(std::uint32_t edit_patches) { open(edit_patches, hand_world_file()); }
  void open(std::uint32_t edit_patches, std::span<const std::byte> file, bool digs = false) {
    folder_.write("w.karst", file);
    const std::string path = folder_.path("w.karst");
    ASSERT_EQ(session_.open({path, folder_.path("out.karst")}).text(), "");
    world_.emplace(path, edit_patches, digs);
    ASSERT_EQ(session_.begin(*world_->world).text(), "");
    hand_.emplace(*world_->world, *world_->query, session_);
    view_.width_px = 640;
    view_.height_px = 360;
    look({20, 22, 34}, {20, 9, 14});
  }
  void TearDown() override {
    hand_->end();
    session_.end();
  }
  void look(Vec3 eye, Vec3 target) {
    view_.eye = eye;
    ASSERT_TRUE(look_at(view_, target, {0, 1, 0}));
    set_perspective(view_, 60, 0.1, 200);
  }
  void event(Kind kind, unsigned code, bool pressed, double x = 0, double y = 0) {
    InputEvent event;
    event.kind = kind;
    event.code = code;
    event.pressed = pressed;
    event.x = x;
    event.y = y;
    hand_->handle(event, [&](const InputEvent& rest) { camera_.push_back(rest); });
  }
  void finger(int id, bool down, double x = 0.5, double y = 0.5) {
    InputEvent event;
    event.kind = down ? Kind::touch : Kind::untouch;
    event.id = id;
    event.x = x;
    event.y = y;
    hand_->handle(event, [&](const InputEvent& rest) { camera_.push_back(rest); });
  }
  void tap(unsigned code, int times = 1) {
    for (int n = 0; n < times; ++n) {
      event(Kind::key, code, true);
      event(Kind::key, code, false);
    }
    frame();
    while (session_.is_taking()) frame();
  }
  void frame(int count = 1) {
    for (int n = 0; n < count; ++n) hand_->frame(view_, 0, now_ += kFrame_ns);
  }
  Aimed aimed(const Brush& brush, glm::dvec2 pointer = glm::dvec2(0.5)) {
    return Aim(*world_->world, *world_->query).at(brush, view_, 0, pointer);
  }
  bool rock(const glm::dvec3& p) { return world_->query->inside({p.x, p.y, p.z}, Wait::for_file); }

  test::Folder folder_;
  std::optional<HandWorld> world_;
  EditSession session_;
  std::optional<HandEditor> hand_;
  ViewState view_;
  std::int64_t now_ = 1'000'000'000;
  std::vector<InputEvent> camera_;
};

TEST_F(HandEditorTest, ATapIsOneEditAndOneStep) {
  frame();
  const Aimed at = aimed(hand_->brush());
  ASSERT_TRUE(at.found);
  ASSERT_TRUE(rock(at.place - 1.5 * at.normal));
  tap(KEY_SPACE);
  frame(30);
  EXPECT_FALSE(rock(at.place - 1.5 * at.normal));
  EXPECT_EQ(session_.undo_steps(), 1u);
  EXPECT_FALSE(hand_->is_busy());
  tap(KEY_Z);
  EXPECT_TRUE(rock(at.place - 1.5 * at.normal));
  tap(KEY_Y);
  EXPECT_FALSE(rock(at.place - 1.5 * at.normal));
  tap(KEY_Y);
  EXPECT_EQ(hand_->message(), "there is nothing to do again");
  EXPECT_TRUE(camera_.empty());
}

// Where there is only ground a hole takes several frames, one part each; what else is asked for waits, or
// comes after it.
TEST_F(HandEditorTest, AHoleInTheGroundTakesSeveralFrames) {
  TearDown();
  const auto ground = test::MemoryGround::to_dig(257, 257, 4096, [](std::int64_t i, std::int64_t k) {
    const double height = 12 + 5 * test::value_noise(9, glm::dvec3(double(i), 0, double(k)) / 28.0);
    return static_cast<std::int32_t>(height * core::kStepsPerVoxel / core::kVertexStep);
  });
  open(4096, test::ground_file(ground, 0.5), true);
  const Vec3 middle = world_->world->info().origin_m;
  look({middle.x + 64, middle.y + 40, middle.z + 80}, {middle.x + 64, middle.y + 12, middle.z + 64});
  frame();
  const Aimed at = aimed(hand_->brush());
  ASSERT_TRUE(at.found);
  const glm::dvec3 deep = at.place - 1.5 * at.normal;
  const auto frames_until_dug = [&] {
    int frames = 0;
    for (; hand_->is_working(); ++frames) {
      EXPECT_TRUE(rock(deep));
      EXPECT_TRUE(hand_->take_changed());
      frame();
    }
    return frames;
  };
  tap(KEY_SPACE);
  ASSERT_TRUE(hand_->is_working()) << hand_->message();
  EXPECT_EQ(hand_->changes(), 0u);
  EXPECT_FALSE(session_.is_saved());
  EXPECT_GT(frames_until_dug(), 4);
  EXPECT_FALSE(rock(deep));
  EXPECT_EQ(hand_->changes(), 1u);
  EXPECT_EQ(session_.undo_steps(), 1u);
  const std::string path = JournalFile::path_for(folder_.path("w.karst"));
  const auto lines = [&] {
    const std::string journal = test::read_text(path);
    return std::count(journal.begin(), journal.end(), '\n');
  };
  const auto before = lines();
  // Held elsewhere: the next edit of the stroke waits for the first.
  look({middle.x + 30, middle.y + 40, middle.z + 110}, {middle.x + 30, middle.y + 12, middle.z + 94});
  event(Kind::key, KEY_SPACE, true);
  frame();
  ASSERT_TRUE(hand_->is_working()) << hand_->message();
  while (hand_->is_working()) {
    EXPECT_EQ(lines(), before + 1);
    frame();
  }
  frame(40);
  event(Kind::key, KEY_SPACE, false);
  frame();
  EXPECT_GT(lines(), before + 2);
  EXPECT_EQ(session_.undo_steps(), 2u);
  // Taken back while it is under way.
  tap(KEY_Z, 2);
  EXPECT_TRUE(rock(deep));
  EXPECT_EQ(session_.undo_steps(), 0u);
}

// A single voxel is dug in the ground, where its cube was shown; and not one of a region behind a hill.
TEST_F(HandEditorTest, AVoxelIsDugInTheGroundInView) {
  TearDown();
  const auto ground = test::MemoryGround::to_dig(257, 257, 4096, [](std::int64_t, std::int64_t k) {
    const double from_ridge = (double(k) / 2 - 64) / 6;
    const double height = 12 + 10 * std::exp(-from_ridge * from_ridge);
    return static_cast<std::int32_t>(height * core::kStepsPerVoxel / core::kVertexStep);
  });
  open(4096, test::ground_file(ground, 0.5), true);
  const Vec3 origin = world_->world->info().origin_m;
  EditResult result;
  session_.begin_stroke();
  ASSERT_EQ(session_.apply(ball(origin.x + 64, origin.y + 11, origin.z + 40), result).text(), "");
  while (session_.is_pending()) session_.advance(result);
  ASSERT_EQ(session_.end_stroke().text(), "");
  look({origin.x + 64, origin.y + 20, origin.z + 100}, {origin.x + 64, origin.y + 13, origin.z + 70});
  while (hand_->brush().shape() != HandShape::voxel) tap(KEY_B);
  ASSERT_EQ(hand_->brush().octree_level(), 9);
  const EyeRay ray = eye_ray(view_, 0, {0.5, 0.5});
  const glm::dvec3 end = ray.from + 100.0 * ray.along;
  Voxel behind;
  ASSERT_TRUE(world_->query->pick(view_.eye, {end.x, end.y, end.z}, 9, behind));
  ASSERT_LT(behind.centre.z, origin.z + 55);
  tap(KEY_COMMA);  // two voxels wide
  const Aimed at = aimed(hand_->brush());
  ASSERT_TRUE(at.found);
  EXPECT_EQ(at.voxel_side_m, 2);
  EXPECT_GT(at.place.z, origin.z + 64);
  ASSERT_TRUE(rock(at.place + glm::dvec3(0, -0.4, -0.4)));
  tap(KEY_SPACE);
  while (hand_->is_busy()) frame();
  EXPECT_EQ(hand_->message(), "");
  EXPECT_FALSE(rock(at.place + glm::dvec3(0, -0.4, -0.4)));
  EXPECT_TRUE(rock(at.place + glm::dvec3(0, -1.6, -1.6)));
}

// What is under way when the program ends is in the journal, and is done again.
TEST_F(HandEditorTest, AHoleThatIsUnderWayIsInTheJournal) {
  TearDown();
  const auto ground = test::MemoryGround::to_dig(257, 257, 4096, [](std::int64_t, std::int64_t) {
    return 12 * core::kStepsPerVoxel / core::kVertexStep;
  });
  open(4096, test::ground_file(ground, 0.5), true);
  const Vec3 origin = world_->world->info().origin_m;
  look({origin.x + 64, origin.y + 40, origin.z + 80}, {origin.x + 64, origin.y + 12, origin.z + 64});
  frame();
  const Aimed at = aimed(hand_->brush());
  tap(KEY_SPACE);
  ASSERT_TRUE(hand_->is_working()) << hand_->message();
  EXPECT_TRUE(rock(at.place - 1.5 * at.normal));
  hand_->end();
  session_.end();
  world_.reset();
  const std::string path = folder_.path("w.karst");
  EditSession again;
  ASSERT_EQ(again.open({path, folder_.path("out.karst")}).text(), "");
  EXPECT_EQ(again.found(), 1u);
  world_.emplace(path, 4096, true);
  ASSERT_EQ(again.begin(*world_->world).text(), "");
  EXPECT_FALSE(rock(at.place - 1.5 * at.normal));
  again.end();
}

// Held, it goes into the rock, four times a second; all of it is one step.
TEST_F(HandEditorTest, HeldItDigsOnAndIsOneStroke) {
  tap(KEY_LEFTBRACE, 6);
  frame();
  const Aimed before = aimed(hand_->brush());
  event(Kind::button, BTN_LEFT, true);
  frame(61);
  const Aimed after = aimed(hand_->brush());
  event(Kind::button, BTN_LEFT, false);
  frame();
  EXPECT_FALSE(hand_->is_busy());
  const double radius = hand_->brush().radius_m();
  const double deeper = glm::length(after.place - before.place);
  EXPECT_GT(deeper, 2.5 * radius);
  EXPECT_LT(deeper, 7 * radius + 1);
  EXPECT_EQ(session_.undo_steps(), 1u);
  tap(KEY_Z);
  EXPECT_LT(glm::length(aimed(hand_->brush()).place - before.place), 1e-9);
}

// A finger is the tool: a tap digs once, under it and not in the picture's middle.
TEST_F(HandEditorTest, ATapOfAFingerIsOneEdit) {
  tap(KEY_LEFTBRACE, 4);
  const Aimed at = aimed(hand_->brush(), {0.4, 0.55});
  ASSERT_TRUE(at.found);
  const glm::dvec3 inside = at.place - 0.5 * at.normal;
  const Aimed middle = aimed(hand_->brush());
  ASSERT_GT(glm::length(middle.place - at.place), 2 * hand_->brush().radius_m());
  finger(0, true, 0.4, 0.55);
  EXPECT_TRUE(hand_->is_busy());
  frame(2);
  EXPECT_TRUE(rock(inside)) << "another finger may follow";
  finger(0, false);
  frame();
  EXPECT_FALSE(rock(inside));
  frame(30);
  EXPECT_EQ(session_.undo_steps(), 1u);
  EXPECT_TRUE(rock(middle.place - 0.5 * middle.normal));
  EXPECT_FALSE(hand_->is_busy());
  EXPECT_TRUE(camera_.empty());
}

// Held down and moved it is a stroke, and one step.
TEST_F(HandEditorTest, AFingerThatMovesDrawsAStroke) {
  tap(KEY_LEFTBRACE, 4);
  tap(KEY_P);  // on the old surface
  const glm::dvec3 from = aimed(hand_->brush(), {0.4, 0.5}).place;
  const glm::dvec3 to = aimed(hand_->brush(), {0.6, 0.5}).place;
  ASSERT_GT(glm::length(to - from), 4 * hand_->brush().radius_m());
  finger(1, true, 0.4, 0.5);
  frame(12);
  for (int n = 1; n <= 20; ++n) {
    finger(1, true, 0.4 + 0.01 * n, 0.5);
    frame();
  }
  finger(1, false);
  frame();
  EXPECT_FALSE(hand_->is_busy());
  EXPECT_EQ(session_.undo_steps(), 1u);
  const glm::dvec3 below(0, -0.3 * hand_->brush().radius_m(), 0);
  EXPECT_FALSE(rock(from + below));
  EXPECT_FALSE(rock(to + below));
  EXPECT_TRUE(camera_.empty());
}

// Two fingers are the camera's: nothing is dug, and it knows of both.
TEST_F(HandEditorTest, TwoFingersMoveTheCamera) {
  frame();
  finger(0, true, 0.4, 0.5);
  frame(3);
  finger(1, true, 0.6, 0.5);
  finger(0, true, 0.3, 0.5);
  frame(30);
  finger(0, false);
  finger(1, true, 0.65, 0.5);
  frame(30);
  finger(1, false);
  frame();
  EXPECT_EQ(session_.undo_steps(), 0u);
  ASSERT_EQ(camera_.size(), 6u);
  EXPECT_EQ(camera_[0].kind, Kind::touch);
  EXPECT_EQ(camera_[0].id, 0);
  EXPECT_EQ(camera_[0].x, 0.4);
  EXPECT_EQ(camera_[1].id, 1);
  EXPECT_EQ(camera_[2].x, 0.3);
  EXPECT_EQ(camera_[3].kind, Kind::untouch);
  EXPECT_EQ(camera_[5].kind, Kind::untouch);
  // Another one is the tool again; a second one ends its stroke, which stays.
  finger(0, true, 0.4, 0.5);
  frame(20);
  EXPECT_EQ(camera_.size(), 6u);
  finger(1, true, 0.6, 0.5);
  frame(60);
  EXPECT_EQ(camera_.size(), 8u);
  EXPECT_EQ(session_.undo_steps(), 1u);
  EXPECT_FALSE(hand_->is_busy());
}

TEST_F(HandEditorTest, AFingerInTheSkyTurnsTheCamera) {
  look({20, 22, 34}, {20, 22, 14});
  frame();
  ASSERT_FALSE(aimed(hand_->brush(), {0.5, 0.05}).found);
  finger(0, true, 0.5, 0.05);
  frame(2);
  finger(0, true, 0.5, 0.9);  // over the ground by now
  frame(20);
  finger(0, false, 0.5, 0.9);
  frame();
  EXPECT_EQ(session_.undo_steps(), 0u);
  EXPECT_EQ(camera_.size(), 2u);
}

// A long stroke is taken back over several frames; what is asked for meanwhile waits. The journal has it
// once.
TEST_F(HandEditorTest, ALongStrokeIsTakenBackInPieces) {
  frame();
  event(Kind::button, BTN_LEFT, true);
  event(Kind::pointer, 0, false, 0.3, 0.55);
  int edits = 0;
  for (int n = 0; n < 60; ++n) {
    event(Kind::pointer, 0, false, 0.3 + 0.007 * n, 0.55);
    const std::uint64_t before = hand_->changes();
    frame();
    edits += hand_->changes() != before ? 1 : 0;
  }
  event(Kind::button, BTN_LEFT, false);
  frame();
  ASSERT_GT(edits, 20);
  const std::uint64_t before = hand_->changes();
  event(Kind::key, KEY_Z, true);
  event(Kind::key, KEY_Y, true);
  int pictures = 0;
  do {
    frame();
    ++pictures;
    EXPECT_LE(hand_->changes(), before + 1 + (hand_->is_busy() ? 0 : 1));
  } while (hand_->is_busy() && pictures < 1'000);
  EXPECT_GT(pictures, 3);
  EXPECT_EQ(hand_->changes(), before + 2);
  EXPECT_EQ(session_.undo_steps(), 1u);
  EXPECT_EQ(session_.redo_steps(), 0u);
}

// The mouse moves with the button down: what lies between two places is dug, too.
TEST_F(HandEditorTest, AStrokeHasNoGaps) {
  tap(KEY_LEFTBRACE, 4);
  tap(KEY_P);  // on the old surface
  event(Kind::pointer, 0, false, 0.4, 0.5);
  frame();
  const glm::dvec3 from = aimed(hand_->brush(), {0.4, 0.5}).place;
  const glm::dvec3 to = aimed(hand_->brush(), {0.46, 0.5}).place;
  const double apart = glm::length(to - from), radius = hand_->brush().radius_m();
  ASSERT_GT(apart, radius);
  ASSERT_LT(apart, 2 * radius);
  event(Kind::button, BTN_LEFT, true);
  frame();
  event(Kind::pointer, 0, false, 0.46, 0.5);
  frame();
  event(Kind::button, BTN_LEFT, false);
  frame();
  const std::string journal = test::read_text(JournalFile::path_for(folder_.path("w.karst")));
  EXPECT_NE(journal.find("\"capsule\""), std::string::npos) << journal;
  EXPECT_NE(journal.find("\"joined\":true"), std::string::npos);
  EXPECT_EQ(session_.undo_steps(), 1u);
}

TEST_F(HandEditorTest, AMouseWithoutPointerTurnsTheCamera) {
  event(Kind::motion, 0, false, 5, 3);
  ASSERT_EQ(camera_.size(), 3u);
  EXPECT_TRUE(camera_[0].kind == Kind::button && camera_[0].pressed);
  EXPECT_EQ(camera_[1].kind, Kind::motion);
  EXPECT_TRUE(camera_[2].kind == Kind::button && !camera_[2].pressed);
  camera_.clear();
  // One with a pointer moves the brush; its right button turns.
  event(Kind::pointer, 0, false, 0.3, 0.3);
  event(Kind::motion, 0, false, 5, 3);
  event(Kind::button, BTN_RIGHT, true);
  event(Kind::button, BTN_RIGHT, false);
  ASSERT_EQ(camera_.size(), 4u);
  EXPECT_EQ(camera_[2].code, unsigned{BTN_LEFT});
  EXPECT_TRUE(camera_[2].pressed);
  event(Kind::key, KEY_W, true);
  EXPECT_EQ(camera_.back().code, unsigned{KEY_W});
  EXPECT_FALSE(hand_->is_busy());
}

TEST_F(HandEditorTest, KeysChangeTheBrush) {
  EXPECT_EQ(hand_->brush().text(), "dig sphere 3 m, on the surface");
  tap(KEY_RIGHTBRACE, 2);
  EXPECT_NEAR(hand_->brush().radius_m(), 3 * 1.44, 1e-9);
  event(Kind::wheel, 0, false, 0, 1);
  frame();
  EXPECT_NEAR(hand_->brush().radius_m(), 3 * 1.2, 1e-9);
  tap(KEY_LEFTBRACE);
  tap(KEY_B);
  EXPECT_EQ(hand_->brush().text(), "dig box 3 m, on the surface");
  tap(KEY_B);
  EXPECT_EQ(hand_->brush().text(), "dig voxel of 1 m (level 6 of 6), on the surface");
  tap(KEY_COMMA, 2);
  EXPECT_EQ(hand_->brush().text(), "dig voxel of 4 m (level 4 of 6), on the surface");
  tap(KEY_DOT, 9);
  EXPECT_EQ(hand_->brush().octree_level(), 6);
  event(Kind::key, KEY_LEFTSHIFT, true);
  tap(KEY_T);
  EXPECT_EQ(hand_->brush().tool(), Tool::paint);
  tap(KEY_T, 2);
  event(Kind::key, KEY_LEFTSHIFT, false);
  tap(KEY_K, 3);
  tap(KEY_O, 2);
  tap(KEY_MINUS, 9);
  EXPECT_EQ(hand_->brush().text(), "flatten sphere 3 m, strength 10 %, slope 15 deg, on the surface +50 %");
  tap(KEY_I, 20);
  tap(KEY_EQUAL, 99);
  EXPECT_EQ(hand_->brush().offset(), -1);
  EXPECT_EQ(hand_->brush().strength(), 1);
}

TEST_F(HandEditorTest, WhatCannotBeDoneIsSaidOnceAndChangesNothing) {
  TearDown();
  open(16);
  event(Kind::key, KEY_SPACE, true);
  frame(2);
  EXPECT_NE(hand_->message().find("--edit-memory takes more"), std::string::npos) << hand_->message();
  EXPECT_EQ(hand_->take_news(), hand_->message());
  frame(60);
  EXPECT_EQ(hand_->take_news(), "");
  event(Kind::key, KEY_SPACE, false);
  frame();
  EXPECT_TRUE(session_.is_saved());
  tap(KEY_H);
  EXPECT_EQ(hand_->message(), "");
}

TEST_F(HandEditorTest, SavingIsShownBeforeItIsDone) {
  tap(KEY_SPACE);
  tap(KEY_F5);
  EXPECT_EQ(hand_->message(), "saving to " + session_.output() + " ...");
  EXPECT_TRUE(hand_->take_changed());
  EXPECT_FALSE(session_.is_saved());
  frame();
  EXPECT_EQ(hand_->message(), "saved to " + session_.output());
  EXPECT_TRUE(session_.is_saved());
  frame(3);
  EXPECT_FALSE(hand_->take_changed() && hand_->take_changed());
}

// K algorithm 5.1: dig takes the voxel that is met, fill puts one before it.
TEST_F(HandEditorTest, VoxelsAreThoseThatThePickFinds) {
  Brush brush(1, 6, true);
  brush.next_shape(-1);
  ASSERT_EQ(brush.shape(), HandShape::voxel);
  for (const int level : {6, 5, 3}) {
    brush.refine(level - brush.octree_level());
    const EyeRay ray = eye_ray(view_, 0, {0.5, 0.5});
    const glm::dvec3 end = ray.from + 100.0 * ray.along;
    Voxel voxel;
    ASSERT_TRUE(world_->query->pick(view_.eye, {end.x, end.y, end.z}, level, voxel));
    const Aimed dig = aimed(brush);
    ASSERT_TRUE(dig.found);
    EXPECT_EQ(dig.place, vec(voxel.centre));
    EXPECT_EQ(dig.voxel_side_m, std::ldexp(1.0, 6 - level));
    Brush filling = brush;
    filling.next_tool(1);
    const Aimed fill = aimed(filling);
    ASSERT_TRUE(fill.found);
    EXPECT_NEAR(glm::length(fill.place - dig.place), dig.voxel_side_m, 1e-12);
    // Nearer to the eye, and met by the ray.
    EXPECT_LT(glm::length(fill.place - ray.from), glm::length(dig.place - ray.from));
    const glm::dvec3 way = fill.place - ray.from;
    const double off = glm::length(way - ray.along * glm::dot(way, ray.along));
    EXPECT_LT(off, dig.voxel_side_m * 0.87);
  }
}

// L A.2's drawing planes and offset.
TEST_F(HandEditorTest, AStrokeStaysOnItsPlane) {
  const glm::dvec2 first(0.5, 0.5), second(0.42, 0.61);
  for (int on = 0; on < kDrawOns; ++on) {
    Brush brush(1, 6, true);
    brush.next_draw_on(on);
    brush.lift(2);
    Aim aim(*world_->world, *world_->query);
    const Aimed at = aim.at(brush, view_, 0, first);
    ASSERT_TRUE(at.found);
    EXPECT_NEAR(glm::length(at.place - at.surface - 1.5 * at.normal), 0, 1e-12);
    ASSERT_TRUE(aim.begin_stroke(brush));
    const glm::dvec3 moved = aim.at(brush, view_, 0, second).surface - at.surface;
    EXPECT_GT(glm::length(moved), 0.5);
    if (brush.draw_on() == DrawOn::level) {
      EXPECT_NEAR(moved.y, 0, 1e-9);
    }
    if (brush.draw_on() == DrawOn::tangent) {
      EXPECT_NEAR(glm::dot(moved, at.normal), 0, 1e-9);
    }
    const EyeRay middle = eye_ray(view_, 0, {0.5, 0.5});
    if (brush.draw_on() == DrawOn::camera) {
      EXPECT_NEAR(glm::dot(moved, middle.along), 0, 1e-9);
    }
    // All of them are where the pointer is.
    const EyeRay ray = eye_ray(view_, 0, second);
    const glm::dvec3 way = at.surface + moved - ray.from;
    EXPECT_NEAR(glm::length(glm::cross(way, ray.along)), 0, 1e-6) << on;
    aim.end_stroke();
  }
}

TEST_F(HandEditorTest, TheOldSurfaceIsThatBeforeTheStroke) {
  Brush brush(1, 6, true);
  brush.next_draw_on(1);
  ASSERT_EQ(brush.draw_on(), DrawOn::old_surface);
  Aim aim(*world_->world, *world_->query);
  const glm::dvec2 pointer(0.5, 0.5), beside(0.52, 0.51);
  const Aimed before = aim.at(brush, view_, 0, pointer);
  const Aimed before_beside = Aim(*world_->world, *world_->query).at(brush, view_, 0, beside);
  ASSERT_TRUE(before.found && before_beside.found);
  ASSERT_TRUE(aim.begin_stroke(brush));
  EditResult result;
  ASSERT_EQ(session_.apply(ball(before.place.x, before.place.y, before.place.z, 4), result).text(), "");
  const Aimed now = aimed(Brush(1, 6, true));
  EXPECT_GT(glm::length(now.surface - before.surface), 2);
  EXPECT_LT(glm::length(aim.at(brush, view_, 0, pointer).surface - before.surface), 0.5);
  EXPECT_LT(glm::length(aim.at(brush, view_, 0, beside).surface - before_beside.surface), 0.5);
  // The camera goes on, and the old surface stays where it was.
  look({21, 22, 33}, {20, 9, 14});
  const EyeRay ray = eye_ray(view_, 0, pointer);
  const Aimed moved = aim.at(brush, view_, 0, pointer);
  ASSERT_TRUE(moved.found);
  EXPECT_NEAR(glm::length(glm::cross(moved.surface - ray.from, ray.along)), 0, 0.5);
  EXPECT_LT(glm::length(moved.surface - before.surface), 3);
}

TEST_F(HandEditorTest, FlattenHasASlopeAwayFromTheEye) {
  Brush brush(1, 6, true);
  while (brush.tool() != Tool::flatten) brush.next_tool(1);
  brush.tilt(4);
  Aim aim(*world_->world, *world_->query);
  const Aimed at = aim.at(brush, view_, 0, {0.5, 0.5});
  ASSERT_TRUE(aim.begin_stroke(brush));
  const Edit edit = brush.make_edit(at.place, aim.plane_up(), 0);
  EXPECT_NEAR(std::hypot(edit.up.x, edit.up.y, edit.up.z), 1, 1e-12);
  EXPECT_NEAR(std::acos(edit.up.y) * 180 / 3.14159265358979, 20, 1e-9);
  // The eye looks to the north: the plane rises there.
  EXPECT_GT(edit.up.z, 0);
  // Other places of the stroke are on the plane.
  const Aimed other = aim.at(brush, view_, 0, {0.5, 0.4});
  EXPECT_NEAR(glm::dot(other.place - at.place, glm::dvec3(edit.up.x, edit.up.y, edit.up.z)), 0, 1e-9);
  EXPECT_GT(other.place.y, at.place.y + 0.1);
}

TEST_F(HandEditorTest, WhatIsDrawnIsOnTheGroundAndOnTheScreen) {
  frame();
  OverlayMesh mesh;
  mesh.start(view_, 0);
  hand_->draw(mesh);
  const std::size_t with_help = mesh.screen().size();
  EXPECT_GT(mesh.lines({}).size(), 64u * 6);
  EXPECT_GT(with_help, 6u * 200);
  tap(KEY_H);
  mesh.start(view_, 0);
  hand_->draw(mesh);
  EXPECT_LT(mesh.screen().size(), with_help / 2);
  // Of the smallest picture, too, it fits.
  view_.width_px = 64;
  view_.height_px = 36;
  tap(KEY_H);
  mesh.start(view_, 0);
  hand_->draw(mesh);
  EXPECT_LE(mesh.screen().size() + mesh.lines({}).size(), OverlayMesh::kMostVertices);
  // Into the sky there is no brush.
  look({20, 22, 34}, {20, 60, 14});
  frame();
  mesh.start(view_, 0);
  hand_->draw(mesh);
  EXPECT_EQ(mesh.lines({}).size(), 0u);
  event(Kind::key, KEY_SPACE, true);
  frame(3);
  event(Kind::key, KEY_SPACE, false);
  frame();
  EXPECT_TRUE(session_.is_saved());
}

}  // namespace
}  // namespace karst::app
