// SPDX-License-Identifier: MIT
// Heights of a ground and of a region in it, edited as one through the public headers: no step where they
// meet, taken back to the bit, saved as they are, and nothing that is stated creeps.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <tuple>
#include <vector>

#include "terrain/patch/displacement.h"
#include "tests/library/edit/saved_ground.h"
#include "tests/support/test_world.h"

namespace karst {
namespace {

using test::FileGround;

// Nodes of size 0 are two voxels wide; a voxel is a metre.
constexpr glm::ivec3 kExtent{25, 22, 21};
constexpr int kFirst[2] = {9, 7};
constexpr int kWide = 141, kDeep = 121;
constexpr double kUnits = double{core::kStepsPerVoxel} / core::kVertexStep;

// From the region's corner, voxels.
double ground_height(double x, double z) {
  return 10 + 2.6 * std::sin(0.3 * x) + 1.2 * std::cos(0.25 * z + 0.1 * x);
}

std::vector<std::byte> make_file() {
  test::TestWorld voxels(
      kExtent, [](glm::ivec3 v) { return v.y + 0.5 < ground_height(v.x + 0.5, v.z + 0.5); }, true);
  // Patches lie where the ground does.
  voxels.set_heights(
      3, [](glm::dvec3 at) { return (ground_height(at.x, at.z) - at.y) * core::kStepsPerVoxel * 0.9; });
  const double reach = core::kStepsPerVoxel * glm::length(glm::dvec3(kExtent));
  const test::MemoryGround ground(
      kWide, kDeep, 4096, 4096,
      [](std::int64_t i, std::int64_t k) {
        const double x = 0.5 + 0.5 * double(i) - 2 * kFirst[0], z = 0.5 + 0.5 * double(k) - 2 * kFirst[1];
        return static_cast<std::int32_t>(ground_height(x, z) * kUnits);
      },
      std::vector<test::MemoryRegion>{
          {kExtent.x, kExtent.z, kFirst[0], kFirst[1], {2.0 * core::kStepsPerVoxel, reach}, kExtent.y, 0}});
  return test::ground_file(ground, voxels);
}

const std::vector<std::byte>& region_file() {
  static const std::vector<std::byte> file = make_file();
  return file;
}

class Live {
 public:
  explicit Live(std::vector<std::byte> file, std::uint32_t patches = 3'000, std::uint32_t tiles = 300)
      : host(needs(patches, tiles), {.axes = Axes::east_up_south}, std::move(file)) {
    EXPECT_TRUE(host.world->take_editor(editor).ok());
  }
  ~Live() { host.world->release(editor); }
  core::WorldObject& object() { return static_cast<core::WorldObject&>(*host.world); }
  core::World& terrain() { return object().terrain.world; }
  Status try_apply(const Edit& edit, EditResult& result) { return editor->apply(edit, result); }
  EditResult apply(const Edit& edit) {
    EditResult result;
    const Status status = editor->apply(edit, result);
    EXPECT_TRUE(status.ok()) << status.what() << " " << status.field() << " " << status.value();
    return result;
  }
  void undo() {
    EditResult result;
    EXPECT_TRUE(editor->undo(result).ok());
    EXPECT_TRUE(result.changed);
  }
  void redo() {
    EditResult result;
    EXPECT_TRUE(editor->redo(result).ok());
    EXPECT_TRUE(result.changed);
  }
  // Places of the region's corner and of the metre.
  Vec3 at(double x, double y, double z) { return host.world->from_world({x, y, z}); }

  test::HostWorld host;
  Editor* editor = nullptr;

 private:
  static Needs needs(std::uint32_t patches, std::uint32_t tiles) {
    Needs needs;
    needs.queries = 1;
    needs.edit_patches = patches;
    needs.edit_tiles = tiles;
    needs.undo_bytes = 8 << 20;
    needs.shadow_maps = 0;
    return needs;
  }
};

Edit dab(Live& live, double x, double z, EditTool tool = EditTool::extrude, double radius = 4,
         double strength = 1.5) {
  Edit edit;
  edit.tool = tool;
  edit.shape = BrushShape::cylinder;
  edit.place = live.at(x, 10, z);
  edit.radius_m = radius;
  edit.strength_m = strength;
  edit.wave_m = 12;
  edit.seed = 3;
  return edit;
}

// Of the ground's samples at the region's border, voxels from its corner: by place along the sides.
struct Rim {
  struct Point {
    double x, z, ground, region;
  };
  std::vector<Point> points;

