// SPDX-License-Identifier: MIT
// Frustum and box hierarchy against brute force: nothing that a GPU would draw is lost, and little else is
// kept.
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>
#include <glm/vector_relational.hpp>

#include "terrain/cull/bounds_tree.h"
#include "terrain/draw/draw_list.h"
#include "terrain/view/camera.h"
#include "terrain/view/frustum.h"
#include "tests/support/culled_view.h"
#include "tests/support/grid_surface.h"
#include "tests/support/tree_memory.h"

namespace karst::core {
namespace {

double fraction(TestRandom& random) {
  return static_cast<double>(random.next() >> 11) * 0x1p-53;
}

Camera random_camera(TestRandom& random, double reach) {
  CameraSettings s;
  const auto place = [&] { return reach * (2.0 * fraction(random) - 1.0) + 20.0; };
  s.position = {place(), 0.3 * place(), place()};
  s.yaw_deg = 360.0 * fraction(random);
  s.pitch_deg = 180.0 * fraction(random) - 90.0;
  s.fov_y_deg = 2.0 + 150.0 * fraction(random);
  s.aspect = 0.3 + 2.0 * fraction(random);
  s.near_voxels = std::pow(10.0, -3.0 + 3.0 * fraction(random));
  s.far_voxels = s.near_voxels + reach * fraction(random);
  Camera camera;
  EXPECT_TRUE(make_camera(s, camera).ok());
  return camera;
}

// Whether the GPU puts the point inside the view: positions relative to the camera's voxel in integers,
// everything after that in float, as the vertex shader does it.
bool gpu_sees(const glm::mat4& clip_from_lattice, const Camera& camera, glm::ivec3 origin_voxel,
              glm::ivec3 q) {
  const glm::vec3 offset = glm::vec3(origin_voxel - camera.voxel) * static_cast<float>(kStepsPerVoxel);
  const glm::vec4 clip = clip_from_lattice * glm::vec4(offset + glm::vec3(q), 1.0f);
  return std::abs(clip.x) <= clip.w && std::abs(clip.y) <= clip.w && std::abs(clip.z) <= clip.w;
}

// How far the box lies outside the view's most separating plane, in steps; negative where none separates it.
// At the far plane it is divided by far / near, which is how much less exact the GPU is there (frustum.cpp).
double separation(const Camera& camera, const LatticeBox& box) {
  const glm::dmat3 axes = world_from_view(camera);
  const glm::dvec3 eye = eye_lattice(camera);
  const glm::dvec3 x = axes[0] * camera.clip_from_view[0][0];
  const glm::dvec3 y = axes[1] * camera.clip_from_view[1][1];
  const double steps = kStepsPerVoxel;
  const std::array<std::pair<glm::dvec3, double>, 6> planes = {{{-axes[2], -camera.near_voxels * steps},
                                                                {axes[2], camera.far_voxels * steps},
                                                                {glm::normalize(x - axes[2]), 0.0},
                                                                {glm::normalize(-x - axes[2]), 0.0},
                                                                {glm::normalize(y - axes[2]), 0.0},
                                                                {glm::normalize(-y - axes[2]), 0.0}}};
  double most = -1e30;
  for (const auto& [inward, offset] : planes) {
    double inmost = -1e30;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 p{corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                         corner & 4 ? box.max.z : box.min.z};
      inmost = std::max(inmost, glm::dot(inward, p - eye) + offset);
    }
    const bool is_far = &inward == &planes[1].first;
    most =
        std::max(most, is_far && inmost < 0.0 ? -inmost * camera.near_voxels / camera.far_voxels : -inmost);
  }
  return most;
}

class CullPatches {
 public:
  explicit CullPatches(const GridSurface& grid)
      : grid_(grid),
        culled_(grid.surface(), grid.bounds),
        levels_(grid.patches.size(), 1),
        scratch_(grid.patches.size()),
        items_(grid.patches.size()) {}

