// SPDX-License-Identifier: MIT
#include "tests/support/morph_scene.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "terrain/draw/index_batches.h"

namespace karst::core {

glm::dvec3 direction(Random& random) {
  for (;;) {
    const glm::dvec3 d(between(random, -1, 1), between(random, -1, 1), between(random, -1, 1));
    const double length = glm::length(d);
    if (length > 0.1 && length < 1) return d / length;
  }
}

// A terraced canyon that winds through a plateau, under a natural bridge; walls with ledges, and a rough
// floor.
TestWorld make_canyon(Random& random, int level) {
  const std::uint64_t seed = random.next();
  const double bend = 6.28 * random.unit();
  const auto wall = [=](glm::dvec3 p) { return std::abs(p.x - 9.0 - 3.0 * std::sin(0.5 * p.z + bend)); };
  TestWorld world({18, 14, 18}, [=](glm::ivec3 v) {
    const glm::dvec3 p(v);
    const double terrace = std::floor(0.8 * wall(p) + 0.6 * test::value_noise(seed, 0.3 * p)) * 2.0;
    const bool bridge = v.z >= 8 && v.z <= 10 && v.y >= 8 && v.y <= 9;
    return v.y < std::min(3.0 + terrace, 10.0) || bridge;
  });
  world.set_heights(level, [=](glm::dvec3 p) {
    const double ledges = 700 * std::sin(7.0 * p.y) * test::value_noise(seed + 1, 0.6 * p);
    const double floor_ = wall(p) < 1.5 ? 600 * test::value_noise(seed + 2, 9.0 * p) : 0.0;
    return ledges + floor_ + 1200 * test::value_noise(seed + 3, 1.1 * p);
  });
  return world;
}

TestWorld make_world(Random& random, int level, Roughness roughness) {
  if (roughness == Roughness::canyon) return make_canyon(random, level);
  const double wavelength = roughness == Roughness::rough ? 0.0 : between(random, 2.5, 5.0);
  TestWorld world =
      TestWorld::noise(random.next(), {11, 10, 11}, between(random, 0.35, 0.65), wavelength, true);
  const std::uint64_t seed = random.next();
  switch (roughness) {
    case Roughness::flat:
      world.set_heights(level, [](glm::dvec3) { return 0.0; });
      break;
    case Roughness::smooth:
      world.set_heights(level, [=](glm::dvec3 p) { return 1500 * test::value_noise(seed, p * 0.7); });
      break;
    case Roughness::mixed:  // patches that need every level beside patches that need none
      world.set_heights(level, [=](glm::dvec3 p) {
        const double where = test::value_noise(seed, p * 0.35);
        return 900 * test::value_noise(seed, p) +
               (where > 0 ? 2500 * where * test::value_noise(~seed, p * 14.0) : 0.0);
      });
      break;
    case Roughness::rough:
      world.roughen(level, seed, 1500);
      break;
    case Roughness::canyon:
      break;
  }
  return world;
}

Pose random_pose(Random& random, Scene& scene) {
  Pose pose;
  const int height_px = 200 + random.below(2000);
  pose.error_px = std::exp2(between(random, -2, 6));
  pose.camera.fov_y_deg = between(random, 15, 110);
  pose.camera.aspect = between(random, 0.4, 2.6);
  pose.size_px = {std::lround(height_px * pose.camera.aspect), height_px};
  pose.camera.near_voxels = std::exp2(between(random, -9, -2));
  const PatchId patch = static_cast<PatchId>(random.below(static_cast<int>(scene.drawn.patches())));
  const auto& vertices = scene.drawn.vertices(patch);
  const GpuVertex& v = vertices[static_cast<std::size_t>(random.below(static_cast<int>(vertices.size())))];
  const glm::dvec3 target = (glm::dvec3(patch_origin(scene.drawn.surface().volume_of(patch))) +
                             glm::dvec3(v.position[0], v.position[1], v.position[2])) /
                            double{kStepsPerVoxel};
  double distance = std::exp2(between(random, -4, 5));
  const int kind = random.below(3);
  if (kind == 0 && scene.drawn.level() > 1) {
    Camera camera;
    EXPECT_TRUE(make_camera(pose.camera, camera).ok());
    scene.select(camera, pose.size_px, pose.error_px, scene.drawn.level());
    const int m = 2 + random.below(scene.drawn.level() - 1);
    const double threshold = threshold_steps(scene.lods()[patch].threshold[m]) / kStepsPerVoxel;
    distance = std::clamp(threshold * between(random, 0.6, 1.05), 0.02, 60.0);
  }
  pose.camera.position = target + distance * direction(random);
  const glm::dvec3 aside = kind == 1 ? 0.7 * distance * direction(random) : glm::dvec3(0.0);
  EXPECT_TRUE(look_at(pose.camera.position, target + aside, pose.camera.yaw_deg, pose.camera.pitch_deg).ok());
  return pose;
}

Camera camera_of(const CameraSettings& settings) {
  Camera camera;
  EXPECT_TRUE(make_camera(settings, camera).ok());
  return camera;
}

std::vector<std::uint8_t> random_held(Random& random, const Scene& scene, double missing) {
  std::vector<std::uint8_t> held(scene.drawn.patches());
  const double all = random.unit();
  const std::uint64_t seed = random.next();
  for (PatchId p = 0; p < held.size(); ++p) {
    const glm::dvec3 at = glm::dvec3(patch_origin(scene.drawn.surface().volume_of(p))) / 8192.0;
    const int level =
        random.unit() < all
            ? scene.drawn.level()
            : 1 + static_cast<int>((0.5 + 0.5 * test::value_noise(seed, 0.3 * at)) * scene.drawn.level());
    held[p] = random.unit() < missing ? 0 : static_cast<std::uint8_t>(std::min(level, scene.drawn.level()));
  }
  return held;
}

namespace {

// A place inside each triangle of a level.
struct SurfaceSample {
  std::uint16_t vertex[3];  // in slot order
  double weight[3];
};

const std::vector<SurfaceSample>& samples_inside(int level) {
  static std::array<std::vector<SurfaceSample>, kMaxLevel + 1> all;
  std::vector<SurfaceSample>& samples = all[static_cast<std::size_t>(level)];
  if (!samples.empty()) return samples;
  std::vector<std::uint16_t> table(index_count(kMaxLevel));
  EXPECT_TRUE(build_index_tables(kMaxLevel, table).ok());
  IndexRange ranges[kMaxIndexRanges];
  EXPECT_EQ(index_ranges(level, 0, 0, ranges), 1);
  Random random{109};
  for (std::uint32_t t = 0; t < ranges[0].count; t += 3) {
    const std::uint16_t* const index = table.data() + ranges[0].first + t;
    const double a = random.unit();
    const double b = (1 - a) * random.unit();
    samples.push_back({{index[0], index[1], index[2]}, {a, b, 1 - a - b}});
  }
  return samples;
}

}  // namespace

void measure_deviation(const Scene& scene, const Camera& camera, glm::ivec2 size_px, double bound_px,
                       Deviation& most) {
  const Frustum frustum = make_frustum(camera);
  const Projection projection(camera, size_px);
  const double near = camera.near_voxels * kStepsPerVoxel;
  std::vector<glm::dvec3> points;
  std::vector<glm::dvec3> full;
  const std::vector<SurfaceSample>& inner = samples_inside(scene.drawn.level());
  for (PatchId p = 0; p < scene.drawn.patches(); ++p) {
    if (scene.levels[p] == 0 || classify(frustum, scene.box(p), kAllPlanes) == kOutside) continue;
    const std::vector<glm::vec3> moved = scene.moved(p, scene.levels[p], camera);
    scene.drawn.points(p, scene.levels[p], scene.lower_edges(p, scene.levels), moved, points);
    scene.drawn.full_points(p, camera, full);
    const auto look_at_point = [&](glm::dvec3 drawn, glm::dvec3 there) {
      if (drawn == there) return;
      if (projection.depth(drawn) < near || projection.depth(there) < near) return;
      if (!projection.inside(drawn) && !projection.inside(there)) return;
      const double px = glm::distance(projection.pixels(drawn), projection.pixels(there));
      most.most_px = std::max(most.most_px, px);
      most.of_bound = std::max(most.of_bound, px / bound_px);
      ++most.samples;
    };
    for (std::size_t v = 0; v < points.size(); ++v) look_at_point(points[v], full[v]);
    // Both surfaces are linear over the triangles of the full level; inside those, at random places.
    for (std::size_t n = p % 8; n < inner.size(); n += 8) {
      const SurfaceSample& s = inner[n];
      const auto at = [&](const std::vector<glm::dvec3>& of) {
        return s.weight[0] * of[s.vertex[0]] + s.weight[1] * of[s.vertex[1]] + s.weight[2] * of[s.vertex[2]];
      };
      look_at_point(at(points), at(full));
    }
    for (std::size_t v = 0; v < moved.size(); ++v) {
      const GpuVertex& g = scene.drawn.vertices(p)[v];
      const glm::dvec3 home = full[v];
      const glm::dvec3 target = home + glm::dvec3(g.morph[0] - g.position[0], g.morph[1] - g.position[1],
                                                  g.morph[2] - g.position[2]);
      if (glm::dvec3(moved[v]) != home && glm::dvec3(moved[v]) != target) ++most.moving;
    }
  }
}

double largest_step(const Scene& scene, const Camera& camera, glm::ivec2 size_px,
                    std::span<const std::uint8_t> before, std::span<const std::uint8_t> after) {
  const Projection projection(camera, size_px);
  const double near = camera.near_voxels * kStepsPerVoxel;
  double most = 0;
  std::vector<glm::dvec3> points[2];
  for (PatchId p = 0; p < scene.drawn.patches(); ++p) {
    const unsigned lower[2] = {scene.lower_edges(p, before), scene.lower_edges(p, after)};
    if (before[p] == after[p] && lower[0] == lower[1]) continue;
    scene.drawn.points(p, before[p], lower[0], scene.moved(p, before[p], camera), points[0]);
    scene.drawn.points(p, after[p], lower[1], scene.moved(p, after[p], camera), points[1]);
    for (std::size_t v = 0; v < points[0].size(); ++v) {
      if (projection.depth(points[0][v]) < near || projection.depth(points[1][v]) < near) continue;
      most = std::max(most, glm::distance(projection.pixels(points[0][v]), projection.pixels(points[1][v])));
    }
  }
  return most;
}

}  // namespace karst::core
