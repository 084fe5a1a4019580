// SPDX-License-Identifier: MIT
// Back-facing patches over random worlds and eyes: no triangle of a culled patch, at any level, in any state
// of its morph and of its edges, faces the eye.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <vector>

#include <glm/geometric.hpp>

#include "terrain/draw/index_batches.h"
#include "terrain/measure/normal_cone.h"
#include "terrain/patch/displacement.h"
#include "tests/support/morphed_surface.h"

namespace karst::core {
namespace {

using test::MorphedSurface;
using test::Random;
using test::TestWorld;

TestWorld make_world(Random& random, int level, int roughness) {
  const double wavelength = roughness == 3 ? 0.0 : 2.5 + 2.5 * random.unit();
  TestWorld world =
      TestWorld::noise(random.next(), {11, 10, 11}, 0.35 + 0.3 * random.unit(), wavelength, true);
  const std::uint64_t seed = random.next();
  const double height = 1500.0 * roughness;
  if (roughness == 0) world.set_heights(level, [](glm::dvec3) { return 0.0; });
  if (roughness == 3) world.roughen(level, seed, 1500);
  if (roughness == 1 || roughness == 2) {
    world.set_heights(level, [=](glm::dvec3 p) { return height * test::value_noise(seed, p * 1.3); });
  }
  return world;
}

// Vertices of a patch at a level with every vertex of that level moved by a share of its own: 0, 1 or
// between.
std::vector<glm::dvec3> random_state(Random& random, const MorphedSurface& world, PatchId patch, int level) {
  std::vector<glm::dvec3> at;
  const int coarser = level == 1 ? patch_vertices(1) : patch_vertices(level - 1);
  for (int v = 0; v < patch_vertices(level); ++v) {
    const GpuVertex& g = world.vertices(patch)[static_cast<std::size_t>(v)];
    const glm::dvec3 home(g.position[0], g.position[1], g.position[2]);
    const glm::dvec3 target(g.morph[0], g.morph[1], g.morph[2]);
    const int kind = random.below(3);
    const double share = v < coarser ? 0.0 : kind == 0 ? 0.0 : kind == 1 ? 1.0 : random.unit();
    at.push_back(home + share * (target - home));
  }
  return at;
}

TEST(NormalCone, NoTriangleOfACulledPatchFacesTheEye) {
  Random random{201};
  std::vector<std::uint16_t> table(index_count(kMaxLevel));
  ASSERT_TRUE(build_index_tables(kMaxLevel, table).ok());
  std::size_t culled = 0;
  std::size_t facing_away = 0;
  std::size_t asked = 0;
  std::size_t triangles = 0;
  std::size_t with_cone = 0;
  for (int round = 0; round < 16; ++round) {
    const int level = 2 + round % 3;
    const MorphedSurface world(make_world(random, level, round % 4));
    std::vector<NormalCone> cones(world.patches());
    MeasureNormalCones measure;
    measure.surface = world.surface();
    measure.heights = world.heights();
    measure.cones = cones;
    ASSERT_TRUE(measure.validate().ok());
    measure.run(0, static_cast<PatchId>(cones.size()));
    for (PatchId p = 0; p < cones.size(); ++p) {
      with_cone += cones[p].sine != NormalCone::kNone ? 1u : 0u;
      const glm::vec3 origin(patch_origin(world.surface().volume_of(p)));
      const PatchBounds& b = world.bounds()[p];
      const glm::vec3 low(b.min[0], b.min[1], b.min[2]);
      const glm::vec3 high(b.max[0], b.max[1], b.max[2]);
      for (int n = 0; n < 12; ++n) {
        const double distance = std::exp2(-3.0 + 8.0 * random.unit()) * kStepsPerVoxel;
        const glm::dvec3 away(random.unit() - 0.5, random.unit() - 0.5, random.unit() - 0.5);
        const glm::dvec3 eye = glm::dvec3(origin) + distance * away;
        const glm::vec3 rounded(eye);
        const bool is_culled = is_back_facing(cones[p], origin + 0.5f * (low + high) - rounded,
                                              0.5f * (high - low), back_facing_slack(rounded));
        culled += is_culled ? 1u : 0u;
        ++asked;
        bool all_away = true;
        for (int m = 1; m <= level; ++m) {
          const std::vector<glm::dvec3> at = random_state(random, world, p, m);
          IndexRange ranges[kMaxIndexRanges];
          const int used = index_ranges(m, static_cast<unsigned>(random.below(16)), 0, ranges);
          for (int r = 0; r < used; ++r) {
            for (std::uint32_t t = 0; t < ranges[r].count; t += 3) {
              const std::uint16_t* const index = table.data() + ranges[r].first + t;
              const glm::dvec3 a = at[index[0]];
              const glm::dvec3 normal = glm::cross(at[index[1]] - a, at[index[2]] - a);
              const bool faces = glm::dot(normal, glm::dvec3(origin) + a - eye) < 0.0;
              all_away = all_away && !faces;
              triangles += is_culled ? 1u : 0u;
              ASSERT_FALSE(is_culled && faces) << "patch " << p << " of round " << round << ", level " << m;
            }
          }
        }
        facing_away += all_away ? 1u : 0u;
      }
    }
  }
  std::printf("%zu of %zu patches culled of %zu that face away; %zu triangles looked at; %zu cones\n", culled,
              asked, facing_away, triangles, with_cone);
  EXPECT_GT(culled, facing_away / 3);
  EXPECT_GT(triangles, 1'000'000u);
}

// The test of a box against the cone itself: corners of boxes near the eye, normals on the rim.
TEST(NormalCone, ABoxIsCulledOnlyWhenAllOfItFacesAway) {
  Random random{202};
  std::size_t culled = 0;
  std::size_t away = 0;
  for (int n = 0; n < 400'000; ++n) {
    const auto any = [&] {
      return glm::dvec3(random.unit() - 0.5, random.unit() - 0.5, random.unit() - 0.5);
    };
    const glm::dvec3 axis = glm::normalize(any());
    NormalCone cone;
    for (int k = 0; k < 3; ++k) cone.axis[k] = static_cast<std::int8_t>(std::lround(127.0 * axis[k]));
    cone.sine = static_cast<std::uint8_t>(random.below(250));
    const glm::dvec3 a(cone.axis[0], cone.axis[1], cone.axis[2]);
    const double sine = 0.5 * cone.sine / glm::length(a);
    if (sine >= 1.0) continue;
    const glm::vec3 half(1e4 * glm::abs(any()));
    const glm::vec3 centre(glm::dvec3(half) * 2.5 * any() + std::exp2(16.0 * random.unit()) * (axis + any()));
    const bool is_culled = is_back_facing(cone, centre, half, 16.0f);
    culled += is_culled ? 1u : 0u;
    bool all_away = true;
    for (int corner = 0; corner < 8; ++corner) {
      glm::dvec3 p(centre);
      for (int k = 0; k < 3; ++k) p[k] += (corner >> k & 1) != 0 ? half[k] : -half[k];
      // The least product with any normal of the cone: with the rim's that leans the other way.
      const double along = glm::dot(p, a) / glm::length(a);
      const double across = std::sqrt(std::max(glm::dot(p, p) - along * along, 0.0));
      all_away = all_away && along * std::sqrt(1.0 - sine * sine) - across * sine > 0.0;
    }
    away += all_away ? 1u : 0u;
    ASSERT_FALSE(is_culled && !all_away) << n;
  }
  std::printf("%zu boxes culled of %zu that face away\n", culled, away);
  EXPECT_GT(culled, away * 2 / 3);
}

TEST(NormalCone, AConeIsCulledFromAfarOnlyWhenAllOfItFacesAway) {
  Random random{203};
  std::size_t culled = 0;
  std::size_t away = 0;
  for (int n = 0; n < 400'000; ++n) {
    const auto any = [&] {
      return glm::normalize(glm::dvec3(random.unit() - 0.5, random.unit() - 0.5, random.unit() - 0.5));
    };
    const glm::dvec3 axis = any();
    NormalCone cone;
    for (int k = 0; k < 3; ++k) cone.axis[k] = static_cast<std::int8_t>(std::lround(127.0 * axis[k]));
    cone.sine = static_cast<std::uint8_t>(random.below(250));
    const glm::dvec3 a(cone.axis[0], cone.axis[1], cone.axis[2]);
    const double sine = 0.5 * cone.sine / glm::length(a);
    if (sine >= 1.0) continue;
    const glm::vec3 forward(any());
    const double along = glm::dot(glm::dvec3(forward), a) / glm::length(a);
    const double across = std::sqrt(std::max(1.0 - along * along, 0.0));
    const bool all_away = along * std::sqrt(1.0 - sine * sine) - across * sine > 0.0;
    const bool is_culled = is_back_facing(cone, forward);
    culled += is_culled ? 1u : 0u;
    away += all_away ? 1u : 0u;
    ASSERT_FALSE(is_culled && !all_away) << n;
  }
  EXPECT_GT(culled, away * 98 / 100);
  NormalCone none;
  none.sine = NormalCone::kNone;
  EXPECT_FALSE(is_back_facing(none, {0, 1, 0}));
  EXPECT_TRUE(is_back_facing(NormalCone{{0, 127, 0}, 20}, {0, 1, 0}));
  EXPECT_FALSE(is_back_facing(NormalCone{{0, 127, 0}, 20}, {0, 1, 0}, 1.0f));
}

TEST(NormalCone, FlatGroundIsSeenFromAboveAlone) {
  TestWorld world({4, 4, 4}, [](glm::ivec3 v) { return v.y < 2; });
  world.set_heights(3, [](glm::dvec3) { return 0.0; });
  ASSERT_FALSE(world.surface().patches.empty());
  const NormalCone cone = measure_normal_cone(world.surface(), world.heights(), 0);
  EXPECT_EQ(cone.axis[0], 0);
  EXPECT_EQ(cone.axis[1], 127);
  EXPECT_EQ(cone.axis[2], 0);
  EXPECT_LE(cone.sine, 3);
  const glm::vec3 half(4096.0f, 0.0f, 4096.0f);
  EXPECT_FALSE(is_back_facing(cone, {0, -9000, 0}, half, 16.0f));
  EXPECT_FALSE(is_back_facing(cone, {0, 0, 0}, half, 16.0f));
  EXPECT_FALSE(is_back_facing(cone, {80'000, 0, 0}, half, 16.0f));
  EXPECT_TRUE(is_back_facing(cone, {0, 9000, 0}, half, 16.0f));
  EXPECT_TRUE(is_back_facing(cone, {80'000, 9000, 0}, half, 16.0f));
}

TEST(NormalCone, RefusesOneWrongFieldAtATime) {
  TestWorld world({4, 4, 4}, [](glm::ivec3 v) { return v.y < 2; });
  world.set_heights(2, [](glm::dvec3) { return 0.0; });
  std::vector<NormalCone> cones(world.surface().patches.size());
  MeasureNormalCones good;
  good.surface = world.surface();
  good.heights = world.heights();
  good.cones = cones;
  ASSERT_TRUE(good.validate().ok());
  MeasureNormalCones bad = good;
  bad.heights.level = 0;
  EXPECT_STREQ(bad.validate().field(), "heights");
  bad = good;
  bad.cones = bad.cones.first(1);
  EXPECT_STREQ(bad.validate().field(), "cones");
}

}  // namespace
}  // namespace karst::core