  explicit Rim(Live& live) {
    core::World& world = live.terrain();
    const core::WorldPart& part = world.parts()[0];
    const int level = world.info().level;
    std::vector<glm::ivec3> places(static_cast<std::size_t>(core::patch_vertices(level)));
    for (const core::RegionRim::Edge& edge : part.rim->edges()) {
      core::displaced_positions(part.surface, world.heights(), level, edge.edge.patch(), places);
      const glm::dvec3 origin(core::patch_origin(part.surface.volume_of(edge.edge.patch())));
      const core::GridLine line = core::GridLine::along_edge(edge.edge.edge(), 0, level, false);
      for (int t = 0; t <= core::patch_cells(level); ++t) {
        const std::size_t v = static_cast<std::size_t>((line.j0 + t * line.dj) * core::patch_side(level) +
                                                       line.i0 + t * line.di);
        const glm::dvec3 place = (origin + glm::dvec3(places[v])) / double{core::kStepsPerVoxel};
        // In a side.
        const bool side =
            place.x == 0.5 || place.z == 0.5 || place.x == kExtent.x - 0.5 || place.z == kExtent.z - 0.5;
        EXPECT_TRUE(side) << place.x << " " << place.z;
        points.push_back({place.x, place.z, height(live, place.x, place.z), place.y});
      }
    }
  }
  // Of the ground beside, along a row of samples.
  static double height(Live& live, double x, double z) {
    const double fi = 2 * (x - 0.5) + 4 * kFirst[0], fk = 2 * (z - 0.5) + 4 * kFirst[1];
    const auto i = static_cast<std::int64_t>(std::floor(fi)), k = static_cast<std::int64_t>(std::floor(fk));
    const double u = fi - double(i), v = fk - double(k);
    const auto h = [&](std::int64_t a, std::int64_t b) {
      std::int32_t out = 0;
      EXPECT_TRUE(live.object().ground_edits->height(a, b, out).ok());
      return out / kUnits;
    };
    return (1 - u) * (1 - v) * h(i, k) + (u > 0 ? u * (1 - v) * h(i + 1, k) : 0) +
           (v > 0 ? v * (1 - u) * h(i, k + 1) : 0) + (u > 0 && v > 0 ? u * v * h(i + 1, k + 1) : 0);
  }
  double most_apart() const {
    double most = 0;
    for (const Point& p : points) most = std::max(most, std::abs(p.ground - p.region));
    return most;
  }
};

using Stated = std::vector<std::uint16_t>;
Stated stated_by(const std::vector<std::byte>& file) {
  Stated all;
  FileGround(file).for_each([&](core::NodeKey, const core::TilePlace&, const core::Tile& tile) {
    for (const core::NodeMeasure& node : tile.nodes)
      all.insert(all.end(), std::begin(node.thresholds), std::end(node.thresholds));
  });
  return all;
}
std::uint32_t most_above(const Stated& a, const Stated& b) {
  EXPECT_EQ(a.size(), b.size());
  std::uint32_t above = 0;
  for (std::size_t n = 0; n < std::min(a.size(), b.size()); ++n) above += a[n] > b[n];
  return above;
}

// A dab over a side lifts both alike: by what the ground beside rises the rim does.
TEST(RegionHeights, ADabOverTheBorderLeavesNoStep) {
  for (const EditTool tool : {EditTool::extrude, EditTool::noise, EditTool::level, EditTool::flatten}) {
    Live live(region_file());
    const Rim before(live);
    EXPECT_LT(before.most_apart(), 0.5);
    // Over a side, and over a corner.
    for (const auto& [x, z] : {std::pair{0.5, 10.0}, std::pair{24.5, 20.5}}) {
      const EditResult result = live.apply(dab(live, x, z, tool, 10));
      EXPECT_TRUE(result.changed);
      EXPECT_GT(result.patches, 0u);
      EXPECT_GT(result.nodes + result.patches, 5u);
    }
    const Rim after(live);
    ASSERT_EQ(after.points.size(), before.points.size());
    double moved = 0;
    for (std::size_t n = 0; n < after.points.size(); ++n)
      moved = std::max(moved, std::abs(after.points[n].region - before.points[n].region));
    std::printf("tool %d: moved by %.2f, apart by %.3f, before by %.3f\n", static_cast<int>(tool), moved,
                after.most_apart(), before.most_apart());
    EXPECT_GT(moved, tool == EditTool::noise ? 0.4 : 0.8);
    EXPECT_LT(after.most_apart(), before.most_apart() + 0.1);
  }
}

TEST(RegionHeights, AreTakenBackAndSavedToTheBit) {
  Live live(region_file());
  test::Random random{11};
  std::vector<std::vector<std::byte>> states = {test::saved_by(*live.editor)};
  constexpr EditTool kTools[] = {EditTool::extrude, EditTool::smooth, EditTool::noise,
                                 EditTool::flatten, EditTool::level,  EditTool::clear};
  while (states.size() < 30) {
    Edit edit = dab(live, 28 * random.unit() - 2, 24 * random.unit() - 2, kTools[random.below(6)],
                    1 + 4 * random.unit(), 2 * random.unit() - 1);
    edit.amount = random.unit();
    edit.up = {0.4 * random.unit() - 0.2, 1, 0.2};
    if (edit.tool == EditTool::clear) edit.shape = BrushShape::sphere;
    EditResult result;
    const Status status = live.try_apply(edit, result);
    if (!status.ok()) {
      // Voxels beside the region.
      ASSERT_STREQ(status.field(), "place") << status.what();
      continue;
    }
    if (!result.changed) continue;
    EXPECT_TRUE(result.can_undo);
    states.push_back(test::saved_by(*live.editor));
    ASSERT_TRUE(test::saved_by(*live.editor) == states.back()) << "saved twice";
    if (states.size() % 6 != 0) continue;
    Live again(states.back());
    ASSERT_TRUE(test::saved_by(*again.editor) == states.back()) << "loaded and saved";
    const core::GroundRegion &own = live.object().terrain.ground.info().region_list[0],
                             &other = again.object().terrain.ground.info().region_list[0];
    EXPECT_EQ(own.belt_low, other.belt_low);
    EXPECT_EQ(own.belt_high, other.belt_high);
    EXPECT_EQ(live.terrain().ground().region_list[0].belt_high, own.belt_high);
  }
  for (std::size_t n = states.size() - 1; n-- > 0;) {
    live.undo();
    if (n % 4 == 0) {
      ASSERT_TRUE(test::saved_by(*live.editor) == states[n]) << n;
    }
  }
  EXPECT_TRUE(test::saved_by(*live.editor) == region_file());
  for (std::size_t n = 1; n < states.size(); ++n) {
    live.redo();
    if (n % 4 == 1) {
      ASSERT_TRUE(test::saved_by(*live.editor) == states[n]) << n;
    }
  }
}

// Edit, undo, save, load: 50 times the file as it was. Edit and save, with an edit that does the contrary:
// what is stated is the same from the second time on.
TEST(RegionHeights, WhatIsStatedDoesNotCreep) {
  std::vector<std::byte> file = region_file();
  const Stated first = stated_by(file);
  {
    Live live(file);
    for (int n = 0; n < 50; ++n) {
      Edit dig = dab(live, 12, 10, EditTool::clear, 4);
      dig.shape = BrushShape::sphere;
      live.apply(dig);
      live.apply(dab(live, 12 + n % 5, 10));
      const Stated edited = stated_by(test::saved_by(*live.editor));
      EXPECT_GT(most_above(edited, first), 0u);
      live.undo();
      live.undo();
      ASSERT_TRUE(test::saved_by(*live.editor) == file) << n;
    }
  }
  Stated last;
  for (int n = 0; n < 50; ++n) {
    Live live(file);
    // Rock in the air above the ground, and air again.
    Edit fill = dab(live, 12, 10, EditTool::fill, 2.5);
    fill.shape = BrushShape::sphere;
    fill.place = live.at(12, 16, 10);
    live.apply(fill);
    fill.tool = EditTool::clear;
    live.apply(fill);
    file = test::saved_by(*live.editor);
    const Stated now = stated_by(file);
    if (n > 0) {
      ASSERT_EQ(most_above(now, last), 0u) << n;
    }
    last = now;
  }
}

// Where there is no room nothing has changed.
TEST(RegionHeights, WhatDoesNotFitIsTold) {
  const auto refused = [](std::uint32_t patches, std::uint32_t tiles, const char* field) {
    Live live(region_file(), patches, tiles);
    const std::vector<std::byte> before = test::saved_by(*live.editor);
    EditResult result;
    const Status status = live.try_apply(dab(live, 0.5, 10, EditTool::extrude, 6), result);
    EXPECT_EQ(status.code(), StatusCode::limit_reached) << status.what();
    EXPECT_STREQ(status.field(), field);
    EXPECT_FALSE(result.changed);
    EXPECT_EQ(live.editor->undo_state().undo_steps, 0u);
    EXPECT_TRUE(test::saved_by(*live.editor) == before);
  };
  refused(8, 300, "edit_patches");
  refused(0, 300, "edit_patches");
  refused(3'000, 2, "edit_tiles");
  refused(3'000, 0, "edit_tiles");
}

}  // namespace
}  // namespace karst
