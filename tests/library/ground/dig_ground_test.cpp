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

using test::apply;
using test::ball;
using test::file_to_dig;
using test::height;
using test::LiveWorld;
using test::needs_to_dig;
using test::Pixels;

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

// Voxels of any size that are asked for where there is only ground are those of the world's lattice, and in a
// region those of its octree.
TEST(DigGround, DigsVoxels) {
  const std::vector<std::byte> file = file_to_dig();
  LiveWorld live(needs_to_dig(), file);
  const World& world = *live.host.world;
  ASSERT_EQ(world.info().octree_depth, 9);
  Query* query = nullptr;
  ASSERT_TRUE(live.host.world->take_query(query).ok());
  const Vec3 origin = world.info().origin_m;
  const auto place = [&](glm::dvec3 at) {
    return world.from_world({origin.x + at.x, origin.y + at.y, origin.z + at.z});
  };
  const auto rock = [&](glm::dvec3 at) { return query->inside(place(at), Wait::for_file); };
  int regions = 0;
  // How many halvings, where, and whether it is the first one there.
  for (const auto& [halved, x, z, first] : {std::tuple{9, 40.3, 40.4, true},
                                            {8, 42.3, 42.4, false},
                                            {7, 100.3, 41.4, true},
                                            {8, 97.3, 38.4, false},
                                            {6, 60.3, 95.4, true}}) {
    const double side = 1 << (9 - halved);
    const glm::dvec3 at(x, height(x - 0.5, z - 0.5) - 4.5 - side, z);
    const core::WorldPart& made = live.world().parts()[static_cast<std::size_t>(std::max(regions - 1, 0))];
    const glm::dvec3 corner = first ? glm::dvec3(0) : glm::dvec3(made.corner);
    const glm::dvec3 low = corner + glm::floor((at - corner) / side) * side, high = low + side;
    const glm::dvec3 middle = (low + high) * 0.5;
    ASSERT_TRUE(rock(middle));
    Edit edit;
    edit.shape = BrushShape::voxel;
    edit.octree_level = static_cast<std::uint8_t>(halved);
    edit.place = place(at);
    const EditResult result = apply(live, edit);
    EXPECT_TRUE(result.changed && result.can_undo);
    regions += first ? 1 : 0;
    ASSERT_EQ(live.world().ground().region_count, regions);
    // The cube is empty, and nothing around it.
    for (int axis = 0; axis < 3; ++axis) {
      for (const double end : {low[axis], high[axis]}) {
        glm::dvec3 near = middle;
        near[axis] = end;
        const double inwards = end == low[axis] ? 0.35 : -0.35;
        near[axis] += inwards;
        EXPECT_FALSE(rock(near)) << halved << " " << axis;
        near[axis] -= 3 * inwards;
        EXPECT_TRUE(rock(near)) << halved << " " << axis;
      }
    }
    // The same again is nothing; filled, the hole is gone.
    EXPECT_FALSE(apply(live, edit).changed);
    edit.tool = EditTool::fill;
    EXPECT_TRUE(apply(live, edit).changed);
    EXPECT_TRUE(rock(middle));
    edit.tool = EditTool::clear;
    EXPECT_TRUE(apply(live, edit).changed);
    EXPECT_FALSE(rock(middle));
  }
  live.host.world->release(query);
  expect_as_loaded(live, file);
}

// Samples are eight voxels apart, as those of elevation models are.
constexpr double kApart = 8;

double hill(double x, double z) {
  return 60 + 30 * test::value_noise(4, glm::dvec3(x, 0, z) / 60.0);
}

std::vector<std::byte> wide_file(const core::WorldMaterials& materials = core::WorldMaterials()) {
  const auto ground = test::MemoryGround::to_dig(65, 65, 65'536, [&](std::int64_t i, std::int64_t k) {
    return static_cast<std::int32_t>(hill(kApart * double(i), kApart * double(k)) * core::kStepsPerVoxel /
                                     core::kVertexStep);
  });
  return test::ground_file(ground, kApart, {}, materials);
}

// Through the samples, at the slopes of nodes' normals.
double on_curves(double x, double z) {
  const auto curve = [](const std::array<double, 4>& h, double t) {
    const double m0 = 0.5 * (h[2] - h[0]), m1 = 0.5 * (h[3] - h[1]), s = 1 - t;
    return h[1] * (1 + 2 * t) * s * s + m0 * t * s * s + h[2] * t * t * (3 - 2 * t) - m1 * t * t * s;
  };
  const double i = std::floor(x / kApart), k = std::floor(z / kApart);
  std::array<double, 4> rows{};
  for (int r = 0; r < 4; ++r) {
    std::array<double, 4> row{};
    for (int c = 0; c < 4; ++c) row[std::size_t(c)] = hill(kApart * (i + c - 1), kApart * (k + r - 1));
    rows[std::size_t(r)] = curve(row, x / kApart - i);
  }
  return curve(rows, z / kApart - k);
}

