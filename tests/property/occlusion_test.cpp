// SPDX-License-Identifier: MIT
// Rock that hides, over random worlds and eyes: whatever is culled as hidden lies behind a front-facing
// triangle that is drawn, at every level and whatever else is culled. And eyes that count as outside are.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "terrain/cull/occlusion.h"
#include "terrain/draw/draw_list.h"
#include "terrain/draw/index_batches.h"
#include "terrain/measure/normal_cone.h"
#include "tests/support/any_camera.h"
#include "tests/support/culled_view.h"
#include "tests/support/morphed_surface.h"

namespace karst::core {
namespace {

using test::MorphedSurface;
using test::Random;
using test::TestWorld;

glm::dvec3 direction(Random& random) {
  for (;;) {
    const glm::dvec3 d(2 * random.unit() - 1, 2 * random.unit() - 1, 2 * random.unit() - 1);
    const double length = glm::length(d);
    if (length > 0.1 && length < 1) return d / length;
  }
}

// Halls in rock: smooth noise of a wavelength of several voxels. closed: a shell of rock or air around it,
// else caves lead out through the sides and the bottom.
TestWorld make_caves(Random& random, int level, bool closed) {
  const glm::ivec3 extent{26, 20, 26};
  const std::uint64_t seed = random.next();
  const double wavelength = 5.0 + 4.0 * random.unit();
  const double share = 0.1 + 0.25 * random.unit();
  TestWorld world(extent, [=](glm::ivec3 v) {
    if (v.y > extent.y - 3) return false;
    const bool shell = v.x < 2 || v.z < 2 || v.y < 2 || v.x >= extent.x - 2 || v.z >= extent.z - 2;
    if (closed && shell) return true;
    return test::value_noise(seed, glm::dvec3(v) / wavelength) > share - 0.5;
  });
  const double height = 2500.0 * random.unit();
  world.set_heights(level, [=](glm::dvec3 p) { return height * test::value_noise(~seed, p * 0.9); });
  return world;
}

// All triangles of a world drawn at one level, by patch.
class Drawn {
 public:
  Drawn(const MorphedSurface& world, int level) : world_(world) {
    std::vector<std::uint16_t> table(index_count(kMaxLevel));
    EXPECT_TRUE(build_index_tables(kMaxLevel, table).ok());
    IndexRange ranges[kMaxIndexRanges];
    EXPECT_EQ(index_ranges(level, 0, 0, ranges), 1);
    for (std::uint32_t n = 0; n < ranges[0].count; ++n) index_.push_back(table[ranges[0].first + n]);
  }

  std::size_t triangles() const { return index_.size() / 3; }
  glm::dvec3 corner(PatchId p, std::size_t triangle, std::size_t k) const {
    const GpuVertex& v = world_.vertices(p)[index_[3 * triangle + k]];
    return glm::dvec3(patch_origin(world_.surface().volume_of(p))) +
           glm::dvec3(v.position[0], v.position[1], v.position[2]);
  }

  // Where from + t way crosses a triangle of the patch: the least t in [low, high); front: whether it is
  // crossed from its front.
  struct Hit {
    double t;
    bool front;
  };
  std::optional<Hit> first_hit(PatchId p, glm::dvec3 from, glm::dvec3 way, double low, double high) const {
    const LatticeBox box = patch_box(world_.surface(), world_.bounds(), p);
    double enter = low;
    double leave = high;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (box.min[axis] - 1 - from[axis]) / way[axis];
      const double b = (box.max[axis] + 1 - from[axis]) / way[axis];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    std::optional<Hit> least;
    if (!(enter <= leave)) return least;
    for (std::size_t t = 0; t < triangles(); ++t) {
      const glm::dvec3 a = corner(p, t, 0);
      const glm::dvec3 ab = corner(p, t, 1) - a;
      const glm::dvec3 ac = corner(p, t, 2) - a;
      const glm::dvec3 normal = glm::cross(ab, ac);
      const double facing = -glm::dot(normal, way);
      if (facing == 0.0) continue;
      const double at = glm::dot(normal, from - a) / facing;
      if (!(at >= low && at < (least ? least->t : high))) continue;
      const glm::dvec3 m = glm::cross(from - a, way);
      const double v = glm::dot(ac, m) / facing;
      const double w = -glm::dot(ab, m) / facing;
      if (v >= 0 && w >= 0 && v + w <= 1) least = Hit{at, facing > 0};
    }
    return least;
  }

