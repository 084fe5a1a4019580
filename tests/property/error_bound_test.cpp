// SPDX-License-Identifier: MIT
// The stated bound in pixels against the deviation that is drawn, over random poses near, far and in the
// middle of a morph, with levels chosen in all modes and held or not: both surfaces on the CPU in double.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <glm/geometric.hpp>

#include "tests/support/any_camera.h"
#include "tests/support/morph_scene.h"

namespace karst::core {
namespace {

// KARST_POSES sets how many poses a world of the next test is looked at from.
int poses_wanted() {
  const char* const text = std::getenv("KARST_POSES");
  return text == nullptr ? 100 : std::atoi(text);
}

TEST(ErrorBound, TheStatedBoundHolds) {
  Random random{101};
  const int poses_a_world = poses_wanted();
  for (const Roughness roughness : kAllRoughness) {
    Deviation most;
    int poses = 0;
    for (int round = 0; round < 8; ++round) {
      Scene scene(random, 3 + round % 3, roughness);
      for (int n = 0; n < poses_a_world; ++n, ++poses) {
        const Pose pose = random_pose(random, scene);
        const Camera camera = camera_of(pose.camera);
        const SelectLod::Result selected =
            scene.select(camera, pose.size_px, pose.error_px, scene.drawn.level());
        ASSERT_EQ(selected.bound_px, static_cast<float>(pose.error_px));
        measure_deviation(scene, camera, pose.size_px, selected.bound_px, most);
        ASSERT_LE(most.of_bound, 1.0) << "pose " << n << " of round " << round;
      }
    }
    std::printf("%-6s %d poses, %zu points off, %zu vertices moving: at most %.3f of the bound, %.2f px\n",
                kRoughnessNames[static_cast<int>(roughness)], poses, most.samples, most.moving, most.of_bound,
                most.most_px);
    EXPECT_GT(most.samples, 100'000u);
    EXPECT_GT(most.moving, 10'000u);
    EXPECT_GT(most.of_bound, 0.3);  // else the test looks in the wrong places, or the bound is far too loose
  }
}

// Looks at a random vertex, from any side and in any way.
Camera any_camera(Random& random, const Scene& scene, test::AnyProjection kind) {
  const PatchId patch = static_cast<PatchId>(random.below(static_cast<int>(scene.drawn.patches())));
  const GpuVertex& v = scene.drawn.vertices(patch)[0];
  const glm::dvec3 target = (glm::dvec3(patch_origin(scene.drawn.surface().volume_of(patch))) +
                             glm::dvec3(v.position[0], v.position[1], v.position[2])) /
                            double{kStepsPerVoxel};
  const double distance = std::exp2(between(random, -3, 5));
  CameraMatrices matrices = test::any_matrices(random, kind, distance * std::exp2(between(random, -6, -2)),
                                               std::exp2(between(random, -2, 6)));
  test::show(random, target, distance, matrices);
  return test::camera_of(matrices);
}

// Rolled, mirrored, off the axis, with oblique planes, parallel; pixels of any shape. With all levels, and
// with those alone that the bound says something about without morphing.
TEST(ErrorBound, TheStatedBoundHoldsForAnyProjection) {
  Random random{110};
  for (const test::AnyProjection kind : test::kAnyProjections) {
    Deviation most;
    Deviation most_still;
    for (int round = 0; round < 4; ++round) {
      Scene scene(random, 3 + round % 3, kAllRoughness[static_cast<std::size_t>(1 + round % 4)]);
      for (int n = 0; n < 25; ++n) {
        const Camera camera = any_camera(random, scene, kind);
        const glm::ivec2 size_px(200 + random.below(2000), 200 + random.below(2000));
        const double error_px = std::exp2(between(random, -2, 6));
        const SelectLod::Result selected = scene.select(camera, size_px, error_px, scene.drawn.level());
        ASSERT_EQ(selected.bound_px, static_cast<float>(error_px));
        measure_deviation(scene, camera, size_px, selected.bound_px, most);
        ASSERT_LE(most.of_bound, 1.0) << "camera " << n << " of round " << round;

        LodSettings settings;
        settings.mode = LodMode::distance;
        settings.max_level = 1 + random.below(scene.drawn.level());
        settings.distance_voxels = std::exp2(between(random, 0, 6));
        const Frustum frustum = make_frustum(camera);
        measure_deviation(scene, camera, size_px,
                          scene.select_still(settings, camera, size_px, &frustum).bound_px, most_still);
        ASSERT_LE(most_still.of_bound, 1.0) << "camera " << n << " of round " << round;
      }
    }
    std::printf(
        "kind %d: %zu points off, %zu vertices moving: at most %.3f of the bound, %.2f px; %.3f still\n",
        static_cast<int>(kind), most.samples, most.moving, most.of_bound, most.most_px, most_still.of_bound);
    EXPECT_GT(most.samples, 10'000u);
    EXPECT_GT(most.moving, 1'000u);
    EXPECT_GT(most.of_bound, 0.3);
    EXPECT_GT(most_still.of_bound, 0.1);
  }
}

// With vertices of the finest levels missing the bound rises, and holds.
TEST(ErrorBound, TheBoundHoldsWithoutTheFinestLevels) {
  Random random{102};
  Deviation most;
  int risen = 0;
  for (int round = 0; round < 6; ++round) {
    Scene scene(random, 4, kAllRoughness[static_cast<std::size_t>(1 + round % 3)]);
    for (int n = 0; n < 100; ++n) {
      const Pose pose = random_pose(random, scene);
      const Camera camera = camera_of(pose.camera);
      const int top = 1 + random.below(3);
      scene.select(camera, pose.size_px, pose.error_px, top);
      const Frustum frustum = make_frustum(camera);
      const SelectLod::Result selected =
          scene.select_again(camera, pose.error_px, top, &frustum, scene.levels);
      ASSERT_GE(selected.bound_px, static_cast<float>(pose.error_px));
      if (selected.bound_px > static_cast<float>(pose.error_px)) ++risen;
      for (const int level : scene.levels) ASSERT_LE(level, top);
      measure_deviation(scene, camera, pose.size_px, selected.bound_px, most);
      ASSERT_LE(most.of_bound, 1.0) << "pose " << n << " of round " << round;
    }
  }
  std::printf("%d of 600 bounds risen; at most %.3f of the bound\n", risen, most.of_bound);
  EXPECT_GT(risen, 100);
}

TEST(ErrorBound, DistanceAndFullStateTheirBoundsToo) {
  Random random{107};
  Deviation most;
  for (int round = 0; round < 6; ++round) {
    Scene scene(random, 4, kAllRoughness[static_cast<std::size_t>(round % 4)]);
    for (int n = 0; n < 60; ++n) {
      const Pose pose = random_pose(random, scene);
      const Camera camera = camera_of(pose.camera);
      const Frustum frustum = make_frustum(camera);
      LodSettings settings;
      settings.mode = n % 3 == 0 ? LodMode::full : LodMode::distance;
      settings.max_level = 1 + random.below(4);
      settings.distance_voxels = std::exp2(between(random, 0, 6));
      const SelectLod::Result selected = scene.select_still(settings, camera, pose.size_px, &frustum);
      const std::size_t before = most.samples;
      measure_deviation(scene, camera, pose.size_px, selected.bound_px, most);
      ASSERT_LE(most.of_bound, 1.0) << "pose " << n << " of round " << round;
      if (settings.mode == LodMode::full && settings.max_level == 4) {
        ASSERT_EQ(selected.bound_px, 0.0f);
        ASSERT_EQ(most.samples, before);
      }
    }
  }
  ASSERT_EQ(most.moving, 0u);
  std::printf("at most %.3f of the bound\n", most.of_bound);
  EXPECT_GT(most.of_bound, 0.3);
}

// All as fine as wanted but for one patch, one level coarser: the one that is off by least in pixels compared
// with a finer neighbour, so that what the bound has to cover is what that one leaves out beside it.
std::vector<std::uint8_t> all_but_one(const Scene& scene, const Camera& camera,
                                      std::vector<std::uint8_t> wanted) {
  const LodEye eye = make_lod_eye(camera, scene.scale.least_cos2);
  PatchId one = 0;
  float most = 0;
  for (PatchId p = 0; p < wanted.size(); ++p) {
    if (wanted[p] < 2) continue;
    for (const PatchEdge e : scene.drawn.surface().patches[p].neighbour) {
      if (!e.exists() || wanted[e.patch()] != wanted[p]) continue;
      const int gain =
          scene.errors().error(e.patch(), wanted[p] - 1) - scene.errors().error(p, wanted[p] - 1);
      const float px =
          static_cast<float>(gain) / std::max(least_apparent_distance(scene.lods()[p], eye), 1e3f);
      if (px > most) one = p, most = px;
    }
  }
  if (most > 0) --wanted[one];
  return wanted;
}

// Levels cut to what is held: neighbours that are drawn are at most one apart, nothing is cut without need,
// and the bound holds for what is drawn.
TEST(ErrorBound, TheBoundHoldsForWhatIsHeld) {
  Random random{108};
  Deviation most;
  std::size_t capped = 0;
  std::size_t lowered = 0;
  std::size_t risen = 0;
  for (int round = 0; round < 12; ++round) {
    Scene scene(random, 3 + round % 3, kAllRoughness[static_cast<std::size_t>(round % 4)]);
    std::vector<LackingPatch> lacking(scene.drawn.patches());
    for (int n = 0; n < 60; ++n) {
      const Pose pose = random_pose(random, scene);
      const Camera camera = camera_of(pose.camera);
      const Frustum frustum = make_frustum(camera);
      LodSettings settings;
      settings.error_px = pose.error_px;
      settings.max_level = settings.resident_level = scene.drawn.level();
      settings.distance_voxels = std::exp2(between(random, 0, 6));
      settings.mode = n % 4 == 0 ? LodMode::distance : n % 17 == 0 ? LodMode::full : LodMode::error;
      SelectLod::Result free;
      if (settings.mode == LodMode::error) {
        free = scene.select(camera, pose.size_px, pose.error_px, scene.drawn.level());
      } else {
        free = scene.select_still(settings, camera, pose.size_px, nullptr);
      }
      const std::vector<std::uint8_t> wanted = scene.levels;
      const std::vector<std::uint8_t> held = n % 2 == 0 ? random_held(random, scene, n % 3 == 0 ? 0.1 : 0.0)
                                                        : all_but_one(scene, camera, wanted);
      const SelectLod::Result result = scene.select_held(settings, camera, &frustum, held, lacking);
      ASSERT_TRUE(std::isfinite(result.bound_px));
      std::size_t cut = 0;
      for (PatchId p = 0; p < scene.drawn.patches(); ++p) {
        if (classify(frustum, scene.box(p), kAllPlanes) == kOutside) continue;
        const int level = scene.levels[p];
        ASSERT_LE(level, std::min(wanted[p], held[p]));
        ASSERT_EQ(level == 0, held[p] == 0);
        bool needed = level == std::min(wanted[p], held[p]);
        for (const PatchEdge e : scene.drawn.surface().patches[p].neighbour) {
          if (!e.exists() || scene.levels[e.patch()] == 0 || level == 0) continue;
          if (classify(frustum, scene.box(e.patch()), kAllPlanes) == kOutside) continue;
          ASSERT_LE(std::abs(level - scene.levels[e.patch()]), 1);
          needed = needed || scene.levels[e.patch()] == level - 1;
        }
        ASSERT_TRUE(needed) << "lowered for no neighbour";
        if (held[p] < wanted[p]) {
          ASSERT_EQ(lacking[cut].patch, p);
          ASSERT_EQ(lacking[cut].wanted, wanted[p]);
          ASSERT_LE(lacking[cut].px, result.bound_px);
          ++cut;
        }
      }
      ASSERT_EQ(result.capped, cut);
      capped += cut;
      lowered += result.lowered;
      risen += result.bound_px > free.bound_px ? 1u : 0u;
      measure_deviation(scene, camera, pose.size_px, result.bound_px, most);
      ASSERT_LE(most.of_bound, 1.0) << "pose " << n << " of round " << round;
    }
  }
  std::printf("%zu patches capped, %zu lowered, %zu bounds risen; at most %.3f of the bound\n", capped,
              lowered, risen, most.of_bound);
  EXPECT_GT(capped, 1'000u);
  EXPECT_GT(lowered, 1'000u);
  EXPECT_GT(risen, 100u);
  EXPECT_GT(most.of_bound, 0.3);
}

}  // namespace
}  // namespace karst::core
