// SPDX-License-Identifier: MIT
// Edits of patches' heights: all that follows is what a file of the edited world loads, and shared vertices
// have one height.
#include "terrain/edit/patch/edit_heights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include <glm/geometric.hpp>

#include "terrain/edit/brush.h"
#include "terrain/edit/patch/smooth_heights.h"
#include "terrain/patch/shared_vertices.h"
#include "tests/support/edited_world.h"
#include "tests/support/heap_count.h"

namespace karst::core {
namespace {

using test::LoadedWorld;
using test::TestWorld;

constexpr std::uint32_t kRoom = 2'000;

TestWorld rough_world(std::uint64_t seed, int level, int amplitude = 1500) {
  TestWorld world = TestWorld::noise(seed, {14, 11, 13}, 0.45, 5.0, false);
  world.roughen(level, seed + 7, amplitude);
  return world;
}

std::int32_t height_at(const World& world, const GridVertex& v) {
  const std::uint32_t block = world.surface().patches[v.patch].height_block;
  const int level = world.info().level;
  return block == kNoHeights ? 0 : world.heights().block(block)[v.j * patch_side(level) + v.i];
}

template <class Visit>
void for_each_vertex(const World& world, const Visit& visit) {
  const int n = patch_cells(world.info().level);
  for (PatchId p = 0; p < world.surface().patches.size(); ++p) {
    if (world.surface().is_free(p)) continue;
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i) visit(GridVertex{p, i, j});
    }
  }
}

std::vector<std::int32_t> all_heights(const World& world) {
  std::vector<std::int32_t> out;
  for_each_vertex(world, [&](const GridVertex& v) { out.push_back(height_at(world, v)); });
  return out;
}

// Of all copies, over borders, at corners and at points of three-edge patches.
void expect_shared_heights(const World& world) {
  std::uint32_t different = 0;
  for_each_vertex(world, [&](const GridVertex& v) {
    const std::int32_t height = height_at(world, v);
    for_each_copy(world.surface().patches, world.info().level, v,
                  [&](const GridVertex& copy) { different += height_at(world, copy) != height; });
  });
  ASSERT_EQ(different, 0u);
}

glm::dvec3 place_of(const World& world, const GridVertex& v) {
  const BasePoint base = base_point(world.surface(), world.info().level, v.patch, v.i, v.j);
  return glm::dvec3(patch_origin(world.surface().volume_of(v.patch))) / double{kStepsPerVoxel} +
         base.position + base.direction * (height_at(world, v) / double{kStepsPerVoxel});
}

TEST(EditHeights, RandomDabsAreWhatAFileLoads) {
  test::Random random{5};
  std::uint32_t changed[kEditTools] = {}, over_borders = 0;
  for (std::uint64_t round = 0; round < 12; ++round) {
    const int level = 1 + static_cast<int>(round % 4);
    LoadedWorld live(rough_world(round, level).file(), kRoom);
    World& world = live.world;
    for (int edit = 0; edit < (level == 4 ? 15 : 40); ++edit) {
      EditChange change;
      const bool shape = random.below(8) == 0;
      const Edit made = shape ? test::random_voxel_edit(random, world.info().extent, world.octree().depth())
                              : test::random_heights_edit(random, world.info().extent);
      const std::size_t before = test::heap_calls();
      const Status status =
          shape ? edit_shape(world, made, change) : edit_heights(world, made, nullptr, change);
      EXPECT_EQ(test::heap_calls(), before);
      ASSERT_TRUE(status.ok()) << status.what() << " " << status.field() << " " << status.value();
      if (!change.changed) continue;
      ++changed[static_cast<int>(made.tool)];
      over_borders += change.touched.size() > 20;
      expect_shared_heights(world);
      test::expect_as_loaded(live);
      if (testing::Test::HasFatalFailure())
        FAIL() << "round " << round << " edit " << edit << " tool " << static_cast<int>(made.tool);
    }
  }
  for (const EditTool tool : {EditTool::clear, EditTool::extrude, EditTool::smooth, EditTool::noise,
                              EditTool::flatten, EditTool::level})
    EXPECT_GT(changed[static_cast<int>(tool)], 10u) << static_cast<int>(tool);
  EXPECT_GT(over_borders, 50u);
}

// Borders at the finest level: sums of dyadic numbers stay exact there, too.
TEST(EditHeights, SharedVerticesAtTheFinestLevel) {
  test::Random random{9};
  LoadedWorld live(rough_world(4, kMaxLevel, 900).file(), kRoom);
  int changed[kEditTools] = {};
  for (int edit = 0; edit < 25; ++edit) {
    EditChange change;
    Edit made = test::random_heights_edit(random, live.world.info().extent);
    made.tool = static_cast<EditTool>(static_cast<int>(EditTool::extrude) + edit % 5);
    ASSERT_TRUE(edit_heights(live.world, made, nullptr, change).ok());
    changed[static_cast<int>(made.tool)] += change.changed;
    expect_shared_heights(live.world);
    if (testing::Test::HasFatalFailure()) FAIL() << edit << " tool " << static_cast<int>(made.tool);
  }
  for (int tool = static_cast<int>(EditTool::extrude); tool <= static_cast<int>(EditTool::level); ++tool)
    EXPECT_GT(changed[tool], 2) << tool;
}

