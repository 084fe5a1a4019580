// SPDX-License-Identifier: MIT
// Fields painted through the public headers: what is seen, taken back, saved and refused.
#include <gtest/gtest.h>

#include <vector>

#include "tests/library/colours.h"
#include "tests/library/host.h"
#include "tests/support/field_mesh.h"

namespace karst {
namespace {

using test::largest_difference;
using test::OwnField;
using test::Pixels;
using test::saved_by;

constexpr int kSide = 120;

class FieldPaint : public test::HostTest {
 protected:
  FieldPaint() : HostTest(kSide, kSide) {}
  void TearDown() override {
    if (editor_ != nullptr) host_->world->release(editor_);
    HostTest::TearDown();
  }

  static std::vector<std::byte> ball_file() {
    core::FieldInfo info = test::field_info(glm::ivec3(4), 0);
    OwnField own(info, 64);
    own.fill([](glm::dvec3 p) { return glm::length(p - 32.0) - 20; });
    const core::MaterialSet set = test::three_colours();
    const std::vector<std::byte> textures = test::textures_of(set);
    return test::field_world_file(own.field, {set, textures});
  }
  void open_ball(std::vector<std::byte> file, std::uint32_t material_blocks = 64) {
    if (editor_ != nullptr) host_->world->release(editor_);
    editor_ = nullptr;
    Needs needs;
    needs.field_sample_blocks = 64;
    needs.field_material_blocks = material_blocks;
    needs.undo_bytes = 4 << 20;
    open(needs, {.axes = Axes::east_up_south}, {}, std::move(file));
    ASSERT_TRUE(host_->world->take_editor(editor_).ok());
  }
  Pixels picture() {
    karst::ViewState view = test::looking(*host_->world, {32, 32, 110}, {32, 32, 32}, kSide, kSide);
    test::draw_frame(*renderer_, picture_, {view});
    return picture_.read();
  }
  // The ball's nearest point, green; the other materials are by rules.
  static Edit dab(double radius_m) {
    Edit edit;
    edit.tool = EditTool::paint;
    edit.place = {32, 32, 52};
    edit.radius_m = radius_m;
    edit.amount = 1;
    edit.hardness = 0.9;
    edit.material = 1;
    return edit;
  }

  Editor* editor_ = nullptr;
};

TEST_F(FieldPaint, ADabIsSeenTakenBackAndSaved) {
  open_ball(ball_file());
  const Pixels before = picture();
  const std::vector<std::byte> plain = saved_by(*editor_);
  EditResult result;
  ASSERT_TRUE(editor_->apply(dab(6), result).ok());
  EXPECT_TRUE(result.changed && result.can_undo);
  const Pixels painted = picture();
  const std::uint8_t* const was = before.at(kSide / 2, kSide / 2);
  const std::uint8_t* const is = painted.at(kSide / 2, kSide / 2);
  EXPECT_GT(was[0], was[1] + 40);
  EXPECT_GT(is[1], is[0] + 40);
  // Beside it all is as it was.
  const int side = kSide / 2 - 22;
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(painted.at(side, kSide / 2)[c], before.at(side, kSide / 2)[c], 3);
  const std::vector<std::byte> saved = saved_by(*editor_);
  EXPECT_NE(saved, plain);
  ASSERT_TRUE(editor_->undo(result).ok());
  EXPECT_TRUE(result.changed);
  EXPECT_EQ(saved_by(*editor_), plain);
  EXPECT_EQ(largest_difference(picture(), before), 0);
  ASSERT_TRUE(editor_->redo(result).ok());
  EXPECT_EQ(saved_by(*editor_), saved);
  EXPECT_EQ(largest_difference(picture(), painted), 0);
  open_ball(saved);
  EXPECT_EQ(saved_by(*editor_), saved);
  EXPECT_EQ(largest_difference(picture(), painted), 0);
}

// Digging through what was painted, in one stroke with it.
TEST_F(FieldPaint, StrokesOfPaintAndHolesAreOneStep) {
  open_ball(ball_file());
  const std::vector<std::byte> plain = saved_by(*editor_);
  EditResult result;
  editor_->begin_stroke();
  for (const EditTool tool : {EditTool::paint, EditTool::clear, EditTool::paint, EditTool::clear}) {
    Edit edit = dab(4);
    edit.tool = tool;
    edit.place.x += tool == EditTool::clear ? 3 : 0;
    ASSERT_TRUE(editor_->apply(edit, result).ok());
  }
  editor_->end_stroke();
  const std::vector<std::byte> edited = saved_by(*editor_);
  EXPECT_NE(edited, plain);
  ASSERT_TRUE(editor_->undo(result).ok());
  EXPECT_EQ(saved_by(*editor_), plain);
  EXPECT_EQ(editor_->undo_state().undo_steps, 0u);
  ASSERT_TRUE(editor_->redo(result).ok());
  EXPECT_EQ(saved_by(*editor_), edited);
}

TEST_F(FieldPaint, WhatIsRefusedChangesNothing) {
  open_ball(ball_file(), 1);
  const std::vector<std::byte> plain = saved_by(*editor_);
  EditResult result;
  const Status full = editor_->apply(dab(12), result);
  EXPECT_EQ(full.code(), StatusCode::limit_reached);
  EXPECT_STREQ(full.field(), "field_material_blocks");
  EXPECT_GT(full.value(), 0u);
  Edit wrong = dab(4);
  wrong.material = 9;
  EXPECT_STREQ(editor_->apply(wrong, result).field(), "material");
  EXPECT_STREQ(editor_->apply(dab(-1), result).field(), "radius_m");
  EXPECT_FALSE(result.changed);
  EXPECT_EQ(saved_by(*editor_), plain);
}

}  // namespace
}  // namespace karst
