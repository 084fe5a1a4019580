// SPDX-License-Identifier: MIT
// Painting through the public headers: what is painted is seen in the next frame, over patches and ground,
// is saved as it is, and can be taken back.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "tests/library/colours.h"
#include "tests/library/ground_file.h"
#include "tests/library/host.h"
#include "tests/support/world_io.h"

namespace karst {
namespace {

using test::kBlue;
using test::kGreen;
using test::kRed;
using test::Pixels;
using test::share;

constexpr int kSide = 128;

// Red all over, and nobody has painted it: 32 x 32 voxels of 1 m, a plain with a bump and a cave below.
std::vector<std::byte> plain_file() {
  const test::TestWorld shape({32, 12, 32}, [](glm::ivec3 v) {
    if (v.y >= 1 && v.y < 4 && v.x > 4 && v.x < 28 && v.z > 4 && v.z < 12) return false;
    return v.y < 7 || (v.y < 8 && v.x > 12 && v.x < 20 && v.z > 12 && v.z < 20);
  });
  const std::vector<std::byte> plain = shape.file();
  const core::MaterialSet set = test::three_colours();
  const std::vector<std::byte> textures = test::textures_of(set);
  std::vector<std::byte> file;
  const Status status = core::write_world(
      {shape.info(), &shape.octree(), core::read_patches(plain), core::WorldMaterials{set, textures}}, file);
  EXPECT_TRUE(status.ok()) << status.what() << " " << status.field();
  return file;
}

std::vector<std::byte> ground_file() {
  const core::MaterialSet set = test::three_colours();
  const std::vector<std::byte> textures = test::textures_of(set);
  return test::ground_file(test::rough_ground(), test::kRoughSpacing_m, {},
                           core::WorldMaterials{set, textures});
}

class Paint : public test::HostTest {
 protected:
  Paint() : HostTest(kSide, kSide) {}
  void begin(std::vector<std::byte> file, Shading shading = Shading::forward) {
    Needs needs;
    needs.paint_width = 64;
    needs.paint_depth = 48;
    needs.undo_bytes = 1 << 20;
    needs.edit_patches = 4'000;
    needs.edit_tiles = 64;
    if (shading == Shading::deferred) needs.deferred_width = needs.deferred_height = kSide;
    open(needs, {}, {.shading = shading}, std::move(file));
    ASSERT_TRUE(host_->world->take_editor(editor_).ok());
  }
  void stop() {
    host_->world->release(editor_);
    close();
  }
  void TearDown() override {
    if (host_ != nullptr && host_->world != nullptr) stop();
  }
  std::vector<std::byte> saved() { return test::saved_by(*editor_); }
  Pixels map() { return test::picture_from_above(*host_->world, *renderer_, picture_); }
  // At a place in shares of the world from its west and its north.
  Edit brush(std::uint8_t material, double east, double south, double radius) {
    const WorldInfo& info = host_->world->info();
    Edit edit;
    edit.tool = EditTool::paint;
    edit.material = material;
    edit.hardness = 1;
    edit.radius_m = radius;
    // How high it is does not count.
    edit.place = host_->world->from_world({info.low_m.x + east * (info.high_m.x - info.low_m.x), 900,
                                           info.low_m.z + south * (info.high_m.z - info.low_m.z)});
    return edit;
  }
  EditResult apply(const Edit& edit) {
    EditResult result;
    const Status status = editor_->apply(edit, result);
    EXPECT_TRUE(status.ok()) << status.what() << " " << status.field();
    return result;
  }