// Vertices move as the header says, others not at all.
TEST(EditHeights, ToolsDoWhatTheySay) {
  for (const EditTool tool : {EditTool::extrude, EditTool::noise, EditTool::level, EditTool::flatten}) {
    for (const BrushShape shape :
         {BrushShape::box, BrushShape::sphere, BrushShape::capsule, BrushShape::cylinder}) {
      LoadedWorld live(rough_world(3, 2).file(), kRoom);
      const World& world = live.world;
      std::vector<glm::dvec3> places;
      for_each_vertex(world, [&](const GridVertex& v) { places.push_back(place_of(world, v)); });
      const std::vector<std::int32_t> before = all_heights(world);
      Edit edit;
      edit.tool = tool;
      edit.shape = shape;
      edit.place = {7.2, 5.1, 6.3};
      edit.to = {9, 5.5, 6};
      edit.half = {2, 1.5, 2.5};
      edit.radius = 2.2;
      edit.strength = 0.4;
      edit.amount = 0.75;
      edit.hardness = 0.5;
      edit.wave = 1.5;
      edit.up = {1, 2, -0.5};
      const glm::dvec3 up = tool == EditTool::level ? glm::dvec3(0, 1, 0) : glm::normalize(edit.up);
      EditChange change;
      ASSERT_TRUE(edit_heights(live.world, edit, nullptr, change).ok());
      std::size_t at = 0, moved = 0, within = 0;
      for_each_vertex(world, [&](const GridVertex& v) {
        const glm::dvec3 place = places[at];
        const std::int32_t was = before[at++], is = height_at(world, v);
        const double weight = brush_weight(edit, place);
        moved += is != was;
        within += weight > 0.99;
        double wanted = was;
        if (tool == EditTool::extrude) wanted += weight * edit.strength * kStepsPerVoxel;
        if (tool == EditTool::noise) {
          wanted += weight * edit.strength * kStepsPerVoxel * simplex_noise(place / edit.wave, edit.seed);
        }
        if (tool == EditTool::extrude || tool == EditTool::noise) {
          // Places are rounded to lattice steps where weights are looked up.
          ASSERT_NEAR(is, std::clamp<double>(wanted, -kMaxHeight, kMaxHeight), 8);
          return;
        }
        const BasePoint base = base_point(world.surface(), 2, v.patch, v.i, v.j);
        const double across = glm::dot(base.direction, up);
        const double share = weight * edit.amount * std::min(1.0, std::pow(across / kLeastAcross, 2));
        const double below = glm::dot(edit.place - place, up);
        const bool is_clamped = std::abs(is) == kMaxHeight;
        if (is_clamped) return;
        ASSERT_NEAR(glm::dot(edit.place - place_of(world, v), up), (1 - share) * below, 2e-3);
      });
      EXPECT_GT(moved, 20u) << static_cast<int>(tool) << static_cast<int>(shape);
      EXPECT_GT(within, 10u);
      EXPECT_LT(moved, before.size() / 2);
    }
  }
}

// What is even stays so, to the bit, at borders and corners as well; what is not becomes so.
TEST(EditHeights, SmoothingEvensOut) {
  for (const int level : {1, 3}) {
    TestWorld even = TestWorld::noise(6, {14, 11, 13}, 0.45, 5.0, false);
    even.set_heights(level, [](glm::dvec3) { return 750.0; });
    Edit edit;
    edit.tool = EditTool::smooth;
    edit.place = {7, 5, 6};
    edit.radius = 40;
    edit.hardness = 1;
    LoadedWorld live(even.file(), kRoom);
    EditChange change;
    ASSERT_TRUE(edit_heights(live.world, edit, nullptr, change).ok());
    EXPECT_FALSE(change.changed);
    LoadedWorld rough(rough_world(6, level).file(), kRoom);
    const auto spread = [](const std::vector<std::int32_t>& heights) {
      double sum = 0;
      for (const std::int32_t h : heights) sum += double{static_cast<double>(h)} * h;
      return std::sqrt(sum / static_cast<double>(heights.size()));
    };
    const double before = spread(all_heights(rough.world));
    for (int k = 0; k < 5; ++k) ASSERT_TRUE(edit_heights(rough.world, edit, nullptr, change).ok());
    EXPECT_LT(spread(all_heights(rough.world)), before / 4);
  }
}