  std::vector<bool> visible(const Camera& camera) {
    const Frustum frustum = make_frustum(camera);
    BuildDrawList stage;
    stage.boxes = culled_.boxes();
    stage.culled = culled_.find(&frustum, grid_.tree);
    stage.camera = &camera;
    stage.surface = grid_.surface();
    stage.levels = levels_;
    stage.scratch = scratch_;
    stage.items = items_;
    EXPECT_TRUE(stage.validate().ok()) << stage.validate().field();
    BuildDrawList::Result result;
    EXPECT_TRUE(stage.run(result).ok());
    EXPECT_EQ(result.drawn + result.culled_frustum, grid_.patches.size());
    std::vector<bool> seen(grid_.patches.size(), false);
    for (std::uint32_t n = 0; n < result.drawn; ++n) {
      EXPECT_FALSE(seen[items_[n].patch]) << "a patch is listed twice";
      seen[items_[n].patch] = true;
    }
    return seen;
  }

 private:
  const GridSurface& grid_;
  test::CulledView culled_;
  std::vector<std::uint8_t> levels_;
  std::vector<std::uint32_t> scratch_;
  std::vector<DrawItem> items_;
};

// What is in view is what classify() says of each box, and neighbours of what is in view are there.
TEST(CullView, AgreesWithEachBox) {
  TestRandom random(12);
  for (int round = 0; round < 60; ++round) {
    const int side = round % 4 == 0 ? 90 : 1 + round;
    const GridSurface grid = make_grid_surface(side, side, 0.2 + 3.5 * fraction(random), random.next());
    test::CulledView culled(grid.surface(), grid.bounds);
    const auto patches = static_cast<std::uint32_t>(grid.patches.size());
    for (int view = 0; view < 20; ++view) {
      CameraSettings settings;
      for (int axis = 0; axis < 3; ++axis) settings.position[axis] = side * (1.5 * fraction(random) - 0.25);
      settings.yaw_deg = 360 * fraction(random);
      settings.pitch_deg = 180 * fraction(random) - 90;
      settings.fov_y_deg = 10 + 100 * fraction(random);
      settings.far_voxels = 5 + side * fraction(random);
      Camera camera;
      ASSERT_TRUE(make_camera(settings, camera).ok());
      const Frustum frustum = make_frustum(camera);
      std::vector<int> state(patches, -1);  // -1: not among them, 1: in view
      std::uint32_t last = 0;
      for (const CulledEight& eight : culled.find(&frustum, grid.tree)) {
        EXPECT_TRUE(state[8 * eight.n] == -1 && eight.n >= last) << "not in order";
        EXPECT_EQ(eight.hidden, 0);
        last = eight.n;
        for (std::uint32_t p = 0; p < 8; ++p) {
          const PatchId id = 8 * eight.n + p;
          const int in_view = eight.in_view >> p & 1;
          EXPECT_TRUE(id < patches || in_view == 0);
          if (id < patches) state[id] = in_view;
        }
      }
      for (PatchId id = 0; id < patches; ++id) {
        const LatticeBox box = patch_box(grid.surface(), grid.bounds, id);
        ASSERT_EQ(state[id] == 1, classify(frustum, box, kAllPlanes) != kOutside) << id;
        for (const PatchEdge edge : grid.patches[id].neighbour) {
          // Boxes of a made-up surface need not touch those beside them.
          if (state[id] != 1 || !edge.exists()) continue;
          const LatticeBox other = patch_box(grid.surface(), grid.bounds, edge.patch());
          const bool touch = glm::all(glm::lessThanEqual(other.min, box.max)) &&
                             glm::all(glm::lessThanEqual(box.min, other.max));
          EXPECT_TRUE(!touch || state[edge.patch()] >= 0);
        }
      }
      EXPECT_EQ(culled.find(nullptr, grid.tree).size(), PatchBoxes::count_for(patches));
    }
  }
}

TEST(Cull, LosesNothingThatTheGpuDraws) {
  TestRandom random(11);
  int points_seen = 0;
  for (int round = 0; round < 40; ++round) {
    const int side = round % 4 == 0 ? 120 : 20;
    const GridSurface grid = make_grid_surface(side, side - 3, 0.2 + 3.5 * fraction(random), random.next());
    ASSERT_FALSE(grid.patches.empty());
    CullPatches cull(grid);
    for (int view = 0; view < 20; ++view) {
      const Camera camera = random_camera(random, view == 0 ? 1e6 : view < 5 ? 300.0 : 60.0);
      const glm::mat4 matrix = clip_from_lattice(camera);
      const std::vector<bool> listed = cull.visible(camera);
      for (PatchId id = 0; id < grid.patches.size(); ++id) {
        const Volume& volume = grid.volumes[grid.patches[id].volume];
        const PatchBounds& b = grid.bounds[id];
        for (int point = 0; point < 12; ++point) {
          glm::ivec3 q;
          for (int axis = 0; axis < 3; ++axis) {
            q[axis] = point < 8 ? (point >> axis & 1 ? b.max[axis] : b.min[axis])
                                : random.range(b.min[axis], b.max[axis]);
          }
          const glm::ivec3 corner{volume.corner[0], volume.corner[1], volume.corner[2]};
          if (!gpu_sees(matrix, camera, corner, q)) continue;
          ++points_seen;
          ASSERT_TRUE(listed[id]) << "patch " << id << " is lost";
        }
      }
    }
  }
  EXPECT_GT(points_seen, 100'000);
}

TEST(Cull, KeepsOnlyWhatNoPlaneSeparates) {
  TestRandom random(12);
  int culled = 0;
  for (int round = 0; round < 10; ++round) {
    const GridSurface grid = make_grid_surface(40, 40, 1.0, random.next());
    CullPatches cull(grid);
    for (int view = 0; view < 30; ++view) {
      const Camera camera = random_camera(random, 60.0);
      const std::vector<bool> listed = cull.visible(camera);
      for (PatchId id = 0; id < grid.patches.size(); ++id) {
        const double gap = separation(camera, patch_box(grid.surface(), grid.bounds, id));
        // 32 steps: the margin that frustum.cpp states, and some.
        if (gap > 32.0) {
          ++culled;
          ASSERT_FALSE(listed[id]) << "separated by " << gap << " steps, and drawn";
        } else if (gap < 0.0) {
          ASSERT_TRUE(listed[id]) << "not separated, and culled";
        }
      }
    }
  }
  EXPECT_GT(culled, 100'000);
}

TEST(Cull, MaskNamesThePlanesThatABoxCrosses) {
  CameraSettings s;
  s.fov_y_deg = 90.0;
  s.aspect = 1.0;
  s.near_voxels = 1.0;
  s.far_voxels = 100.0;
  Camera camera;
  ASSERT_TRUE(make_camera(s, camera).ok());
  const Frustum frustum = make_frustum(camera);
  const auto box = [](glm::ivec3 low, glm::ivec3 high) {
    return LatticeBox{low * kStepsPerVoxel, high * kStepsPerVoxel};
  };
  const auto all = [&](const LatticeBox& b) { return classify(frustum, b, kAllPlanes); };
  EXPECT_EQ(all(box({-2, -2, -20}, {2, 2, -10})), 0u);
  EXPECT_EQ(all(box({-2, -2, -20}, {2, 2, 10})) & 1u, 1u);       // near
  EXPECT_EQ(all(box({-60, -2, -50}, {2, 2, -40})), 1u << 1);     // left
  EXPECT_EQ(all(box({-2, -2, -50}, {60, 2, -40})), 1u << 2);     // right
  EXPECT_EQ(all(box({-2, -60, -50}, {2, 2, -40})), 1u << 3);     // bottom
  EXPECT_EQ(all(box({-2, -2, -50}, {2, 60, -40})), 1u << 4);     // top
  EXPECT_EQ(all(box({-2, -2, -120}, {2, 2, -50})), 1u << 5);     // far
  EXPECT_EQ(all(box({-2, -2, 5}, {2, 2, 10})), kOutside);        // behind
  EXPECT_EQ(all(box({-2, -2, -200}, {2, 2, -101})), kOutside);   // beyond far
  EXPECT_EQ(all(box({-90, -2, -50}, {-70, 2, -40})), kOutside);  // left
  EXPECT_EQ(classify(frustum, box({-90, -2, -50}, {-70, 2, -40}), 0), 0u)
      << "tested a plane that is not in the mask";
}

TEST(BoundsTree, HoldsEveryPatchAndFollowsUpdates) {
  TestRandom random(13);
  for (const int width : {1, 2, 8, 9, 33, 70}) {
    GridSurface grid = make_grid_surface(width, 7, 1.0, random.next());
    const auto check = [&] {
      for (int row = 0; row < grid.tree.rows(); ++row) {
        std::uint32_t covered = 0;
        for (std::uint32_t n = 0; n < grid.tree.nodes(row); ++n) {
          LatticeBox tight{glm::ivec3(1 << 30), glm::ivec3(-(1 << 30))};
          ASSERT_EQ(grid.tree.first_patch(row, n), covered);
          for (std::uint32_t k = 0; k < grid.tree.patch_count(row, n); ++k, ++covered) {
            const LatticeBox b = patch_box(grid.surface(), grid.bounds, covered);
            tight = {glm::min(tight.min, b.min), glm::max(tight.max, b.max)};
          }
          ASSERT_EQ(grid.tree.node(row, n).min, tight.min);
          ASSERT_EQ(grid.tree.node(row, n).max, tight.max);
        }
        ASSERT_EQ(covered, grid.patches.size());
      }
      ASSERT_EQ(grid.tree.nodes(grid.tree.rows() - 1), 1u);
    };
    check();
    for (int round = 0; round < 20; ++round) {
      const auto patches = static_cast<std::uint32_t>(grid.patches.size());
      const std::uint32_t first = random.below(patches);
      const std::uint32_t count = random.below(patches - first + 1);
      for (std::uint32_t id = first; id < first + count; ++id) {
        grid.bounds[id].max[0] = static_cast<std::int16_t>(random.range(grid.bounds[id].min[0], 30'000));
      }
      ASSERT_TRUE(grid.tree.update(grid.surface(), grid.bounds, first, count).ok());
      check();
    }
  }
}

TEST(BoundsTree, RefusesWhatDoesNotFit) {
  GridSurface grid = make_grid_surface(20, 20, 1.0, 1);
  const std::span<const PatchBounds> bounds = grid.bounds;
  std::vector<LatticeBox> storage(BoundsTree::node_count(400) - 1);
  BoundsTree tree;
  EXPECT_TRUE(tree.build({}, {}).ok());
  EXPECT_EQ(tree.rows(), 0);
  tree.create(storage);
  EXPECT_STREQ(tree.build(grid.surface(), bounds.first(399)).field(), "bounds");
  const Status full = tree.build(grid.surface(), bounds);
  EXPECT_EQ(full.code(), StatusCode::limit_reached);
  EXPECT_STREQ(full.field(), "max_patches");
  EXPECT_EQ(full.value(), 400u);
  EXPECT_EQ(tree.patches(), 0u);
  EXPECT_STREQ(tree.update(grid.surface(), bounds, 0, 1).field(), "surface");
  EXPECT_STREQ(grid.tree.update(grid.surface(), bounds, 399, 2).field(), "count");
  EXPECT_STREQ(grid.tree.update(grid.surface(), bounds, 401, 0).field(), "count");
  EXPECT_TRUE(grid.tree.update(grid.surface(), bounds, 400, 0).ok());
  EXPECT_EQ(BoundsTree::node_count(0), 0u);
  EXPECT_EQ(BoundsTree::node_count(1), 1u);
  EXPECT_EQ(BoundsTree::node_count(8), 1u);
  EXPECT_EQ(BoundsTree::node_count(9), 3u);
  EXPECT_EQ(BoundsTree::node_count(65), 9u + 2u + 1u);
}

}  // namespace
}  // namespace karst::core
