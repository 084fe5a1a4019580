// SPDX-License-Identifier: MIT
// Morphing levels of detail as the GPU draws them, over random poses near, far and in the middle of a morph:
// the stated bound in pixels holds, levels switch without a visible step, and patches meet without a crack.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <glm/geometric.hpp>

#include "terrain/patch/displacement.h"
#include "terrain/patch/index_batches.h"
#include "terrain/view/select_lod.h"
#include "tests/support/morphed_surface.h"

namespace karst {
namespace {

using test::MorphedSurface;
using test::Projection;
using test::Random;
using test::TestWorld;

double between(Random& random, double low, double high) {
  return low + (high - low) * random.unit();
}

// Unit length, uniform.
glm::dvec3 direction(Random& random) {
  for (;;) {
    const glm::dvec3 d(between(random, -1, 1), between(random, -1, 1), between(random, -1, 1));
    const double length = glm::length(d);
    if (length > 0.1 && length < 1) return d / length;
  }
}

enum class Roughness { flat, smooth, mixed, rough, canyon };

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

// A world with everything that choosing levels needs.
class Scene {
 public:
  Scene(Random& random, int level, Roughness roughness) : Scene(make_world(random, level, roughness)) {}
  explicit Scene(const TestWorld& world)
      : drawn(world),
        levels(drawn.patches()),
        errors_(world.level_errors()),
        lods_(drawn.patches()),
        nodes_(BoundsTree::node_count(static_cast<std::uint32_t>(drawn.patches()))) {
    tree_.create(nodes_);
    EXPECT_TRUE(tree_.build(drawn.surface(), drawn.bounds()).ok());
  }
  Scene(const Scene&) = delete;

  // Thresholds for the picture and, with them, levels for all patches.
  SelectLod::Result select(const Camera& camera, int height_px, double error_px, int max_level) {
    set_thresholds(camera, height_px, error_px, max_level, true);
    return select_again(camera, error_px, max_level, nullptr, levels);
  }

  SelectLod::Result select_again(const Camera& camera, double error_px, int max_level, const Frustum* frustum,
                                 std::span<std::uint8_t> out) const {
    LodSettings settings;
    settings.error_px = error_px;
    settings.max_level = settings.resident_level = max_level;
    return run(settings, camera, frustum, out);
  }

  // With levels capped by what is held, after set_thresholds or select.
  SelectLod::Result select_held(const LodSettings& settings, const Camera& camera, const Frustum* frustum,
                                std::span<const std::uint8_t> resident, std::span<LackingPatch> lacking) {
    return run(settings, camera, frustum, levels, resident, lacking);
  }

  // K's levels, which do not morph, or the finest.
  SelectLod::Result select_still(const LodSettings& settings, const Camera& camera, int height_px,
                                 const Frustum* frustum) {
    set_thresholds(camera, height_px, settings.error_px, settings.top_level(), false);
    return run(settings, camera, frustum, levels);
  }

  unsigned lower_edges(PatchId patch, std::span<const std::uint8_t> of) const {
    unsigned lower = 0;
    for (int e = 0; e < 4; ++e) {
      const PatchEdge n = drawn.surface().patches[patch].neighbour[e];
      if (n.exists() && of[n.patch()] > 0 && of[n.patch()] + 1 == of[patch]) lower |= 1u << e;
    }
    return lower;
  }

  std::vector<glm::vec3> moved(PatchId patch, int level, const Camera& camera) const {
    return drawn.moved(patch, level, camera, scale, lods_);
  }
  LatticeBox box(PatchId patch) const { return patch_box(drawn.surface(), drawn.bounds(), patch); }
  LevelErrors errors() const { return {drawn.level(), errors_}; }
  const std::vector<PatchLod>& lods() const { return lods_; }

  MorphedSurface drawn;
  ErrorScale scale;
  std::vector<std::uint8_t> levels;