// The mean of a vertex on a border is that of the eight around it in both patches.
TEST(EditHeights, MeansLookOverBorders) {
  LoadedWorld live(rough_world(8, 3).file(), kRoom);
  const World& world = live.world;
  const int n = patch_cells(3);
  const HeightsAround around(world.surface(), world.heights(), 3);
  std::size_t seen = 0;
  for_each_vertex(world, [&](const GridVertex& v) {
    const double mean = around.mean(v.patch, v.i, v.j);
    for_each_copy(world.surface().patches, 3, v,
                  [&](const GridVertex& copy) { ASSERT_EQ(around.mean(copy.patch, copy.i, copy.j), mean); });
    if (v.j != 0 || v.i == 0 || v.i == n) return;
    const PatchEdge other = world.surface().patches[v.patch].neighbour[0];
    if (!other.exists()) return;
    std::int64_t sum = 0;
    for (int di = -1; di <= 1; ++di) {
      sum += height_at(world, {v.patch, v.i + di, 1});
      if (di != 0) sum += height_at(world, {v.patch, v.i + di, 0});
      const GridLine row = GridLine::along_edge(other.edge(), 1, 3, true);
      const int t = v.i + di;
      sum += height_at(world, {other.patch(), row.i0 + t * row.di, row.j0 + t * row.dj});
    }
    ASSERT_EQ(mean, static_cast<double>(sum) / 8);
    ++seen;
  });
  EXPECT_GT(seen, 500u);
}

TEST(EditHeights, StayWithinWhatSixteenBitsHold) {
  Edit edit;
  edit.tool = EditTool::extrude;
  edit.place = {7, 5, 6};
  edit.radius = 4;
  for (const double strength : {1e5, -1e5}) {
    LoadedWorld live(rough_world(2, 2).file(), kRoom);
    edit.strength = strength;
    EditChange change;
    ASSERT_TRUE(edit_heights(live.world, edit, nullptr, change).ok());
    std::size_t most = 0;
    for (const std::int32_t height : all_heights(live.world)) {
      ASSERT_LE(std::abs(height), kMaxHeight);
      most += height == (strength > 0 ? kMaxHeight : -kMaxHeight);
    }
    EXPECT_GT(most, 100u);
    test::expect_as_loaded(live);
  }
}

// Patches without heights get some, and lose them where all are 0 again.
TEST(EditHeights, BlocksComeAndGo) {
  TestWorld file = TestWorld::noise(6, {14, 11, 13}, 0.45, 5.0, false);
  file.set_heights(2, [](glm::dvec3 p) { return p.x < 3 ? 400.0 : 0.0; });
  LoadedWorld first(file.file(), kRoom);
  // Blocks of zeros come into files by other hands alone.
  const World::Editable all = first.world.edit(0);
  for (PatchId p = 0; p < all.surface.patches.size(); ++p) {
    if (!all.surface.is_free(p)) put_heights(all, p, all.heights->block(p));
  }
  LoadedWorld live(first.save(), kRoom);
  const auto blocks = [&] {
    std::size_t count = 0;
    for (const Patch& patch : live.world.surface().patches) count += patch.height_block != kNoHeights;
    return count;
  };
  const std::size_t before = blocks();
  const std::vector<std::byte> saved = live.save();
  Edit edit;
  edit.tool = EditTool::extrude;
  edit.shape = BrushShape::box;
  edit.hardness = 1;
  edit.place = {7, 5, 6};
  edit.half = {40, 40, 40};
  edit.strength = 0.125;
  EditChange change;
  ASSERT_TRUE(edit_heights(live.world, edit, nullptr, change).ok());
  EXPECT_EQ(blocks(), live.world.patch_count() - live.world.free_patches());
  EXPECT_GT(blocks(), before);
  test::expect_as_loaded(live);
  edit.strength = -0.125;
  ASSERT_TRUE(edit_heights(live.world, edit, nullptr, change).ok());
  EXPECT_EQ(blocks(), before);
  test::settle(live.world);
  EXPECT_TRUE(live.save() == saved);
}

