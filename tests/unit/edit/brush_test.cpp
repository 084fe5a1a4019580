// SPDX-License-Identifier: MIT
// Weights and noise of brushes, two places at a time, are those of each place alone, to the bit; they are
// what the formulas say, written here as plainly as they stand in the sources.
#include "terrain/edit/brush.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "terrain/base/simd.h"
#include "terrain/patch/displacement.h"
#include "tests/support/hilly_world.h"
#include "tests/support/loaded_parts.h"

namespace karst::core {
namespace {

using simd::Double2;

glm::dvec3 random_place(std::mt19937& random, double most) {
  std::uniform_real_distribution<double> of(-most, most);
  const double x = of(random), y = of(random), z = of(random);
  return {x, y, z};
}

void both(const glm::dvec3& a, const glm::dvec3& b, Double2 (&out)[3]) {
  for (int axis = 0; axis < 3; ++axis) out[axis] = Double2{a[axis], b[axis]};
}

TEST(Brush, WeighsTwoPlacesAsEachAlone) {
  std::mt19937 random(1);
  for (const BrushShape shape :
       {BrushShape::box, BrushShape::sphere, BrushShape::capsule, BrushShape::cylinder}) {
    for (const double hardness : {0.0, 0.3, 0.999, 1.0}) {
      Edit edit;
      edit.shape = shape;
      edit.hardness = hardness;
      edit.place = {3, -2, 5};
      edit.to = {4, 1, 5.5};
      edit.half = {1, 2, 3};
      edit.radius = 2;
      int within = 0;
      for (int n = 0; n < 500; ++n) {
        const glm::dvec3 a = edit.place + random_place(random, 3), b = edit.place + random_place(random, 3);
        Double2 place[3];
        both(a, b, place);
        const Double2 weight = brush_weights(edit, place);
        ASSERT_EQ(weight[0], brush_weight(edit, a));
        ASSERT_EQ(weight[1], brush_weight(edit, b));
        within += weight[0] > 0 ? 1 : 0;
      }
      EXPECT_GT(within, 25);
      EXPECT_LT(within, 475);
    }
  }
}

TEST(Brush, ProfileIsTheHyperbolicTangent) {
  for (const double hardness : {0.0, 0.25, 0.9}) {
    for (double share = 0; share < 1.25; share += 1.0 / 256) {
      const double wanted = share >= 1         ? 0
                            : share < hardness ? 1
                                               : std::tanh(kBrushSteepness * (1 - share) / (1 - hardness)) /
                                                     std::tanh(kBrushSteepness);
      ASSERT_NEAR(brush_profile(share, hardness), wanted, 1e-14) << share << " " << hardness;
    }
  }
  EXPECT_EQ(brush_profile(0, 0), 1);
  EXPECT_EQ(brush_profile(0.999, 1), 1);
  EXPECT_EQ(brush_profile(1, 1), 0);
}

// The way from corner to corner is by the axis with the greatest share, the next, the last.
double plain_noise(const glm::dvec3& place, std::uint32_t seed) {
  const double skew = (place.x + place.y + place.z) / 3;
  glm::dvec3 corner(std::floor(place.x + skew), std::floor(place.y + skew), std::floor(place.z + skew));
  const double back = (corner.x + corner.y + corner.z) / 6;
  const glm::dvec3 first = place - (corner - back), cube = corner;
  glm::dvec3 left = first;
  double sum = 0;
  for (int n = 0; n < 4; ++n) {
    const glm::dvec3 d = first - (corner - cube) + n / 6.0;
    const double near = 0.5 - (d.x * d.x + d.y * d.y + d.z * d.z);
    std::uint64_t h = seed * 0x9e3779b97f4a7c15ull;
    for (int axis = 0; axis < 3; ++axis) {
      h = (h ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(corner[axis]))) * 0xc2b2ae3d27d4eb4full;
      h ^= h >> 29;
    }
    const auto edge = static_cast<int>((h >> 32) * 12 >> 32);
    glm::dvec3 other = d;
    int axes[2], count = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (axis != edge / 4) axes[count++] = axis;
    }
    if ((edge & 1) != 0) other[axes[0]] = -other[axes[0]];
    if ((edge & 2) != 0) other[axes[1]] = -other[axes[1]];
    if (near > 0) sum += near * near * near * near * (other[axes[0]] + other[axes[1]]);
    int greatest = 0;
    for (int axis = 1; axis < 3; ++axis) {
      if (left[axis] > left[greatest]) greatest = axis;
    }
    ++corner[greatest];
    left[greatest] = -1e9;
  }
  return sum * 76;
}

TEST(Brush, NoiseOfTwoPlacesIsThatOfEachAlone) {
  std::mt19937 random(2);
  double low = 0, high = 0;
  for (int n = 0; n < 20'000; ++n) {
    const double most = n % 2 == 0 ? 30 : 0x1p40;
    glm::dvec3 a = random_place(random, most), b = random_place(random, most);
    if (n % 5 == 0) a = glm::dvec3(n / 5 % 7 - 3, n / 35 % 7 - 3, n / 245 % 7 - 3) / 2.0;  // shares are equal
    Double2 place[3];
    both(a, b, place);
    const Double2 noise = simplex_noise(place, 7);
    ASSERT_EQ(noise[0], plain_noise(a, 7)) << a.x << " " << a.y << " " << a.z;
    ASSERT_EQ(noise[1], plain_noise(b, 7));
    ASSERT_EQ(noise[0], simplex_noise(a, 7));
    ASSERT_EQ(noise[1], simplex_noise(b, 7));
    low = std::min({low, noise[0], noise[1]});
    high = std::max({high, noise[0], noise[1]});
  }
  EXPECT_LT(low, -0.8);
  EXPECT_GT(high, 0.8);
}

TEST(Brush, DirectionsOfTwoVerticesAreThoseOfEachAlone) {
  constexpr int kLevel = 3;
  const std::vector<std::byte> file = test::hilly_world(kLevel).file();
  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
  test::LoadedParts live(World::config_for(reader.info(), kLevel));
  ASSERT_TRUE(live.load(ByteSource::of(file)).ok());
  const Surface surface = live.world.surface();
  const std::size_t patches = std::min<std::size_t>(surface.patches.size(), 200);
  ASSERT_GT(patches, 100u);
  for (PatchId patch = 0; patch < patches; ++patch) {
    const PatchShape shape = PatchShape::make(surface, Heights{}, kLevel, patch);
    for (int j = 0; j <= patch_cells(kLevel); ++j) {
      const LineCurve row = line_curve(shape, {0, j, 1, 0});
      for (int i = 0; i < patch_cells(kLevel); ++i) {
        const BasePoints2 two = base_points(shape, row, i, i + 1);
        for (int lane = 0; lane < 2; ++lane) {
          const BasePoint one = base_point(shape, i + lane, j);
          const glm::ivec3 lattice = displace_vertices(shape, {i + lane, 0, 0, 0}, {j, 0, 0, 0}).position[0];
          for (int axis = 0; axis < 3; ++axis) {
            ASSERT_EQ(two.position[axis][lane], one.position[axis]);
            ASSERT_EQ(two.direction[axis][lane], one.direction[axis]);
            ASSERT_NEAR(one.position[axis] * kStepsPerVoxel, lattice[axis], 1.01);
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace karst::core