// What is drawn of a new region is lines between samples at its sides, as nodes draw, and two voxels further
// in already the curves whose slopes nodes have, so that light and materials go on.
TEST(DigGround, RegionsBendIntoTheGroundAtTheirSides) {
  Needs needs = needs_to_dig();
  needs.region_patches = 12'000;
  LiveWorld live(needs, wide_file());
  const World& world = *live.host.world;
  const Vec3 origin = world.info().origin_m;
  Edit edit;
  edit.place = world.from_world({origin.x + 130.5, origin.y + hill(130, 140) - 8, origin.z + 140.5});
  edit.radius_m = 2;
  apply(live, edit);
  ASSERT_EQ(live.world().ground().region_count, 1);
  const core::WorldPart& part = live.world().parts()[0];
  Query* query = nullptr;
  ASSERT_TRUE(live.host.world->take_query(query).ok());
  double most = 0, bent = 0;
  const auto off = [&](double x, double z) {
    Hit hit;
    const Vec3 from = world.from_world({origin.x + 0.5 + x, origin.y + 200, origin.z + 0.5 + z});
    const Vec3 to = world.from_world({origin.x + 0.5 + x, origin.y, origin.z + 0.5 + z});
    EXPECT_TRUE(query->ray(from, to, Wait::for_file, hit));
    return std::abs(world.to_world(hit.place).y - origin.y - on_curves(x, z));
  };
  const glm::ivec3 low = part.corner, high = part.corner + part.extent - 1;
  for (double along = 10.3; along < std::min(part.extent.x, part.extent.z) - 10; along += 0.7) {
    for (double in = 2.1; in < 8; in += 0.9) {
      most = std::max({most, off(low.x + along, low.z + in), off(low.x + along, high.z - in)});
      most = std::max({most, off(low.x + in, low.z + along), off(high.x - in, low.z + along)});
    }
    bent = std::max({bent, off(low.x + along, low.z + 0.01), off(low.x + 0.01, low.z + along)});
  }
  std::printf("  off the curves: %.4f voxels near the sides, %.4f in them\n", most, bent);
  EXPECT_LT(most, 0.02);
  EXPECT_GT(bent, 0.1);
  live.host.world->release(query);
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
  voxel.octree_level = 10;
  refused(voxel, "octree_level");
  voxel.octree_level = 1;
  refused(voxel, "place");  // 256 voxels wide
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

// The strongest of a pixel's colours, which is its material, or -1 where it is between two.
int colour_at(const Pixels& pixels, int x, int y) {
  const std::uint8_t* const rgb = pixels.at(x, y);
  for (int c = 0; c < 3; ++c) {
    const int others = std::max(rgb[(c + 1) % 3], rgb[(c + 2) % 3]);
    if (rgb[c] > others + others / 4 + 8) return c;
  }
  return -1;
}

// A region that was made has the ground's materials, which go by slopes, and its light, up to its sides.
TEST_F(DigGroundPictures, RegionsLookLikeTheGround) {
  core::MaterialSet set = test::three_colours();
  set.materials[1].slope_low = 0.88F;
  set.materials[1].slope_high = 2;
  set.materials[2].slope_low = -2;
  set.materials[2].slope_high = 0.8F;
  const std::vector<std::byte> textures = test::textures_of(set);
  Needs needs = needs_to_dig();
  needs.region_patches = 12'000;
  open(needs, {.axes = Axes::east_up_south}, {}, wide_file(core::WorldMaterials{set, textures}));
  World& world = *host_->world;
  Editor* editor = nullptr;
  ASSERT_TRUE(world.take_editor(editor).ok());
  const Vec3 origin = world.info().origin_m;
  const auto picture = [&](double x, double z) {
    const Vec3 target{origin.x + x, origin.y + hill(x, z), origin.z + z};
    ViewState view = test::looking(world, {target.x + 5, target.y + 60, target.z + 30}, target, 160, 120);
    view.error_px = 0.1;
    test::draw_frame(*renderer_, picture_, {view});
    return picture_.read();
  };
  double most = 0, sum = 0;
  int pictures = 0;
  for (const auto& [x, z] : {std::pair{130.0, 140.0}, {260.0, 200.0}, {380.0, 330.0}}) {
    std::vector<Pixels> before;
    const glm::dvec2 looks[] = {{x, z}, {x - 32, z}, {x + 32, z}, {x, z - 32}, {x, z + 32}};
    for (const glm::dvec2& at : looks) before.push_back(picture(at.x, at.y));
    Edit edit;
    edit.place = world.from_world({origin.x + 0.5 + x, origin.y + hill(x, z) - 8, origin.z + 0.5 + z});
    edit.radius_m = 2;
    EditResult result;
    ASSERT_TRUE(editor->apply(edit, result).ok());
    ASSERT_TRUE(result.changed);
    ASSERT_TRUE(editor->undo(result).ok());
    for (std::size_t n = 0; n < before.size(); ++n) {
      const Pixels now = picture(looks[n].x, looks[n].y);
      int others = 0;
      for (int py = 0; py < 120; ++py) {
        for (int px = 0; px < 160; ++px) others += colour_at(now, px, py) != colour_at(before[n], px, py);
      }
      const double share = others / (160.0 * 120.0);
      most = std::max(most, share);
      sum += share;
      ++pictures;
    }
  }
  std::printf("  pixels of another material: %.4f in the mean, %.4f at most\n", sum / pictures, most);
  EXPECT_LT(sum / pictures, 0.02);
  world.release(editor);
}

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
