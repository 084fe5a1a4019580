// SPDX-License-Identifier: MIT
// Edits of a ground that is drawn and asked: from the next frame on it is the world that was made so.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "tests/library/ground_file.h"
#include "tests/library/host.h"

#include "karst/edit.h"
#include "scene/edit/ground_edits.h"

namespace karst {
namespace {

using test::Pixels;

constexpr int kWidth = 160;
constexpr int kHeight = 120;
constexpr std::int64_t kWide = 600, kDeep = 480;

class GroundEdits : public test::HostTest {
 protected:
  GroundEdits() : HostTest(kWidth, kHeight) {}

  void open_file(std::vector<std::byte> file, bool shadows, std::uint32_t tiles) {
    Needs needs;
    needs.queries = 1;
    needs.edit_tiles = tiles;
    needs.undo_bytes = undo_bytes_;
    needs.shadow_maps = shadows ? 2 : 0;
    open(needs, {}, {}, std::move(file));
  }
  std::uint64_t undo_bytes_ = 0;
  core::WorldObject& world() { return static_cast<core::WorldObject&>(*host_->world); }

  double height(double x, double z) {
    Query* query = nullptr;
    EXPECT_TRUE(host_->world->take_query(query).ok());
    Hit hit;
    EXPECT_TRUE(query->ground(host_->world->from_world({x, 1000, z}), 0, Wait::for_file, hit));
    host_->world->release(query);
    return host_->world->to_world(hit.place).y;
  }
  // Complete frames over magenta; the last one's picture.
  Pixels picture(const ViewState& shown, FrameResult& result) {
    result = draw_frame(*renderer_, picture_, {shown});
    return picture_.read();
  }
  // The ground as it is edited, made and baked anew.
  std::vector<std::byte> baked_anew() {
    const core::EditGround& edits = *world().ground_edits;
    auto samples = std::make_shared<std::vector<std::int32_t>>();
    const auto rough = test::rough_heights();
    for (std::int64_t k = 0; k < kDeep; ++k) {
      for (std::int64_t i = 0; i < kWide; ++i) {
        const std::int64_t x = std::min(i / 64, (kWide - 2) / 64), z = std::min(k / 64, (kDeep - 2) / 64);
        const core::EditedTile* const tile =
            edits.overlay().find({0, static_cast<int>(x), static_cast<int>(z)});
        samples->push_back(
            tile == nullptr ? rough(i, k)
                            : tile->tile.height(static_cast<int>(i - 64 * x), static_cast<int>(k - 64 * z)));
      }
    }
    const double step = test::rough_ground().info().steps[0];
    const test::MemoryGround ground(kWide, kDeep, step, step, [samples](std::int64_t i, std::int64_t k) {
      return (*samples)[static_cast<std::size_t>(k * kWide + i)];
    });
    return test::ground_file(ground, test::kRoughSpacing_m);
  }
};

TEST_F(GroundEdits, AHillIsDrawnAndAskedInTheNextFrame) {
  for (const bool shadows : {false, true}) {
    open_file(test::ground_file(test::rough_ground(), test::kRoughSpacing_m), shadows, 64);
    const DeviceInfo device = device_info(*renderer_);
    EXPECT_EQ(device.cpu_bytes, host_->plan.cpu_bytes);
    ViewState shown = test::looking(*host_->world, {2900, 420, 2520}, {3000, 60, 2400}, kWidth, kHeight);
    shown.error_px = 1;
    FrameResult result;
    const Pixels before = picture(shown, result);
    const double was = height(3000, 2400);

    core::Edit edit;
    edit.tool = core::EditTool::extrude;
    edit.shape = core::BrushShape::cylinder;
    const double voxel_m = world().terrain.world.info().voxel_size_m;
    edit.place = {3000 / voxel_m, 0, 2400 / voxel_m};
    edit.radius = 150 / voxel_m;
    edit.strength = 80 / voxel_m;
    core::GroundChange change;
    std::uint32_t nodes = 0;
    ASSERT_TRUE(core::edit_ground(world(), edit, nullptr, change, nodes).ok());
    EXPECT_TRUE(change.changed);
    EXPECT_GT(nodes, 20u);
    EXPECT_NEAR(height(3000, 2400), was + 80, 0.01);
    const Pixels after = picture(shown, result);
    EXPECT_GT(test::share_beyond(before, after, 8), 0.05);
    EXPECT_EQ(holes(shown, 0, result), 0u);

    const std::vector<std::byte> file = baked_anew();
    close();
    open_file(file, shadows, 0);
    const Pixels baked = picture(shown, result);
    EXPECT_EQ(test::largest_difference(after, baked), 0);
    EXPECT_NEAR(height(3000, 2400), was + 80, 0.01);
    close();
  }
}

// The same through the public header.
TEST_F(GroundEdits, ByTheEditor) {
  open_file(test::ground_file(test::rough_ground(), test::kRoughSpacing_m), false, 64);
  Editor* editor = nullptr;
  ASSERT_TRUE(host_->world->take_editor(editor).ok());
  const double before = height(3000, 2400);
  Edit hill;
  hill.tool = EditTool::extrude;
  hill.place = host_->world->from_world({3000, before, 2400});
  hill.radius_m = 60;
  hill.strength_m = 25;
  EditResult result;
  ASSERT_TRUE(editor->apply(hill, result).ok());
  EXPECT_TRUE(result.changed);
  EXPECT_EQ(result.version, 1u);
  EXPECT_NEAR(height(3000, 2400), before + 25, 1);
  // All that changed lies in the box, and the box around the brush.
  const Vec3 low = host_->world->to_world(result.low), high = host_->world->to_world(result.high);
  EXPECT_LE(std::min(low.x, high.x), 2950);
  EXPECT_GE(std::min(low.x, high.x), 2900);
  EXPECT_LE(std::max(low.x, high.x), 3100);
  EXPECT_GE(std::max(low.y, high.y), before + 24);
  // What cannot be done changes nothing and says so.
  Edit dig;
  dig.place = hill.place;
  const Status dug = editor->apply(dig, result);
  EXPECT_EQ(dug.code(), StatusCode::unsupported);
  EXPECT_STREQ(dug.field(), "ground");
  EXPECT_FALSE(result.changed);
  Edit paint = hill;
  paint.tool = EditTool::paint;
  EXPECT_FALSE(editor->apply(paint, result).ok());
  EXPECT_NEAR(height(3000, 2400), before + 25, 1);
  host_->world->release(editor);
}

// A stroke is one step; pictures, answers and the state are those of before, and those of after.
TEST_F(GroundEdits, AStrokeIsTakenBackAndDoneAgain) {
  undo_bytes_ = 1 << 20;
  open_file(test::ground_file(test::rough_ground(), test::kRoughSpacing_m), false, 64);
  Editor* editor = nullptr;
  ASSERT_TRUE(host_->world->take_editor(editor).ok());
  const auto expect_state = [&](std::uint32_t undo, std::uint32_t redo, std::uint64_t lost) {
    const UndoState state = editor->undo_state();
    EXPECT_EQ(state.undo_steps, undo);
    EXPECT_EQ(state.redo_steps, redo);
    EXPECT_EQ(state.lost_steps, lost);
  };
  ViewState shown = test::looking(*host_->world, {2900, 420, 2520}, {3000, 60, 2400}, kWidth, kHeight);
  shown.error_px = 1;
  FrameResult frame;
  EditResult result;
  ASSERT_TRUE(editor->undo(result).ok());
  EXPECT_FALSE(result.changed);
  const Pixels before = picture(shown, frame);
  const double was = height(3000, 2400);
  Edit hill;
  hill.tool = EditTool::extrude;
  hill.radius_m = 60;
  hill.strength_m = 25;
  Vec3 low, high;
  editor->begin_stroke();
  for (int n = 0; n < 5; ++n) {
    const double x = 2960 + 20.0 * n;
    hill.place = host_->world->from_world({x, height(x, 2400), 2400});
    ASSERT_TRUE(editor->apply(hill, result).ok());
    EXPECT_TRUE(result.can_undo);
    EXPECT_EQ(result.version, static_cast<std::uint64_t>(n) + 1);
    low = n == 0 ? result.low : low;
    high = result.high;
  }
  editor->end_stroke();
  expect_state(1, 0, 0);
  const Pixels after = picture(shown, frame);
  const double is = height(3000, 2400);
  EXPECT_GT(is, was + 25);
  for (int round = 0; round < 2; ++round) {
    ASSERT_TRUE(editor->undo(result).ok());
    expect_state(0, 1, 0);
    EXPECT_TRUE(result.changed);
    EXPECT_EQ(result.version, 6u + 2 * static_cast<unsigned>(round));
    EXPECT_GT(result.nodes, 20u);
    // Of all the stroke.
    EXPECT_LE(std::min(result.low.x, result.high.x), std::min(low.x, high.x));
    EXPECT_GE(std::max(result.low.x, result.high.x), std::max(low.x, high.x));
    EXPECT_EQ(height(3000, 2400), was);
    EXPECT_EQ(test::largest_difference(picture(shown, frame), before), 0);
    ASSERT_TRUE(editor->redo(result).ok());
    expect_state(1, 0, 0);
    EXPECT_EQ(height(3000, 2400), is);
    EXPECT_EQ(test::largest_difference(picture(shown, frame), after), 0);
  }
  ASSERT_TRUE(editor->redo(result).ok());
  EXPECT_FALSE(result.changed);
  // What fails is no step and forgets none; a step that is too large is made and forgets all.
  ASSERT_TRUE(editor->undo(result).ok());
  Edit wrong = hill;
  wrong.radius_m = -1;
  EXPECT_FALSE(editor->apply(wrong, result).ok());
  expect_state(0, 1, 0);
  ASSERT_TRUE(editor->apply(hill, result).ok());
  expect_state(1, 0, 0);
  host_->world->release(editor);
  close();
  undo_bytes_ = 8192;
  open_file(test::ground_file(test::rough_ground(), test::kRoughSpacing_m), false, 64);
  ASSERT_TRUE(host_->world->take_editor(editor).ok());
  hill.place = host_->world->from_world({3040, height(3040, 2400), 2400});
  hill.radius_m = 20;
  ASSERT_TRUE(editor->apply(hill, result).ok());
  EXPECT_TRUE(result.can_undo);
  hill.radius_m = 200;
  const double low_hill = height(3040, 2400);
  ASSERT_TRUE(editor->apply(hill, result).ok());
  EXPECT_TRUE(result.changed);
  EXPECT_FALSE(result.can_undo);
  EXPECT_GT(height(3040, 2400), low_hill + 20);
  expect_state(0, 0, 2);
  ASSERT_TRUE(editor->undo(result).ok());
  EXPECT_FALSE(result.changed);
  host_->world->release(editor);
}

}  // namespace
}  // namespace karst
