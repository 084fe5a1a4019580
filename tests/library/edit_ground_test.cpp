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
    needs.shadow_maps = shadows ? 2 : 0;
    open(needs, {}, {}, std::move(file));
  }
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
  EXPECT_FALSE(editor->apply(dig, result).ok());
  EXPECT_FALSE(result.changed);
  Edit paint = hill;
  paint.tool = EditTool::paint;
  EXPECT_FALSE(editor->apply(paint, result).ok());
  EXPECT_NEAR(height(3000, 2400), before + 25, 1);
  const Sink nowhere{nullptr, [](void*, std::span<const std::byte>) { return true; }};
  const Status saved = editor->save(nowhere);
  EXPECT_EQ(saved.code(), StatusCode::unsupported);
  EXPECT_STREQ(saved.field(), "ground");
  host_->world->release(editor);
}

}  // namespace
}  // namespace karst