  Editor* editor_ = nullptr;
};

TEST_F(Paint, IsSeenSavedAndTakenBack) {
  for (const Shading shading : {Shading::forward, Shading::deferred}) {
    const std::vector<std::byte> file = plain_file();
    begin(file, shading);
    EXPECT_TRUE(saved() == file);
    const Pixels bare = map();
    EXPECT_EQ(share(bare, kRed, 0.05, 0.95, 0.05, 0.95), 1);
    map();
    EXPECT_EQ(costs(*renderer_).uploaded_bytes, 0u);
    const EditResult result = apply(brush(1, 0.25, 0.25, 5));
    EXPECT_TRUE(result.changed);
    EXPECT_TRUE(result.can_undo);
    EXPECT_LT(result.low.x, result.high.x);
    const Pixels green = map();
    EXPECT_EQ(share(green, kGreen, 0.2, 0.3, 0.7, 0.8), 1);
    EXPECT_EQ(share(green, kRed, 0.6, 0.95, 0.05, 0.95), 1);
    EXPECT_EQ(share(green, kRed, 0.05, 0.95, 0.05, 0.4), 1);
    apply(brush(2, 0.25, 0.25, 2));
    const Pixels blue = map();
    EXPECT_EQ(share(blue, kBlue, 0.23, 0.27, 0.73, 0.77), 1);
    // Only blocks around it, without which there is nothing to upload.
    EXPECT_LE(costs(*renderer_).uploaded_bytes, 2u * 2 * 16 * 16 * 4);
    EXPECT_GT(costs(*renderer_).uploaded_bytes, 0u);

    const std::vector<std::byte> painted = saved();
    EXPECT_GT(painted.size(), file.size());
    core::WorldInfo checked;
    EXPECT_TRUE(core::read_world_info(painted, checked).ok());
    EditResult undone;
    ASSERT_TRUE(editor_->undo(undone).ok());
    EXPECT_EQ(test::largest_difference(map(), green), 0);
    ASSERT_TRUE(editor_->undo(undone).ok());
    EXPECT_EQ(test::largest_difference(map(), bare), 0);
    EXPECT_TRUE(saved() == file);
    ASSERT_TRUE(editor_->redo(undone).ok());
    ASSERT_TRUE(editor_->redo(undone).ok());
    EXPECT_EQ(test::largest_difference(map(), blue), 0);
    EXPECT_TRUE(saved() == painted);
    stop();
    // Painted on, and without room for paint.
    begin(painted, shading);
    EXPECT_EQ(host_->world->info().blend_map[0], 64u);
    EXPECT_EQ(test::largest_difference(map(), blue), 0);
    EXPECT_TRUE(saved() == painted);
    Edit wipe = brush(kNoMaterial, 0.5, 0.5, 100);
    EXPECT_TRUE(apply(wipe).changed);
    EXPECT_EQ(test::largest_difference(map(), bare), 0);
    stop();
    Needs plain;
    if (shading == Shading::deferred) plain.deferred_width = plain.deferred_height = kSide;
    open(plain, {}, {.shading = shading}, painted);
    EXPECT_EQ(test::largest_difference(map(), blue), 0);
    close();
  }
}

TEST_F(Paint, LiesOverGrounds) {
  const std::vector<std::byte> file = ground_file();
  begin(file);
  const Pixels bare = map();
  EXPECT_EQ(share(bare, kRed, 0.05, 0.95, 0.05, 0.95), 1);
  apply(brush(1, 0.25, 0.25, 900));
  apply(brush(2, 0.75, 0.75, 900));
  const Pixels painted = map();
  EXPECT_EQ(share(painted, kGreen, 0.2, 0.3, 0.7, 0.8), 1);
  EXPECT_EQ(share(painted, kBlue, 0.7, 0.8, 0.2, 0.3), 1);
  EXPECT_EQ(share(painted, kRed, 0.05, 0.45, 0.05, 0.45), 1);
  EXPECT_EQ(share(painted, kRed, 0.55, 0.95, 0.55, 0.95), 1);
  const std::vector<std::byte> kept = saved();
  stop();
  begin(kept);
  EXPECT_EQ(test::largest_difference(map(), painted), 0);
  EXPECT_TRUE(apply(brush(kNoMaterial, 0.5, 0.5, 1e4)).changed);
  EXPECT_EQ(test::largest_difference(map(), bare), 0);
}

// Soft brushes mix by shares: what is between lies between.
TEST_F(Paint, SoftBrushesHaveSoftBorders) {
  begin(plain_file());
  Edit soft = brush(1, 0.5, 0.5, 14);
  soft.hardness = 0;
  apply(soft);
  const Pixels once = map();
  const double green = share(once, kGreen, 0, 1, 0, 1);
  EXPECT_GT(green, 0.1);
  EXPECT_LT(green, 0.6);
  // Pixels that are neither: in the middle of the way there.
  const double red = share(once, kRed, 0, 1, 0, 1);
  EXPECT_GT(red, 0.1);
  soft.amount = 0.5;
  apply(soft);
  EXPECT_GT(share(map(), kGreen, 0, 1, 0, 1), green + 0.05);
}

// However weak, a brush that is held long enough paints all, and one that wipes leaves nothing.
TEST_F(Paint, WeakBrushesReachTheEnd) {
  const std::vector<std::byte> file = plain_file();
  begin(file);
  Edit weak = brush(1, 0.5, 0.5, 14);
  weak.amount = 0.01;
  for (int n = 0; n < 400; ++n) apply(weak);
  Edit whole = brush(1, 0.5, 0.5, 10);
  EXPECT_FALSE(apply(whole).changed);
  weak.material = kNoMaterial;
  for (int n = 0; n < 400; ++n) apply(weak);
  whole.material = kNoMaterial;
  EXPECT_FALSE(apply(whole).changed);
  EXPECT_EQ(share(map(), kGreen, 0, 1, 0, 1), 0);
  EXPECT_EQ(share(map(), kRed, 0.05, 0.95, 0.05, 0.95), 1);
}

// New ground of edits is painted as what was there.
TEST_F(Paint, WhatIsDugInPaintedGroundIsPainted) {
  begin(plain_file());
  apply(brush(1, 0.5, 0.75, 100));
  EXPECT_EQ(share(map(), kGreen, 0.05, 0.95, 0.05, 0.95), 1);
  Edit fill = brush(0, 0.5, 0.75, 3);
  fill.tool = EditTool::fill;
  const Vec3 place = host_->world->to_world(fill.place);
  fill.place = host_->world->from_world({place.x, host_->world->info().high_m.y, place.z});
  EXPECT_TRUE(apply(fill).changed);
  EXPECT_GE(share(map(), kGreen, 0.05, 0.95, 0.05, 0.95), 0.99);
  const Pixels live = map();
  const std::vector<std::byte> kept = saved();
  stop();
  begin(kept);
  EXPECT_EQ(test::largest_difference(map(), live), 0);
}

TEST_F(Paint, RefusalsAreTold) {
  begin(plain_file());
  EditResult result;
  Status status = editor_->apply(brush(3, 0.5, 0.5, 3), result);
  EXPECT_STREQ(status.field(), "material");
  EXPECT_FALSE(result.changed);
  stop();
  Needs needs;
  needs.edit_patches = 4'000;
  open(needs, {}, {}, plain_file());
  ASSERT_TRUE(host_->world->take_editor(editor_).ok());
  status = editor_->apply(brush(1, 0.5, 0.5, 3), result);
  EXPECT_EQ(status.code(), StatusCode::limit_reached);
  EXPECT_STREQ(status.field(), "paint_width");
  needs.paint_width = 64;
  Plan plan;
  plan.needs = needs;
  EXPECT_STREQ(make_plan(plan).field(), "paint_depth");
}

}  // namespace
}  // namespace karst
