// SPDX-License-Identifier: MIT
// Levels of detail: K's distances, and neighbours at most one level apart by raising only, against brute
// force.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "terrain/lod/level_lanes.h"
#include "terrain/lod/select_lod.h"
#include "terrain/view/camera.h"
#include "tests/support/grid_surface.h"
#include "tests/support/tree_memory.h"

namespace karst::core {
namespace {

double fraction(TestRandom& random) {
  return static_cast<double>(random.next() >> 11) * 0x1p-53;
}

Camera camera_at(glm::dvec3 position) {
  CameraSettings s;
  s.position = position;
  Camera camera;
  EXPECT_TRUE(make_camera(s, camera).ok());
  return camera;
}

SelectLod stage_over(const GridSurface& grid, const Camera& camera, std::vector<std::uint8_t>& levels) {
  levels.assign(grid.patches.size(), 77);
  SelectLod stage;
  stage.settings.mode = LodMode::distance;
  stage.camera = &camera;
  stage.surface = grid.surface();
  stage.bounds = grid.bounds;
  stage.tree = &grid.tree;
  stage.levels = levels;
  return stage;
}

// Straight from the definition, patch by patch, in double. near_threshold tells where float may decide
// otherwise.
std::vector<std::uint8_t> levels_by_distance(const SelectLod& stage, bool& near_threshold) {
  std::vector<std::uint8_t> result;
  const glm::dvec3 eye = eye_lattice(*stage.camera);
  near_threshold = false;
  for (PatchId id = 0; id < stage.surface.patches.size(); ++id) {
    const LatticeBox box = patch_box(stage.surface, stage.bounds, id);
    double squared = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double d = std::max({box.min[axis] - eye[axis], eye[axis] - box.max[axis], 0.0});
      squared += d * d;
    }
    const double voxels = std::sqrt(squared) / kStepsPerVoxel;
    const int top = std::min(stage.settings.max_level, stage.settings.resident_level);
    int level = 1;
    for (int m = 2; m <= top; ++m) {
      const double threshold = stage.settings.distance_voxels / std::pow(2.0, m - 2);
      if (voxels < threshold) level = m;
      if (std::abs(voxels - threshold) < 1e-5 * threshold) near_threshold = true;
    }
    result.push_back(static_cast<std::uint8_t>(level));
  }
  return result;
}

// Raises any patch that is two levels below a neighbour, until there is none.
std::uint32_t raise_until_legal(const Surface& surface, std::vector<std::uint8_t>& levels) {
  const std::vector<std::uint8_t> before = levels;
  for (bool changed = true; changed;) {
    changed = false;
    for (const Patch& patch : surface.patches) {
      const std::uint8_t own = levels[static_cast<std::size_t>(&patch - surface.patches.data())];
      for (const PatchEdge edge : patch.neighbour) {
        if (!edge.exists() || levels[edge.patch()] + 1 >= own) continue;
        levels[edge.patch()] = static_cast<std::uint8_t>(own - 1);
        changed = true;
      }
    }
  }
  std::uint32_t raised = 0;
  for (std::size_t id = 0; id < levels.size(); ++id) raised += levels[id] != before[id] ? 1u : 0u;
  return raised;
}

TEST(SelectLod, FollowsDistanceInPowersOfTwo) {
  // Flat boxes of no size, the eye above the first column's patch: a patch's distance is how far along x it
  // is.
  GridSurface grid = make_grid_surface(200, 1, 0.0, 1);
  for (Volume& volume : grid.volumes) volume.corner[1] = 10;
  ASSERT_TRUE(grid.tree.build(grid.surface(), grid.bounds).ok());
  const Camera camera = camera_at({1.0, 10.0, 1.0});
  std::vector<std::uint8_t> levels;
  SelectLod stage = stage_over(grid, camera, levels);
  stage.settings = {.mode = LodMode::distance, .max_level = 6, .resident_level = 6, .distance_voxels = 128.0};
  ASSERT_TRUE(stage.validate().ok());
  EXPECT_EQ(stage.run().raised, 0u);
  const auto level_at = [&](int x) {
    for (std::size_t id = 0; id < levels.size(); ++id) {
      if (grid.volumes[id].corner[0] == x + 1) return static_cast<int>(levels[id]);
    }
    return 0;
  };
  const int expected[][2] = {{0, 6},  {7, 6},  {8, 5},  {15, 5},  {16, 4},
                             {32, 3}, {63, 3}, {64, 2}, {127, 2}, {128, 1}};
  for (const auto& [x, level] : expected) EXPECT_EQ(level_at(x), level) << x;

  stage.settings.max_level = 3;
  stage.run();
  EXPECT_EQ(level_at(0), 3);
  stage.settings = {.mode = LodMode::distance, .max_level = 6, .resident_level = 2, .distance_voxels = 128.0};
  stage.run();
  EXPECT_EQ(level_at(0), 2);
  stage.settings = {.mode = LodMode::distance, .max_level = 6, .resident_level = 6, .distance_voxels = 0.0};
  stage.run();
  EXPECT_EQ(*std::max_element(levels.begin(), levels.end()), 1);
  stage.settings = {.mode = LodMode::full, .max_level = 4, .resident_level = 6};
  stage.run();
  EXPECT_EQ(*std::min_element(levels.begin(), levels.end()), 4);
  EXPECT_EQ(*std::max_element(levels.begin(), levels.end()), 4);
}

TEST(SelectLod, AgreesWithBruteForce) {
  TestRandom random(21);
  int compared = 0;
  std::uint32_t raised = 0;
  for (int round = 0; round < 400; ++round) {
    GridSurface grid =
        make_grid_surface(random.range(1, 60), random.range(1, 60), 3.5 * fraction(random), random.next());
    // Links across the grid put patches of any distance next to each other, so that much has to be raised.
    const int links = round % 2 == 0 ? 0 : static_cast<int>(random.below(400));
    for (int n = 0; n < links; ++n) {
      const auto patches = static_cast<std::uint32_t>(grid.patches.size());
      const PatchEdge a = PatchEdge::make(random.below(patches), random.range(0, 3));
      const PatchEdge b = PatchEdge::make(random.below(patches), random.range(0, 3));
      if (a == b) continue;
      for (const PatchEdge end : {a, b}) {
        PatchEdge& old = grid.patches[end.patch()].neighbour[end.edge()];
        if (old.exists()) grid.patches[old.patch()].neighbour[old.edge()] = {};
        old = {};
      }
      grid.patches[a.patch()].neighbour[a.edge()] = b;
      grid.patches[b.patch()].neighbour[b.edge()] = a;
    }
    const double reach = round % 50 == 0 ? 1e6 : 60.0;
    const Camera camera =
        camera_at({reach * fraction(random), 30.0 * fraction(random), reach * fraction(random)});
    std::vector<std::uint8_t> levels;
    SelectLod stage = stage_over(grid, camera, levels);
    stage.settings.max_level = random.range(round % 10 == 0 ? 1 : 4, kMaxLevel);
    stage.settings.resident_level = random.range(round % 10 == 1 ? 1 : 4, kMaxLevel);
    stage.settings.distance_voxels = std::pow(10.0, 0.5 + 2.0 * fraction(random));
    ASSERT_TRUE(stage.validate().ok());
    const SelectLod::Result result = stage.run();
    bool near_threshold = false;
    std::vector<std::uint8_t> expected = levels_by_distance(stage, near_threshold);
    if (near_threshold) continue;
    ++compared;
    ASSERT_EQ(result.raised, raise_until_legal(grid.surface(), expected));
    ASSERT_EQ(levels, expected) << "round " << round;
    raised += result.raised;
    for (const Patch& patch : grid.patches) {
      const int own = levels[static_cast<std::size_t>(&patch - grid.patches.data())];
      for (const PatchEdge edge : patch.neighbour) {
        if (!edge.exists()) continue;
        ASSERT_LE(std::abs(own - levels[edge.patch()]), 1);
      }
    }
  }
  EXPECT_GT(compared, 300);
  EXPECT_GT(raised, 500u);
}

// A chain of patches in a row, all wanted at level 6: what is held makes ramps of one level a patch.
TEST(SelectLod, CapsByWhatIsHeld) {
  const GridSurface grid = make_grid_surface(16, 1, 0.0, 1);
  const Camera camera = camera_at({8.0, 10.0, 1.0});
  std::vector<std::uint8_t> levels;
  SelectLod stage = stage_over(grid, camera, levels);
  stage.settings = {.mode = LodMode::full, .max_level = 6, .resident_level = 6};
  std::vector<std::uint8_t> at_x(16), by_patch(16);
  std::vector<PatchId> cut(16);
  const auto column = [&](std::size_t id) {
    return static_cast<std::size_t>(grid.volumes[id].corner[0] - 1);
  };
  const auto run = [&](std::vector<std::uint8_t> held_at_x) {
    for (std::size_t id = 0; id < 16; ++id) by_patch[id] = held_at_x[column(id)];
    stage.resident = by_patch;
    stage.cut = cut;
    EXPECT_TRUE(stage.validate().ok());
    const SelectLod::Result result = stage.run();
    for (std::size_t id = 0; id < 16; ++id) at_x[column(id)] = levels[id];
    return result;
  };
  using Row = std::vector<std::uint8_t>;
  SelectLod::Result result = run({6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6});
  EXPECT_EQ(result.capped + result.lowered + result.missing, 0u);
  EXPECT_EQ(at_x, Row(16, 6));

  std::vector<LackingPatch> lacking(1);
  stage.lacking = lacking;
  result = run({6, 6, 6, 6, 6, 1, 6, 3, 6, 6, 0, 6, 6, 6, 5, 6});
  EXPECT_EQ(at_x, (Row{6, 5, 4, 3, 2, 1, 2, 3, 4, 5, 0, 6, 6, 6, 5, 6}));
  EXPECT_EQ(result.capped, 4u);
  EXPECT_EQ(result.missing, 1u);
  EXPECT_EQ(result.lowered, 7u);
  EXPECT_EQ(lacking[0].wanted, 6);
  EXPECT_TRUE(by_patch[lacking[0].patch] < 6);
  // Each of them once.
  ASSERT_EQ(result.cut, 11u);
  std::sort(cut.begin(), cut.begin() + result.cut);
  EXPECT_EQ(std::unique(cut.begin(), cut.begin() + result.cut), cut.begin() + result.cut);
  for (const PatchId patch : std::span(cut).first(result.cut)) EXPECT_LT(levels[patch], 6);

  // Without cuts the same ones lack, and are as they are wanted.
  stage.cuts = false;
  result = run({6, 6, 6, 6, 6, 1, 6, 3, 6, 6, 0, 6, 6, 6, 5, 6});
  EXPECT_EQ(at_x, Row(16, 6));
  EXPECT_EQ(result.capped, 4u);
  EXPECT_EQ(result.missing, 1u);
  EXPECT_EQ(result.lowered + result.cut, 0u);
}

TEST(LevelLanes, AreThoseOfTheFormulas) {
  TestRandom random(31);
  std::vector<PatchLod> lods(64);
  int levels_seen[kMaxLevel + 1] = {};
  for (int round = 0; round < 3000; ++round) {
    LodEye eye;
    const double reach = std::exp2(28 * fraction(random));
    for (int axis = 0; axis < 3; ++axis) {
      eye.eye[axis] = static_cast<float>(reach * (2 * fraction(random) - 1));
      eye.forward[axis] = static_cast<float>(2 * fraction(random) - 1);
    }
    eye.forward /= glm::length(eye.forward);
    eye.least_cos2 = round % 5 == 0 ? -kParallelDistance : static_cast<float>(fraction(random));
    for (PatchLod& lod : lods) {
      for (float& c : lod.centre) c = static_cast<float>(0x1p22 * fraction(random));
      lod.reach = static_cast<float>(0x1p16 * fraction(random));
      // Rising to the next one often enough, about as far as the eye is.
      const LodEye at{eye.eye, eye.forward, eye.least_cos2};
      const float apparent = std::max(least_apparent_distance(lod, at), 1.0f) / kThresholdUnit;
      float units = apparent * static_cast<float>(std::exp2(3 * fraction(random)));
      for (int m = 2; m <= kMaxLevel; ++m, units *= static_cast<float>(fraction(random))) {
        const float held = std::clamp(units, 0x1p-14f, 65'503.0f);
        lod.threshold[m] =
            static_cast<std::uint16_t>((std::bit_cast<std::uint32_t>(held) - (112u << 23)) >> 13);
        if (units < 0x1p-14f) lod.threshold[m] = 0;
      }
    }
    const LevelLanes lanes(eye);
    std::uint8_t levels[8] = {};
    for (std::size_t first = 0; first < lods.size(); first += 8) {
      const std::uint32_t count = first == 56 ? 1 + static_cast<std::uint32_t>(round % 8) : 8;
      lanes.run(lods.data() + first, count, levels);
      for (std::uint32_t p = 0; p < count; ++p) {
        const PatchLod& lod = lods[first + p];
        ASSERT_EQ(levels[p], level_at(lod, least_apparent_distance(lod, eye))) << round;
        ++levels_seen[levels[p]];
      }
    }
  }
  for (int level = 1; level <= kMaxLevel; ++level) EXPECT_GT(levels_seen[level], 100) << level;
}

TEST(SelectLod, RefusesOneWrongFieldAtATime) {
  const GridSurface grid = make_grid_surface(5, 5, 1.0, 3);
  const Camera camera = camera_at({0, 0, 0});
  const BoundsTree empty;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  using Break = std::function<void(SelectLod&)>;
  const std::vector<std::pair<const char*, Break>> cases = {
      {"mode", [](SelectLod& s) { s.settings.mode = static_cast<LodMode>(9); }},
      {"max_level", [](SelectLod& s) { s.settings.max_level = 0; }},
      {"max_level", [](SelectLod& s) { s.settings.max_level = kMaxLevel + 1; }},
      {"resident_level", [](SelectLod& s) { s.settings.resident_level = 0; }},
      {"resident_level", [](SelectLod& s) { s.settings.resident_level = kMaxLevel + 1; }},
      {"error_px", [](SelectLod& s) { s.settings.error_px = 0.0; }},
      {"error_px", [=](SelectLod& s) { s.settings.error_px = nan; }},
      {"error_px", [](SelectLod& s) { s.settings.error_px = 1001.0; }},
      {"distance_voxels", [](SelectLod& s) { s.settings.distance_voxels = -1.0; }},
      {"distance_voxels", [=](SelectLod& s) { s.settings.distance_voxels = nan; }},
      {"distance_voxels", [](SelectLod& s) { s.settings.distance_voxels = 1e9; }},
      {"camera", [](SelectLod& s) { s.camera = nullptr; }},
      {"bounds", [](SelectLod& s) { s.bounds = s.bounds.first(24); }},
      {"tree", [](SelectLod& s) { s.tree = nullptr; }},
      {"tree", [&](SelectLod& s) { s.tree = &empty; }},
      {"resident", [](SelectLod& s) { s.resident = s.levels.first(24); }},
      {"levels", [](SelectLod& s) { s.levels = s.levels.first(24); }},
      {"cut", [](SelectLod& s) { s.resident = s.levels; }},
  };
  for (const auto& [field, break_it] : cases) {
    std::vector<std::uint8_t> levels;
    SelectLod stage = stage_over(grid, camera, levels);
    ASSERT_TRUE(stage.validate().ok());
    break_it(stage);
    EXPECT_EQ(stage.validate().code(), StatusCode::invalid_argument) << field;
    EXPECT_STREQ(stage.validate().field(), field);
  }
}

TEST(SelectLod, ByErrorNeedsThresholdsAndErrors) {
  const GridSurface grid = make_grid_surface(5, 5, 1.0, 3);
  const Camera camera = camera_at({0, 0, 0});
  std::vector<std::uint8_t> levels;
  const std::vector<std::uint16_t> errors(25 * level_error_values(3));
  std::vector<PatchLod> lods(25);
  SelectLod good = stage_over(grid, camera, levels);
  good.settings.mode = LodMode::error;
  good.settings.error_px = 1.0;
  good.scale = make_error_scale(camera, 1280, 720, 1.0);
  good.errors = {3, errors};
  SetThresholds set{.scale = good.scale,
                    .surface = good.surface,
                    .bounds = grid.bounds,
                    .errors = good.errors,
                    .lods = lods};
  ASSERT_TRUE(set.validate().ok());
  set.run();
  good.lods = lods;
  ASSERT_TRUE(good.validate().ok());
  // Nothing is lost at level 1 where no level has an error.
  EXPECT_EQ(good.run().bound_px, 1.0f);
  EXPECT_EQ(*std::max_element(levels.begin(), levels.end()), 1);
  SelectLod bad = good;
  bad.scale = {};
  EXPECT_STREQ(bad.validate().field(), "scale");
  bad = good;
  bad.lods = bad.lods.first(24);
  EXPECT_STREQ(bad.validate().field(), "lods");
  bad = good;
  bad.errors = {};
  EXPECT_STREQ(bad.validate().field(), "errors");
  // What is not known has no bound.
  bad.settings.mode = LodMode::distance;
  ASSERT_TRUE(bad.validate().ok());
  EXPECT_EQ(bad.run().bound_px, std::numeric_limits<float>::infinity());
  bad.errors = good.errors;
  EXPECT_EQ(bad.run().bound_px, 0.0f);
}

TEST(SelectLod, EmptySurfaceIsFine) {
  const Camera camera = camera_at({0, 0, 0});
  const BoundsTree tree;
  SelectLod stage;
  stage.settings.mode = LodMode::distance;
  stage.camera = &camera;
  stage.tree = &tree;
  EXPECT_TRUE(stage.validate().ok());
  EXPECT_EQ(stage.run().raised, 0u);
}

}  // namespace
}  // namespace karst::core