 private:
  const MorphedSurface& world_;
  std::vector<std::uint16_t> index_;
};

struct Scene {
  Scene(const TestWorld& source, int cell_log2)
      : world(source),
        octree(source.octree()),
        nodes(BoundsTree::node_count(static_cast<std::uint32_t>(world.patches()))),
        words(Occluders::word_count(source.extent(), cell_log2)),
        entries(Occlusion::entry_count(static_cast<std::uint32_t>(world.patches()))),
        culled(world.surface(), world.bounds()),
        cones(world.patches()),
        levels(world.patches(), static_cast<std::uint8_t>(world.level())),
        scratch(world.patches()),
        items(world.patches()) {
    tree.create(nodes);
    EXPECT_TRUE(tree.build(world.surface(), world.bounds()).ok());
    occluders.create(words);
    occluders.build(octree, source.extent(), world.surface(), world.bounds());
    occlusion.create(entries, static_cast<std::uint32_t>(world.patches()));
    MeasureNormalCones measure;
    measure.surface = world.surface();
    measure.heights = world.heights();
    measure.cones = cones;
    measure.run(0, static_cast<PatchId>(cones.size()));
  }
  Scene(const Scene&) = delete;

  // Whether the patch is listed, by patch.
  std::vector<bool> list(const Camera& camera, bool with_rock, BuildDrawList::Result& result) {
    const Frustum frustum = make_frustum(camera);
    // Half of the views start from what others have found.
    if (with_rock && ++views % 2 == 0) occlusion.reset();
    if (with_rock) occlusion.begin(occluders, octree, tree, world.surface(), world.bounds(), camera, 100'000);
    BuildDrawList build;
    build.boxes = culled.boxes();
    build.culled = culled.find(&frustum, tree, with_rock ? &occlusion : nullptr);
    build.camera = &camera;
    build.surface = world.surface();
    build.levels = levels;
    build.cones = cones;
    build.scratch = scratch;
    build.items = items;
    EXPECT_TRUE(build.validate().ok());
    EXPECT_TRUE(build.run(result).ok());
    EXPECT_EQ(result.drawn + result.culled_frustum + result.culled_backface + result.culled_occluded,
              world.patches());
    std::vector<bool> listed(world.patches(), false);
    for (std::uint32_t n = 0; n < result.drawn; ++n) listed[items[n].patch] = true;
    return listed;
  }

  MorphedSurface world;
  const Octree& octree;
  std::vector<LatticeBox> nodes;
  BoundsTree tree;
  std::vector<std::uint64_t> words;
  Occluders occluders;
  std::vector<std::uint16_t> entries;
  Occlusion occlusion;
  int views = 0;
  test::CulledView culled;
  std::vector<NormalCone> cones;
  std::vector<std::uint8_t> levels;
  std::vector<std::uint32_t> scratch;
  std::vector<DrawItem> items;
};

Camera any_camera(Random& random, const CameraSettings& settings, test::AnyProjection kind) {
  CameraMatrices matrices = test::any_matrices(random, kind, settings.near_voxels, 30);
  const Camera at_zero = test::camera_of(matrices);
  matrices.position = settings.position - eye_lattice(at_zero) / double{kStepsPerVoxel};
  return test::camera_of(matrices);
}

// Whatever the view: a patch that is not listed shows nothing.
TEST(Occlusion, WhatIsNotListedIsOutOfViewOrFacesAway) {
  Random random{303};
  std::size_t visible = 0;
  std::size_t back_facing = 0;
  for (int round = 0; round < 6; ++round) {
    const int level = 1 + round % 3;
    const TestWorld source = make_caves(random, level, round % 2 == 0);
    Scene scene(source, 0);
    const Drawn drawn(scene.world, level);
    for (int n = 0; n < 60; ++n) {
      CameraSettings settings;
      settings.near_voxels = std::exp2(-5.0 + 3.0 * random.unit());
      settings.position = glm::dvec3(26, 20, 26) * glm::dvec3(random.unit(), random.unit(), random.unit());
      const Camera camera = any_camera(random, settings, test::kAnyProjections[n % 6]);
      BuildDrawList::Result result;
      const std::vector<bool> listed = scene.list(camera, false, result);
      if (camera.parallel) back_facing += result.culled_backface;
      const glm::dvec3 eye = eye_lattice(camera);
      for (PatchId p = 0; p < listed.size(); ++p) {
        for (int k = 0; k < 4; ++k) {
          const std::size_t t = static_cast<std::size_t>(random.below(static_cast<int>(drawn.triangles())));
          const glm::dvec3 a = drawn.corner(p, t, 0);
          const glm::dvec3 normal = glm::cross(drawn.corner(p, t, 1) - a, drawn.corner(p, t, 2) - a);
          const glm::dvec3 view = camera.view_from_world * (a - eye) / double{kStepsPerVoxel};
          const glm::dvec4 clip = camera.clip_from_view * glm::dvec4(view, 1.0);
          if (!(std::max({std::abs(clip.x), std::abs(clip.y), std::abs(clip.z)}) <= clip.w)) continue;
          if (!(glm::dot(normal, camera.parallel ? camera.forward : a - eye) < 0)) continue;
          ++visible;
          ASSERT_TRUE(listed[p]) << "round " << round << ", view " << n << ", patch " << p;
        }
      }
    }
  }
  std::printf("%zu points in view, %zu patches that face away in parallel views\n", visible, back_facing);
  EXPECT_GT(visible, 20'000u);
  EXPECT_GT(back_facing, 1'000u);
}

TEST(Occlusion, WhatIsCulledLiesBehindAFrontThatIsDrawn) {
  Random random{301};
  std::size_t hidden = 0;
  std::size_t rays = 0;
  std::size_t active = 0;
  std::size_t from_air = 0;
  std::size_t frames = 0;
  std::size_t hidden_from_any = 0;
  std::size_t rays_from_any = 0;
  for (int round = 0; round < 12; ++round) {
    const int level = 1 + round % 3;
    const TestWorld source = make_caves(random, level, round % 3 != 0);
    Scene scene(source, round % 4 == 3 ? 1 : round % 2 - 1);
    const Drawn drawn(scene.world, level);
    for (int n = 0; n < 80; ++n) {
      CameraSettings settings;
      settings.near_voxels = std::exp2(-5.0 + 3.0 * random.unit());
      settings.yaw_deg = 360 * random.unit();
      settings.pitch_deg = 120 * random.unit() - 60;
      settings.fov_y_deg = 30 + 70 * random.unit();
      // Near the ground, in the rock, outside the world and far from everything: mostly in the air.
      const bool above = random.below(6) == 0;
      const double beyond = n % 9 == 0 ? 20.0 : 0.0;
      for (int tries = 0; tries < (n % 3 == 0 ? 1 : 40); ++tries) {
        for (int axis = 0; axis < 3; ++axis) {
          const double size = source.extent()[axis] + (above && axis == 1 ? 8 : 0) + beyond;
          settings.position[axis] = size * random.unit() - 0.5 * beyond;
        }
        if (scene.occluders.is_outside(scene.octree, scene.tree, scene.world.surface(), scene.world.bounds(),
                                       settings.position * double{kStepsPerVoxel}, 2000.0)) {
          break;
        }
      }
      Camera camera;
      ASSERT_TRUE(make_camera(settings, camera).ok());
      // A third of the views are of any other kind, with the same place for an eye.
      const bool any = n % 3 == 2;
      if (any) camera = any_camera(random, settings, test::kAnyProjections[random.below(6)]);
      BuildDrawList::Result result;
      const std::vector<bool> all = scene.list(camera, false, result);
      const std::vector<bool> listed = scene.list(camera, true, result);
      ++frames;
      std::vector<PatchId> culled;
      for (PatchId p = 0; p < all.size(); ++p) {
        ASSERT_TRUE(all[p] || !listed[p]);
        if (all[p] && !listed[p]) culled.push_back(p);
      }
      ASSERT_TRUE(scene.occlusion.active() || culled.empty());
      const bool outside = scene.occluders.is_outside(
          scene.octree, scene.tree, scene.world.surface(), scene.world.bounds(),
          settings.position * double{kStepsPerVoxel}, 2.0 * settings.near_voxels * kStepsPerVoxel);
      active += outside ? 1u : 0u;
      hidden += culled.size();
      hidden_from_any += any ? culled.size() : 0;
      ASSERT_TRUE(culled.empty() || !camera.parallel);
      from_air += outside ? 0 : culled.size();
      if (culled.empty()) continue;
      const glm::dvec3 eye = eye_lattice(camera);
      for (int k = 0; k < 100; ++k) {
        const PatchId p = culled[static_cast<std::size_t>(random.below(static_cast<int>(culled.size())))];
        const std::size_t t = static_cast<std::size_t>(random.below(static_cast<int>(drawn.triangles())));
        const double u = random.unit();
        const double v = random.unit() * (1 - u);
        const glm::dvec3 a = drawn.corner(p, t, 0);
        const glm::dvec3 b = drawn.corner(p, t, 1);
        const glm::dvec3 c = drawn.corner(p, t, 2);
        const glm::dvec3 q = a + u * (b - a) + v * (c - a);
        const glm::dvec3 way = q - eye;
        // What faces away is not drawn anyway, nor what is out of view.
        if (!(glm::dot(glm::cross(b - a, c - a), way) < 0)) continue;
        const glm::dvec3 view = camera.view_from_world * way / double{kStepsPerVoxel};
        const glm::dvec4 clip = camera.clip_from_view * glm::dvec4(view, 1.0);
        if (!(std::max({std::abs(clip.x), std::abs(clip.y), std::abs(clip.z)}) <= clip.w)) continue;
        // What lies before the near plane is not drawn: z and w change in proportion to the way, but for z's
        // value at the eye.
        ++rays;
        rays_from_any += any ? 1u : 0u;
        const double sign = camera.reversed_depth ? -1.0 : 1.0;
        const double at_eye = sign * camera.clip_from_view[3][2];
        const double near = -at_eye / (sign * clip.z - at_eye + clip.w);
        ASSERT_TRUE(near > 0.0 && near <= 1.0);
        bool covered = false;
        for (PatchId other = 0; other < scene.world.patches() && !covered; ++other) {
          if (!listed[other]) continue;
          const auto hit = drawn.first_hit(other, eye, way, near, 1.0 - 1e-9);
          covered = hit && hit->front;
        }
        ASSERT_TRUE(covered) << "round " << round << ", view " << n << ", patch " << p;
      }
    }
  }
  std::printf("%zu of %zu eyes outside, %zu patches hidden, %zu of them from other eyes, %zu rays\n", active,
              frames, hidden, from_air, rays);
  std::printf("%zu patches hidden in views of any kind, %zu rays\n", hidden_from_any, rays_from_any);
  EXPECT_GT(hidden_from_any, 1'000u);
  EXPECT_GT(rays_from_any, 100u);
  EXPECT_GT(from_air, 1'000u);
  EXPECT_GT(active, frames / 10);
  EXPECT_GT(hidden, 10'000u);
  EXPECT_GT(rays, 1'000u);
}

// From an eye that counts as outside, every ray meets the surface's front first; from a cell that hides, its
// back.
TEST(Occlusion, OutsideAndInsideAreWhatTheySay) {
  Random random{302};
  std::size_t outside = 0;
  std::size_t inside = 0;
  for (int round = 0; round < 9; ++round) {
    const int level = 1 + round % 3;
    const TestWorld source = make_caves(random, level, true);
    Scene scene(source, round % 2 - 1);
    const Drawn drawn(scene.world, level);
    const auto first = [&](glm::dvec3 from, glm::dvec3 way) {
      std::optional<Drawn::Hit> least;
      for (PatchId p = 0; p < scene.world.patches(); ++p) {
        const auto hit = drawn.first_hit(p, from, way, 0.0, least ? least->t : 1.0);
        if (hit) least = hit;
      }
      return least;
    };
    for (int n = 0; n < 4000; ++n) {
      const glm::dvec3 at = glm::dvec3(source.extent()) *
                            glm::dvec3(random.unit(), random.unit(), random.unit()) * double{kStepsPerVoxel};
      const glm::ivec3 cell(at / double{scene.occluders.cell_steps()});
      const double reach = 0.3 * kStepsPerVoxel * random.unit();
      const bool is_outside = scene.occluders.is_outside(scene.octree, scene.tree, scene.world.surface(),
                                                         scene.world.bounds(), at, reach);
      constexpr auto rock = Occluders::Kind::rock;
      const bool is_air =
          scene.occluders.covers(Occluders::Kind::air, 0, cell.x, {cell.y, cell.z}, {cell.y, cell.z});
      const bool is_inside = scene.occluders.covers(rock, 0, cell.x, {cell.y, cell.z}, {cell.y, cell.z});
      ASSERT_EQ(is_inside, scene.occluders.covers(rock, 1, cell.y, {cell.z, cell.x}, {cell.z, cell.x}));
      ASSERT_EQ(is_inside, scene.occluders.covers(rock, 2, cell.z, {cell.y, cell.x}, {cell.y, cell.x}));
      ASSERT_FALSE(is_inside && (is_outside || is_air));
      if (!is_inside && !is_outside && !is_air) continue;
      const auto hit = first(at, direction(random) * 60.0 * double{kStepsPerVoxel});
      if (hit) {
        ASSERT_EQ(hit->front, !is_inside);
      }
      (is_inside ? inside : outside) += hit ? 1u : 0u;
      if (is_outside) {
        // Nothing is nearer than it reaches.
        const auto near = first(at, direction(random) * reach);
        ASSERT_FALSE(near.has_value());
      }
    }
  }
  std::printf("%zu points outside, %zu inside\n", outside, inside);
  EXPECT_GT(outside, 500u);
  EXPECT_GT(inside, 500u);
}

}  // namespace
}  // namespace karst::core