// Steps of several dabs are taken back and done again to the bit; a patch is kept once a step. Where there is
// little room, what follows comes in several goes.
TEST(EditHeights, StepsAreTakenBack) {
  for (const std::uint32_t room : {kRoom, 40u}) {
    LoadedWorld live(rough_world(4, 2).file(), room);
    World& world = live.world;
    std::vector<std::uint64_t> memory(1 << 19);
    UndoLog log;
    log.create(std::as_writable_bytes(std::span(memory)));
    test::Random random{3};
    std::vector<std::vector<std::byte>> states{live.save()};
    for (int step = 0; step < 6; ++step) {
      log.begin();
      for (int dab = 0; dab < 12; ++dab) {
        Edit edit = test::random_heights_edit(random, world.info().extent);
        edit.shape = BrushShape::sphere;
        edit.radius = 0.6 + 0.4 * random.unit();
        EditChange change;
        const Status status = edit_heights(world, edit, &log, change);
        ASSERT_TRUE(status.ok()) << status.field() << status.value();
      }
      log.end();
      test::settle(world);
      states.push_back(live.save());
    }
    std::size_t goes = 0;
    const auto take = [&](UndoPart part) {
      ASSERT_EQ(part.kind(), CellKind::patch_heights);
      std::vector<std::uint64_t> keys;
      for (const UndoCell cell : part) keys.push_back(cell.key);
      std::sort(keys.begin(), keys.end());
      ASSERT_EQ(std::adjacent_find(keys.begin(), keys.end()), keys.end());
      ExchangeHeights exchange(world, part);
      for (EditChange change; exchange.next(change); ++goes) ASSERT_FALSE(change.touched.empty());
    };
    for (std::size_t at = states.size() - 1; at-- > 0;) {
      ASSERT_TRUE(log.undo(take));
      test::settle(world);
      ASSERT_TRUE(live.save() == states[at]);
      test::expect_as_loaded(live);
    }
    EXPECT_FALSE(log.undo(take));
    for (std::size_t at = 1; at < states.size(); ++at) {
      ASSERT_TRUE(log.redo(take));
      test::settle(world);
      ASSERT_TRUE(live.save() == states[at]);
    }
    test::expect_as_loaded(live);
    EXPECT_EQ(goes > 12, room < kRoom) << goes;
  }
}

TEST(EditHeights, FailuresChangeNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Edit raise;
  raise.tool = EditTool::extrude;
  raise.place = {7, 5, 6};
  raise.radius = 4;
  for (const std::uint32_t room : {40u, 100u}) {
    LoadedWorld live(rough_world(2, 2).file(), room);
    const std::vector<std::byte> before = live.save();
    EditChange change;
    const Status status = edit_heights(live.world, raise, nullptr, change);
    ASSERT_EQ(status.code(), StatusCode::limit_reached);
    EXPECT_STREQ(status.field(), "edit_patches");
    EXPECT_GT(status.value(), room);
    EXPECT_FALSE(change.changed);
    EXPECT_TRUE(live.save() == before);
    test::expect_as_loaded(live);
    // With as much as it says it does.
    LoadedWorld enough(rough_world(2, 2).file(), static_cast<std::uint32_t>(status.value()));
    EXPECT_TRUE(edit_heights(enough.world, raise, nullptr, change).ok());
    EXPECT_TRUE(change.changed);
  }
  LoadedWorld live(rough_world(2, 2).file(), kRoom);
  const std::vector<std::byte> before = live.save();
  const struct {
    const char* field;
    void (*spoil)(Edit& edit, double nan);
  } spoilt[] = {
      {"place", [](Edit& e, double n) { e.place.y = n; }},
      {"to", [](Edit& e, double n) { e.to.x = n; }},
      {"half_m",
       [](Edit& e, double) {
         e.shape = BrushShape::box;
         e.half.z = 0;
       }},
      {"radius_m", [](Edit& e, double n) { e.radius = n; }},
      {"radius_m", [](Edit& e, double) { e.radius = 0; }},
      {"strength_m", [](Edit& e, double n) { e.strength = n; }},
      {"strength_m", [](Edit& e, double) { e.strength = 1e300; }},
      {"amount", [](Edit& e, double) { e.amount = 1.01; }},
      {"hardness", [](Edit& e, double n) { e.hardness = n; }},
      {"shape", [](Edit& e, double) { e.shape = BrushShape::voxel; }},
      {"wave_m",
       [](Edit& e, double) {
         e.tool = EditTool::noise;
         e.wave = 0;
       }},
      {"up",
       [](Edit& e, double) {
         e.tool = EditTool::flatten;
         e.up = glm::dvec3(0);
       }},
      {"up",
       [](Edit& e, double n) {
         e.tool = EditTool::flatten;
         e.up.z = n;
       }},
  };
  for (const auto& [field, spoil] : spoilt) {
    Edit edit = raise;
    spoil(edit, nan);
    EditChange change;
    const Status status = edit_heights(live.world, edit, nullptr, change);
    ASSERT_EQ(status.code(), StatusCode::invalid_argument) << field;
    EXPECT_STREQ(status.field(), field);
  }
  EXPECT_TRUE(live.save() == before);
  // Nothing is there.
  raise.place.y = 200;
  EditChange change;
  ASSERT_TRUE(edit_heights(live.world, raise, nullptr, change).ok());
  EXPECT_FALSE(change.changed);
  EXPECT_TRUE(live.save() == before);
}

}  // namespace
}  // namespace karst::core