 private:
  void set_thresholds(const Camera& camera, int height_px, double error_px, int max_level, bool morphing) {
    scale = make_error_scale(camera, height_px, error_px);
    SetThresholds set;
    set.scale = scale;
    set.max_level = max_level;
    set.morphing = morphing;
    set.surface = drawn.surface();
    set.bounds = drawn.bounds();
    set.errors = errors();
    set.lods = lods_;
    EXPECT_TRUE(set.validate().ok());
    set.run();
  }

  SelectLod::Result run(const LodSettings& settings, const Camera& camera, const Frustum* frustum,
                        std::span<std::uint8_t> out, std::span<const std::uint8_t> resident = {},
                        std::span<LackingPatch> lacking = {}) const {
    SelectLod select;
    select.settings = settings;
    select.camera = &camera;
    select.surface = drawn.surface();
    select.bounds = drawn.bounds();
    select.tree = &tree_;
    select.scale = scale;
    select.lods = lods_;
    select.frustum = frustum;
    select.errors = errors();
    select.resident = resident;
    select.levels = out;
    select.lacking = lacking;
    EXPECT_TRUE(select.validate().ok());
    return select.run();
  }

  std::vector<std::uint16_t> errors_;
  std::vector<PatchLod> lods_;
  std::vector<LatticeBox> nodes_;
  BoundsTree tree_;
};

struct Pose {
  CameraSettings camera;
  int height_px;
  double error_px;
};

// Around a random vertex of the surface: at a distance of any size, or where some level of its patch is
// morphing.
Pose random_pose(Random& random, Scene& scene) {
  Pose pose;
  pose.height_px = 200 + random.below(2000);
  pose.error_px = std::exp2(between(random, -2, 6));
  pose.camera.fov_y_deg = between(random, 15, 110);
  pose.camera.aspect = between(random, 0.4, 2.6);
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
    scene.select(camera, pose.height_px, pose.error_px, scene.drawn.level());
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

struct Deviation {
  double most_px = 0;
  double of_bound = 0;  // the largest share of its frame's bound
  std::size_t samples = 0;
  std::size_t moving = 0;  // vertices between home and target
};

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

// Of what is seen: one of the points at equal (u, v) is in the picture, the other one at least not behind the
// near plane.
void measure(const Scene& scene, const Camera& camera, const Pose& pose, double bound_px, Deviation& most) {
  const Frustum frustum = make_frustum(camera);
  const Projection projection(camera, pose.height_px);
  const double near = pose.camera.near_voxels * kStepsPerVoxel;
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

constexpr Roughness kAllRoughness[] = {Roughness::flat, Roughness::smooth, Roughness::mixed, Roughness::rough,
                                       Roughness::canyon};
constexpr const char* kRoughnessNames[] = {"flat", "smooth", "mixed", "rough", "canyon"};

// KARST_POSES sets how many poses a world of the next test is looked at from.
int poses_wanted() {
  const char* const text = std::getenv("KARST_POSES");
  return text == nullptr ? 100 : std::atoi(text);
}

TEST(Morph, TheStatedBoundHolds) {
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
            scene.select(camera, pose.height_px, pose.error_px, scene.drawn.level());
        ASSERT_EQ(selected.bound_px, static_cast<float>(pose.error_px));
        measure(scene, camera, pose, selected.bound_px, most);
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

// With vertices of the finest levels missing the bound rises, and holds.
TEST(Morph, TheBoundHoldsWithoutTheFinestLevels) {
  Random random{102};
  Deviation most;
  int risen = 0;
  for (int round = 0; round < 6; ++round) {
    Scene scene(random, 4, kAllRoughness[static_cast<std::size_t>(1 + round % 3)]);
    for (int n = 0; n < 100; ++n) {
      const Pose pose = random_pose(random, scene);
      const Camera camera = camera_of(pose.camera);
      const int top = 1 + random.below(3);
      scene.select(camera, pose.height_px, pose.error_px, top);
      const Frustum frustum = make_frustum(camera);
      const SelectLod::Result selected =
          scene.select_again(camera, pose.error_px, top, &frustum, scene.levels);
      ASSERT_GE(selected.bound_px, static_cast<float>(pose.error_px));
      if (selected.bound_px > static_cast<float>(pose.error_px)) ++risen;
      for (const int level : scene.levels) ASSERT_LE(level, top);
      measure(scene, camera, pose, selected.bound_px, most);
      ASSERT_LE(most.of_bound, 1.0) << "pose " << n << " of round " << round;
    }
  }
  std::printf("%d of 600 bounds risen; at most %.3f of the bound\n", risen, most.of_bound);
  EXPECT_GT(risen, 100);
}

TEST(Morph, DistanceAndFullStateTheirBoundsToo) {
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
      const SelectLod::Result selected = scene.select_still(settings, camera, pose.height_px, &frustum);
      const std::size_t before = most.samples;
      measure(scene, camera, pose, selected.bound_px, most);
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

// What is held of a world: most patches as fine as they may ever be wanted, some coarser in patches or at
// random, some not at all.
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
TEST(Morph, TheBoundHoldsForWhatIsHeld) {
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
        free = scene.select(camera, pose.height_px, pose.error_px, scene.drawn.level());
      } else {
        free = scene.select_still(settings, camera, pose.height_px, nullptr);
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
      measure(scene, camera, pose, result.bound_px, most);
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

// Levels follow from thresholds alone: neighbours never have to be raised, and culling does not change them.
TEST(Morph, NeighboursAreOneLevelApartOnTheirOwn) {
  Random random{103};
  std::array<std::size_t, kMaxLevel + 1> at_level{};
  std::size_t steps = 0;
  for (int round = 0; round < 24; ++round) {
    Scene scene(random, 1 + round % kMaxLevel, kAllRoughness[static_cast<std::size_t>(round % 4)]);
    std::vector<std::uint8_t> culled(scene.levels.size(), 99);
    for (int n = 0; n < 300; ++n) {
      const Pose pose = random_pose(random, scene);
      const Camera camera = camera_of(pose.camera);
      const int top = n % 4 == 0 ? 1 + random.below(scene.drawn.level()) : scene.drawn.level();
      scene.select(camera, pose.height_px, pose.error_px, top);
      const Frustum frustum = make_frustum(camera);
      scene.select_again(camera, pose.error_px, top, &frustum, culled);
      for (PatchId p = 0; p < scene.drawn.patches(); ++p) {
        const bool in_view = classify(frustum, scene.box(p), kAllPlanes) != kOutside;
        if (in_view) {
          ASSERT_EQ(culled[p], scene.levels[p]);
        }
        ++at_level[scene.levels[p]];
        for (const PatchEdge e : scene.drawn.surface().patches[p].neighbour) {
          if (!e.exists()) continue;
          ASSERT_LE(std::abs(scene.levels[p] - scene.levels[e.patch()]), 1);
          steps += scene.levels[p] != scene.levels[e.patch()] ? 1u : 0u;
          if (in_view) {
            ASSERT_EQ(culled[e.patch()], scene.levels[e.patch()]);
          }
        }
      }
    }
  }
  std::printf("patches at levels 1 to 6:");
  for (int m = 1; m <= kMaxLevel; ++m) std::printf(" %zu", at_level[static_cast<std::size_t>(m)]);
  std::printf("; %zu edges between levels\n", steps / 2);
  EXPECT_GT(steps, 10'000u);
}

// --- popping

// The surface at every vertex of the full level, as pixels; points behind the near plane are left out.
double largest_step(const Scene& scene, const Camera& camera, const Pose& pose,
                    std::span<const std::uint8_t> before, std::span<const std::uint8_t> after) {
  const Projection projection(camera, pose.height_px);
  const double near = pose.camera.near_voxels * kStepsPerVoxel;
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

// The camera flies along a line; where levels change between two places, the two are brought together until
// they are next to each other on the lattice of camera places. Then the camera is frozen and only the levels
// switch.
TEST(Morph, SwitchesDoNotPop) {
  Random random{104};
  for (const Roughness roughness : kAllRoughness) {
    double most = 0;
    std::size_t switches = 0;
    for (int round = 0; round < 4; ++round) {
      Scene scene(random, 3 + round % 3, roughness);
      for (int n = 0; n < 150; ++n) {
        Pose pose = random_pose(random, scene);
        const glm::dvec3 from = pose.camera.position;
        const glm::dvec3 to = from + std::exp2(between(random, -5, 3)) * direction(random);
        const double yaw = pose.camera.yaw_deg;
        const double turn = random.below(2) == 0 ? 0.0 : between(random, -40, 40);
        const auto look = [&](double t) {
          pose.camera.position = glm::mix(from, to, t);
          pose.camera.yaw_deg = yaw + turn * t;
          return camera_of(pose.camera);
        };
        const Camera start = look(0);
        scene.select(start, pose.height_px, pose.error_px, scene.drawn.level());
        std::vector<std::uint8_t> low(scene.levels);
        std::vector<std::uint8_t> middle(scene.levels.size());
        std::vector<std::uint8_t> high(scene.levels.size());
        double t_low = 0;
        double t_high = 1;
        scene.select_again(look(1), pose.error_px, scene.drawn.level(), nullptr, high);
        if (low == high) continue;
        while (t_high - t_low > 1e-12) {
          const double t = 0.5 * (t_low + t_high);
          scene.select_again(look(t), pose.error_px, scene.drawn.level(), nullptr, middle);
          if (middle == low) {
            t_low = t;
          } else {
            t_high = t;
            high = middle;
          }
        }
        for (PatchId p = 0; p < low.size(); ++p) switches += low[p] != high[p] ? 1u : 0u;
        for (const double t : {t_low, t_high})
          most = std::max(most, largest_step(scene, look(t), pose, low, high));
      }
    }
    std::printf("%-6s %zu patches switched: at most %.2g px\n", kRoughnessNames[static_cast<int>(roughness)],
                switches, most);
    EXPECT_GT(switches, 50u);
    EXPECT_LE(most, 0.01);
  }
}

// --- cracks

using Bits = std::array<std::uint32_t, 3>;

Bits bits_of(glm::vec3 v) {
  // Adding 0 makes a negative zero positive.
  return {std::bit_cast<std::uint32_t>(v.x + 0.0f), std::bit_cast<std::uint32_t>(v.y + 0.0f),
          std::bit_cast<std::uint32_t>(v.z + 0.0f)};
}

std::uint64_t hash_of(glm::vec3 v) {
  const Bits bits = bits_of(v);
  return test::mix(bits[0] ^ test::mix(bits[1] ^ test::mix(bits[2])));
}

// A sum over the edges of all drawn triangles, by the bits of their ends, in which an edge and its reverse
// cancel: 0 for a closed world, and anything else, with a chance of 2^-64 of being 0, where there is a crack
// or a T-junction.
std::uint64_t sum_of_edges(const Scene& scene, const Camera& camera, std::span<const std::uint16_t> table,
                           std::size_t& triangles) {
  std::uint64_t sum = 0;
  std::vector<std::uint64_t> vertex;
  for (PatchId p = 0; p < scene.drawn.patches(); ++p) {
    const int level = scene.levels[p];
    vertex.clear();
    for (const glm::vec3& v : scene.moved(p, level, camera)) vertex.push_back(hash_of(v));
    IndexRange ranges[kMaxIndexRanges];
    const unsigned skipped = scene.drawn.surface().patches[p].collapsed != 0 ? 8u : 0u;
    const int count = index_ranges(level, scene.lower_edges(p, scene.levels), skipped, ranges);
    for (int r = 0; r < count; ++r) {
      triangles += ranges[r].count / 3;
      for (std::uint32_t t = 0; t < ranges[r].count; t += 3) {
        const std::uint16_t* const index = table.data() + ranges[r].first + t;
        for (int k = 0; k < 3; ++k) {
          const std::uint64_t from = vertex[index[k]];
          const std::uint64_t to = vertex[index[(k + 1) % 3]];
          sum += test::mix(from + 3 * to) - test::mix(to + 3 * from);
        }
      }
    }
  }
  return sum;
}

TEST(Morph, MovingPatchesMeetWithoutCracks) {
  Random random{105};
  std::vector<std::uint16_t> table(index_count(kMaxLevel));
  ASSERT_TRUE(build_index_tables(kMaxLevel, table).ok());
  std::size_t triangles = 0;
  std::size_t steps = 0;
  for (int round = 0; round < 24; ++round) {
    Scene scene(random, 2 + round % 4, kAllRoughness[static_cast<std::size_t>(1 + round % 3)]);
    for (int n = 0; n < 40; ++n) {
      const Pose pose = random_pose(random, scene);
      const Camera camera = camera_of(pose.camera);
      scene.select(camera, pose.height_px, pose.error_px, scene.drawn.level());
      ASSERT_EQ(sum_of_edges(scene, camera, table, triangles), 0u) << "pose " << n << " of round " << round;
      for (PatchId p = 0; p < scene.drawn.patches(); ++p) {
        steps += scene.lower_edges(p, scene.levels) != 0 ? 1u : 0u;
      }
      LodSettings settings;
      settings.error_px = pose.error_px;
      settings.max_level = settings.resident_level = scene.drawn.level();
      scene.select_held(settings, camera, nullptr, random_held(random, scene, 0.0), {});
      ASSERT_EQ(sum_of_edges(scene, camera, table, triangles), 0u) << "held, pose " << n << " of " << round;
      for (PatchId p = 0; p < scene.drawn.patches(); ++p) {
        steps += scene.lower_edges(p, scene.levels) != 0 ? 1u : 0u;
      }
    }
  }
  std::printf("%zu triangles, %zu patches beside coarser ones\n", triangles, steps);
  EXPECT_GT(steps, 1'000u);
}

// All vertices on a shared edge, drawn or not, are the same bits seen from both sides.
TEST(Morph, SharedVerticesMoveAlike) {
  Random random{106};
  std::size_t moving = 0;
  for (int round = 0; round < 8; ++round) {
    Scene scene(random, 3 + round % 3, kAllRoughness[static_cast<std::size_t>(round % 4)]);
    const int level = scene.drawn.level();
    const int n = patch_cells(level);
    for (int k = 0; k < 20; ++k) {
      const Pose pose = random_pose(random, scene);
      const Camera camera = camera_of(pose.camera);
      scene.select(camera, pose.height_px, pose.error_px, level);
      std::vector<std::vector<glm::vec3>> moved;
      for (PatchId p = 0; p < scene.drawn.patches(); ++p) moved.push_back(scene.moved(p, level, camera));
      for (PatchId p = 0; p < scene.drawn.patches(); ++p) {
        for (int e = 0; e < 4; ++e) {
          const PatchEdge other = scene.drawn.surface().patches[p].neighbour[e];
          if (!other.exists()) continue;
          const GridLine mine = GridLine::along_edge(e, 0, level, false);
          const GridLine theirs = GridLine::along_edge(other.edge(), 0, level, true);
          for (int t = 0; t <= n; ++t) {
            const auto a =
                static_cast<std::size_t>(vertex_order(level, mine.i0 + t * mine.di, mine.j0 + t * mine.dj));
            const auto b = static_cast<std::size_t>(
                vertex_order(level, theirs.i0 + t * theirs.di, theirs.j0 + t * theirs.dj));
            ASSERT_EQ(bits_of(moved[p][a]), bits_of(moved[other.patch()][b]));
            const GpuVertex& g = scene.drawn.vertices(p)[a];
            moving += g.position[0] != g.morph[0] || g.position[1] != g.morph[1] ? 1u : 0u;
          }
        }
      }
    }
  }
  EXPECT_GT(moving, 100'000u);
}

}  // namespace
}  // namespace karst
