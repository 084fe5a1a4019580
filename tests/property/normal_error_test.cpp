// SPDX-License-Identifier: MIT
// What the 16-byte layout costs: normals in degrees, positions in lattice steps (design 4.5).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <glm/geometric.hpp>

#include "terrain/patch/displacement.h"
#include "terrain/patch/octahedral.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

TEST(LayoutError, Normals) {
  test::Random random{11};
  double worst = 0;
  double sum_squares = 0;
  constexpr int kCount = 2'000'000;
  for (int k = 0; k < kCount; ++k) {
    // Uniform on the sphere (Archimedes).
    const double z = 2 * random.unit() - 1;
    const double a = 6.283185307179586 * random.unit();
    const double r = std::sqrt(1 - z * z);
    const glm::dvec3 n(r * std::cos(a), z, r * std::sin(a));
    const glm::dvec3 d(decode_octahedral(encode_octahedral(glm::vec3(n))));
    const double error = std::atan2(glm::length(glm::cross(n, d)), glm::dot(n, d)) * 57.29577951308232;
    worst = std::max(worst, error);
    sum_squares += error * error;
  }
  std::printf("normals: largest error %.3f deg, RMS %.3f deg\n", worst, std::sqrt(sum_squares / kCount));
  EXPECT_LT(worst, 1.0);
}

TEST(LayoutError, NormalsRoundTripOnAxes) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {1.0f, -1.0f}) {
      glm::vec3 n(0.0f);
      n[axis] = sign;
      EXPECT_EQ(decode_octahedral(encode_octahedral(n)), n);
    }
  }
}

// Positions against the exact ones: D = P + W h in double.
TEST(LayoutError, Positions) {
  test::TestWorld world = test::TestWorld::noise(12, {10, 10, 10}, 0.5, 3.0, true);
  double worst = 0;
  for (int level = 1; level <= kMaxLevel; ++level) {
    world.roughen(level, 5, 8000);
    const int side = patch_side(level);
    std::vector<glm::ivec3> positions(static_cast<std::size_t>(side * side));
    for (PatchId p = 0; p < world.patches().size(); p += 7) {
      displaced_positions(world.surface(), world.heights(), level, p, positions);
      for (int j = 0; j < side; ++j) {
        for (int i = 0; i < side; ++i) {
          const BasePoint base = base_point(world.surface(), level, p, i, j);
          const double h = world.heights().block(p)[j * side + i];
          const glm::dvec3 exact = base.position * 8192.0 + base.direction * h;
          const glm::dvec3 off = glm::dvec3(positions[static_cast<std::size_t>(j * side + i)]) - exact;
          for (int axis = 0; axis < 3; ++axis) worst = std::max(worst, std::fabs(off[axis]));
        }
      }
    }
  }
  std::printf("positions: largest error %.4f lattice steps = 1/%.0f voxel on an axis\n", worst, 8192 / worst);
  EXPECT_LE(worst, 1.01);
}

// The gradient on a flat surface is 32 at the voxel centres beside it, which kMinGradientLength is measured
// against.
TEST(LayoutError, FlatGradient) {
  const test::TestWorld world({8, 8, 8}, [](glm::ivec3 v) { return v.y < 4; });
  for (const Volume& v : world.surface().volumes) {
    for (const auto& g : v.gradient) {
      EXPECT_EQ(g[0], 0);
      EXPECT_EQ(g[1], 48);
      EXPECT_EQ(g[2], 0);
    }
  }
}

}  // namespace
}  // namespace karst::core
