// SPDX-License-Identifier: MIT
// Digging where there is only ground: a region is made, joined to the ground, drawn in the same frame, saved,
// and loaded as it is; what cannot be is told, and changes nothing.
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <vector>

#include "tests/library/colours.h"
#include "tests/library/edit/live_world.h"
#include "tests/library/edit/saved_ground.h"
#include "tests/library/ground/ground_to_dig.h"
#include "tests/library/host.h"
#include "tests/support/edited_world.h"
#include "tests/support/heap_count.h"
#include "tests/support/live_mesh.h"

#include "scene/world/world_object.h"

namespace karst {
namespace {

using test::ball;
using test::file_to_dig;
using test::height;
using test::LiveWorld;
using test::needs_to_dig;
using test::Pixels;

EditResult apply(LiveWorld& live, const Edit& edit) {
  EditResult result;
  const Status status = live.editor->apply(edit, result);
  EXPECT_TRUE(status.ok()) << status.what() << " " << status.field() << " " << status.value();
  return result;
}

// Saved, loaded, and measured from scratch.
void expect_as_loaded(LiveWorld& live, const std::vector<std::byte>& original) {
  const std::vector<std::byte> saved = live.saved();
  test::expect_live_tiles(live.object(), saved, original);
  LiveWorld fresh(needs_to_dig(), saved);
  ASSERT_EQ(fresh.world().ground().region_count, live.world().ground().region_count);
  for (std::size_t n = 0; n < live.world().ground().regions().size(); ++n) {
    ASSERT_EQ(fresh.world().ground().regions()[n].corner, live.world().ground().regions()[n].corner);
    ASSERT_EQ(fresh.world().ground().regions()[n].belt_low, live.world().ground().regions()[n].belt_low);
    ASSERT_EQ(fresh.world().ground().regions()[n].belt_high, live.world().ground().regions()[n].belt_high);
    test::expect_same_part(live.world().parts()[n], fresh.world().parts()[n]);
  }
  ASSERT_EQ(fresh.state(), live.state());
  ASSERT_TRUE(test::measured_facts_of(fresh.world()) == test::facts_of(fresh.world()));
  ASSERT_TRUE(fresh.saved() == saved);
}

TEST(DigGround, MakesRegionsThatAreWhatTheirFileLoads) {
  const std::vector<std::byte> file = file_to_dig();
  LiveWorld live(needs_to_dig(), file);
  EXPECT_TRUE(live.host.world->info().can_be_dug);
  EXPECT_EQ(live.world().ground().region_count, 0);
  EXPECT_TRUE(live.saved() == file);
  int regions = 0;
  for (const auto& [x, z] : {std::pair{40.0, 40.0}, {100.0, 70.0}, {43.0, 42.0}, {30.0, 95.0}}) {
    const std::uint64_t calls = test::heap_calls();
    const EditResult result = apply(live, ball(*live.host.world, x, z, 3, 1));
    EXPECT_EQ(test::heap_calls(), calls);
    EXPECT_TRUE(result.changed);
    EXPECT_TRUE(result.can_undo);
    EXPECT_GT(result.patches, 20u);
    // The third is within the first one's.
    regions += x != 43.0;
    ASSERT_EQ(live.world().ground().region_count, regions);
    for (int n = 0; n < regions; ++n)
      ASSERT_EQ(test::open_edges(live.world(), static_cast<std::size_t>(n)), 0u);
    ASSERT_NO_FATAL_FAILURE(expect_as_loaded(live, file));
  }
  // Edits there, as in any region.
  test::Random random{5};
  for (int n = 0; n < 40; ++n) {
    Edit edit = ball(*live.host.world, 40 + 6 * (random.unit() - 0.5), 40 + 6 * (random.unit() - 0.5),
                     0.5 + random.unit(), 4 * (random.unit() - 0.5));
    edit.tool = n % 3 == 0 ? EditTool::fill : EditTool::clear;
    apply(live, edit);
  }
  ASSERT_NO_FATAL_FAILURE(expect_as_loaded(live, file));
  // Taking all back leaves regions that look like the ground.
  for (EditResult result; live.editor->undo_state().undo_steps > 0;)
    ASSERT_TRUE(live.editor->undo(result).ok());
  EXPECT_EQ(live.world().ground().region_count, regions);
  ASSERT_NO_FATAL_FAILURE(expect_as_loaded(live, file));
}

// A world that was dug, saved and opened is dug on, beside regions of its file.
TEST(DigGround, GoesOnInAFile) {
  const std::vector<std::byte> file = file_to_dig();
  std::vector<std::byte> saved;
  {
    LiveWorld live(needs_to_dig(), file);
    apply(live, ball(*live.host.world, 40, 40, 3));
    saved = live.saved();
  }
  LiveWorld live(needs_to_dig(), saved);
  ASSERT_EQ(live.world().ground().region_count, 1);
  apply(live, ball(*live.host.world, 41, 40, 2, 3));
  EXPECT_EQ(live.world().ground().region_count, 1);
  apply(live, ball(*live.host.world, 100, 70, 3));
  EXPECT_EQ(live.world().ground().region_count, 2);
  expect_as_loaded(live, saved);
}

TEST(DigGround, WhatCannotBeIsToldAndChangesNothing) {
  const std::vector<std::byte> file = file_to_dig();
  LiveWorld live(needs_to_dig(), file);
  const auto refused = [&](Edit edit, const char* field) {
    EditResult result;
    const Status status = live.editor->apply(edit, result);
    EXPECT_FALSE(status.ok());
    EXPECT_STREQ(status.field(), field) << status.what();
    EXPECT_FALSE(result.changed);
  };
  const World& world = *live.host.world;
  refused(ball(world, 5, 60, 3), "place");  // the ground's border
  refused(ball(world, 75, 60, 40), "region_patches");
  Edit voxel = ball(world, 75, 60, 3);
  voxel.shape = BrushShape::voxel;
  refused(voxel, "shape");
  // Nothing is there to be taken away.
  EditResult result;
  EXPECT_TRUE(live.editor->apply(ball(world, 75, 60, 3, -30), result).ok());
  EXPECT_FALSE(result.changed);
  EXPECT_TRUE(live.saved() == file);
  for (const double x : {30.0, 75.0, 120.0}) apply(live, ball(world, x, 60, 3));
  const std::vector<std::byte> saved = live.saved();
  refused(ball(world, 75, 100, 3), "dig_regions");
  refused(ball(world, 75, 73, 3), "place");  // too near to the second
  EXPECT_TRUE(live.saved() == saved);
  // Room for tiles that is too small.
  Needs few = needs_to_dig();
  few.edit_tiles = 2;
  LiveWorld tight(few, file);
  EXPECT_STREQ(tight.editor->apply(ball(*tight.host.world, 75, 60, 3), result).field(), "edit_tiles");
  EXPECT_TRUE(tight.saved() == file);
  few = needs_to_dig();
  few.edit_patches = 8;
  LiveWorld small(few, file);
  EXPECT_STREQ(small.editor->apply(ball(*small.host.world, 75, 60, 3), result).field(), "edit_patches");
  EXPECT_EQ(small.world().ground().region_count, 0);
  EXPECT_TRUE(small.saved() == file);
  EXPECT_TRUE(apply(live, ball(world, 75, 60, 2, 2)).changed);
}

// Queries see the hole, and the ground around it as it was.
TEST(DigGround, QueriesSeeIt) {
  LiveWorld live(needs_to_dig(), file_to_dig());
  const World& world = *live.host.world;
  Query* query = nullptr;
  ASSERT_TRUE(live.host.world->take_query(query).ok());
  const auto ground_at = [&](double x, double z) {
    Hit hit;
    const Vec3 origin = world.info().origin_m;
    const Vec3 from = world.from_world({origin.x + 0.5 + x, origin.y + 100, origin.z + 0.5 + z});
    const Vec3 to = world.from_world({origin.x + 0.5 + x, origin.y - 50, origin.z + 0.5 + z});
    EXPECT_TRUE(query->ray(from, to, Wait::for_file, hit));
    return world.to_world(hit.place).y - origin.y;
  };
  EXPECT_NEAR(ground_at(60, 60), height(60, 60), 0.1);
  apply(live, ball(world, 60, 60, 4));
  EXPECT_LT(ground_at(60, 60), height(60, 60) - 3);
  double most = 0;
  for (double x = 50; x < 70; x += 0.37)
    most = std::max(most, std::abs(ground_at(x, 66.2) - height(x, 66.2)));
  EXPECT_LT(most, 0.3);
  live.host.world->release(query);
}

class DigGroundPictures : public test::HostTest {
 protected:
  DigGroundPictures() : HostTest(160, 120) {}
};

// No pixel looks through the terrain in any frame while it is dug, and far from it nothing changes.
TEST_F(DigGroundPictures, AreClosedInEachFrame) {
  const core::MaterialSet set = test::three_colours();
  const std::vector<std::byte> textures = test::textures_of(set);
  for (const double work_ms : {0.0, 1.0}) {
    open(needs_to_dig(), {.axes = Axes::east_up_south}, {}, file_to_dig(core::WorldMaterials{set, textures}));
    World& world = *host_->world;
    Editor* editor = nullptr;
    ASSERT_TRUE(world.take_editor(editor).ok());
    test::Random random{8};
    const Vec3 origin = world.info().origin_m;
    std::size_t dug = 0;
    for (int frame = 0; frame < 90; ++frame) {
      if (frame % 15 == 7) {
        const double x = 30 + 45 * double(dug % 3), z = 40 + 12 * random.unit();
        EditResult result;
        const Status status = editor->apply(ball(world, x, z, 3 + random.unit(), 1), result);
        EXPECT_TRUE(status.ok() || dug >= 3) << status.what() << " " << status.field();
        ++dug;
      }
      // Down on where it is dug, from near and far.
      const double turn = 0.15 * frame, above = 8 + 9 * (frame % 3);
      const double x = 30 + 45 * double(frame / 15 % 3), z = 46;
      const Vec3 eye{origin.x + x + 4 * std::cos(turn), origin.y + height(x, z) + above,
                     origin.z + z + 4 * std::sin(turn)};
      const Vec3 target{origin.x + x, origin.y + 8, origin.z + z};
      FrameResult result;
      ASSERT_EQ(holes(test::looking(world, eye, target, 160, 120), work_ms, result), 0u)
          << "frame " << frame << ", " << work_ms << " ms";
    }
    EXPECT_EQ(world.info().regions, 0u);  // of the file
    // What is seen is what its file shows, and not what was there before.
    const ViewState view = test::looking(world, {origin.x + 30, origin.y + 30, origin.z + 52},
                                         {origin.x + 30, origin.y + 10, origin.z + 46}, 160, 120);
    const auto picture = [&] {
      test::draw_frame(*renderer_, picture_, {view});
      return picture_.read();
    };
    const Pixels live = picture();
    const std::vector<std::byte> saved = test::saved_by(*editor);
    world.release(editor);
    close();
    open(needs_to_dig(), {.axes = Axes::east_up_south}, {}, saved);
    EXPECT_LE(test::share_beyond(picture(), live, 8), 0.005);
    close();
    open(needs_to_dig(), {.axes = Axes::east_up_south}, {}, file_to_dig(core::WorldMaterials{set, textures}));
    EXPECT_GT(test::share_beyond(picture(), live, 8), 0.02);
    close();
  }
}

}  // namespace
}  // namespace karst
