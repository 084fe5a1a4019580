// SPDX-License-Identifier: MIT
// Heights fitted to solids whose surface is known: the vertices must lie on it.
#include "terrain/patch/fit_heights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include <glm/geometric.hpp>

#include "terrain/patch/displacement.h"
#include "terrain/patch/shared_vertices.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

constexpr int kLevel = 3;
const glm::dvec3 kCentre(8.2, 8.1, 7.9);
constexpr double kRadius = 5.3;

double sphere(const void*, glm::dvec3 p) {
  return kRadius - glm::length(p - kCentre);
}

test::TestWorld sphere_world() {
  return test::TestWorld({16, 16, 16}, [](glm::ivec3 v) { return sphere(nullptr, glm::dvec3(v) + 0.5) > 0; });
}

FitHeights fit_job(const test::TestWorld& world, std::vector<std::int16_t>& heights) {
  heights.assign(world.surface().patches.size() * static_cast<std::size_t>(patch_vertices(kLevel)), 0);
  FitHeights fit;
  fit.surface = world.surface();
  fit.field.value = sphere;
  fit.level = kLevel;
  fit.heights = heights;
  return fit;
}

TEST(FitHeights, RefusesEachWrongField) {
  const test::TestWorld world = sphere_world();
  std::vector<std::int16_t> heights;
  const FitHeights good = fit_job(world, heights);
  ASSERT_TRUE(good.validate().ok());
  const auto expect = [](const FitHeights& fit, const char* field) {
    EXPECT_STREQ(fit.validate().field(), field);
  };
  FitHeights fit = good;
  fit.field.value = nullptr;
  expect(fit, "field");
  for (const int level : {0, 7, -1}) {
    fit = good;
    fit.level = level;
    expect(fit, "level");
  }
  for (const double search : {0.0, 3.1, -1.0, std::nan("")}) {
    fit = good;
    fit.search_voxels = search;
    expect(fit, "search_voxels");
  }
  for (const double step : {0.0, 0.6, std::nan("")}) {
    fit = good;
    fit.step_voxels = step;
    expect(fit, "step_voxels");
  }
  fit = good;
  fit.heights = fit.heights.first(fit.heights.size() - 1);
  expect(fit, "heights");
}

TEST(FitHeights, PutsVerticesOnTheSolid) {
  test::TestWorld world = sphere_world();
  std::vector<std::int16_t> heights;
  const FitHeights fit = fit_job(world, heights);
  FitHeights::Result result;
  fit.run(0, static_cast<PatchId>(world.patches().size()), result);
  EXPECT_EQ(result.misses, 0u);
  EXPECT_EQ(result.vertices, heights.size());
  world.set_samples(kLevel, heights);
  double worst = 0;
  std::vector<glm::ivec3> positions(static_cast<std::size_t>(patch_vertices(kLevel)));
  for (PatchId p = 0; p < world.patches().size(); ++p) {
    displaced_positions(world.surface(), world.heights(), kLevel, p, positions);
    for (const glm::ivec3& q : positions) {
      const glm::dvec3 at = glm::dvec3(patch_origin(world.surface().volume_of(p)) + q) / 8192.0;
      worst = std::max(worst, std::fabs(sphere(nullptr, at)));
    }
  }
  std::printf("largest distance from the sphere: 1/%.0f voxel\n", 1 / worst);
  // Half a step of the height along W, and one step on each axis when the vertex is rounded to even steps.
  EXPECT_LT(worst, (0.5 + std::sqrt(3.0)) / 8192);
}

TEST(FitHeights, PartsGiveTheWhole) {
  const test::TestWorld world = sphere_world();
  std::vector<std::int16_t> whole, parts;
  FitHeights::Result result;
  const PatchId count = static_cast<PatchId>(world.surface().patches.size());
  fit_job(world, whole).run(0, count, result);
  const FitHeights fit = fit_job(world, parts);
  fit.run(count / 3, count, result);
  fit.run(0, count / 3, result);
  EXPECT_EQ(whole, parts);
}

TEST(FitHeights, MissesAreCountedAndStayInReach) {
  const test::TestWorld world = sphere_world();
  std::vector<std::int16_t> heights;
  FitHeights fit = fit_job(world, heights);
  fit.field.value = [](const void*, glm::dvec3) { return -1.0; };
  FitHeights::Result result;
  fit.run(0, 1, result);
  EXPECT_EQ(result.misses, static_cast<std::uint64_t>(patch_vertices(kLevel)));
  EXPECT_EQ(heights[0], 0);
}

// for_each_copy names the vertices at the same undisplaced place, and all of them that share an edge or
// corner.
TEST(SharedVertices, CopiesAreAtOnePlace) {
  for (const double wavelength : {0.0, 3.0}) {
    const test::TestWorld world = test::TestWorld::noise(8, {9, 9, 9}, 0.5, wavelength, false);
    const Surface surface = world.surface();
    const int n = patch_cells(kLevel);
    const auto place = [&](GridVertex v) {
      return glm::dvec3(patch_origin(surface.volume_of(v.patch))) / 8192.0 +
             base_point(surface, kLevel, v.patch, v.i, v.j).position;
    };
    std::size_t copies = 0;
    for (PatchId p = 0; p < surface.patches.size(); ++p) {
      for (int j = 0; j <= n; ++j) {
        for (int i = 0; i <= n; ++i) {
          int self = 0;
          for_each_copy(surface.patches, kLevel, {p, i, j}, [&](GridVertex copy) {
            ++copies;
            self += copy.patch == p && copy.i == i && copy.j == j;
            EXPECT_EQ(place(copy), place({p, i, j}));
          });
          EXPECT_EQ(self, 1);
        }
      }
    }
    EXPECT_GT(copies, surface.patches.size() * static_cast<std::size_t>(patch_vertices(kLevel)));
  }
}

}  // namespace
}  // namespace karst::core
