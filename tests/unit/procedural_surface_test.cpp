// SPDX-License-Identifier: MIT
#include "terrain/procedural/procedural_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <vector>

#include <glm/geometric.hpp>

#include "terrain/procedural/simplex_noise.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

float noise_at(double x, double z, std::uint32_t seed) {
  const Places east{simd::Double2{x, 0}, simd::Double2{7, -3}};
  const Places south{simd::Double2{z, 0}, simd::Double2{2, 1e6}};
  return simplex_noise(east, south, seed)[0];
}

TEST(SimplexNoise, IsWithinOneAndReachesFar) {
  test::Random random{11};
  float low = 0, high = 0;
  double squares = 0;
  constexpr int kCount = 400'000;
  for (int n = 0; n < kCount; ++n) {
    const double x = 1e5 * (random.unit() - 0.5), z = 1e5 * (random.unit() - 0.5);
    const float v = noise_at(x, z, 5);
    low = std::min(low, v);
    high = std::max(high, v);
    squares += v * v;
  }
  EXPECT_GE(low, -1.0f);
  EXPECT_LE(high, 1.0f);
  EXPECT_LT(low, -0.6f);
  EXPECT_GT(high, 0.6f);
  EXPECT_NEAR(std::sqrt(squares / kCount), 0.31, 0.02);
}

TEST(SimplexNoise, HasNoSteps) {
  // Across corners, edges and far from the origin: a step of 1e-4 changes it by a slope of 8 at most.
  test::Random random{12};
  for (int n = 0; n < 100'000; ++n) {
    const double x = 3e5 * (random.unit() - 0.5), z = 300 * (random.unit() - 0.5);
    const double angle = 6.3 * random.unit();
    const double a = noise_at(x, z, 9),
                 b = noise_at(x + 1e-4 * std::cos(angle), z + 1e-4 * std::sin(angle), 9);
    ASSERT_LT(std::abs(a - b), 8e-4) << x << " " << z;
  }
}

TEST(SimplexNoise, IsThatOfItsSeed) {
  int equal = 0;
  for (int n = 0; n < 1000; ++n) equal += noise_at(n * 0.37, n * 0.11, 1) == noise_at(n * 0.37, n * 0.11, 2);
  EXPECT_LT(equal, 5);
}

// A surface with all there is: hills and hollows, mountains, dunes, a river with bends.
struct Land {
  std::vector<Feature> features;
  std::vector<RiverPiece> pieces;
  std::vector<RiverPoint> river{{{-900, -300}, 30}, {{-400, 80}, 28}, {{-380, 90}, 27.5},
                                {{-100, -200}, 25}, {{60, 300}, 22},  {{700, 260}, 20}};
  ProceduralSurface surface;

  explicit Land(double tolerance_m = 0.01) {
    pieces.resize(river_pieces(river, tolerance_m, {}));
    river_pieces(river, tolerance_m, pieces);
    Feature feature{FeatureKind::river, {0, 0}, 1400};
    feature.width_m = 24;
    feature.depth_m = 3;
    feature.valley_m = 120;
    feature.pieces = static_cast<std::uint32_t>(pieces.size());
    features.push_back(feature);
    feature = {FeatureKind::dunes, {500, -500}, 420, 14};
    feature.wavelength_m = 70;
    feature.towards = {0.6, 0.8};
    features.push_back(feature);
    features.push_back({FeatureKind::mountain, {-500, -600}, 500, 420, 0.8});
    features.push_back({FeatureKind::mountain, {-200, -700}, 350, 260, 0.2});
    features.push_back({FeatureKind::hill, {300, 200}, 250, 60});
    features.push_back({FeatureKind::hill, {400, 350}, 150, -25});
    features.push_back({FeatureKind::hill, {-600, 500}, 300, 80});
    features.push_back({FeatureKind::hill, {-450, 620}, 200, 50});
    order_features(features);
    surface = {77, {40, 18, 600, 0.5, 6}, features, pieces};
  }

  std::vector<float> heights(const SampleRect& rect) const {
    std::vector<float> out(static_cast<std::size_t>(rect.columns) * static_cast<std::size_t>(rect.rows));
    std::vector<std::uint32_t> near(2 * features.size() + pieces.size() + 1);
    procedural_heights(surface, rect, near, out);
    return out;
  }
  float height(std::int64_t x, std::int64_t z, double spacing_m) const {
    return heights({x, z, 1, 1, 1, spacing_m})[0];
  }
};

// Tiles of random places and sizes; each sample is that of a tile of one sample, where what is near is
// another choice. KARST_VERTICES: how many samples.
TEST(ProceduralSurface, IsTheSameInEveryTileThatSharesASample) {
  const Land land;
  test::Random random{3};
  const char* wanted = std::getenv("KARST_VERTICES");
  const auto most = wanted != nullptr ? std::strtoull(wanted, nullptr, 10) : 150'000ull;
  std::uint64_t compared = 0;
  while (compared < most) {
    const int size = random.below(7);
    const double spacing_m = 0.2 * (1 + random.below(5));
    const auto reach = static_cast<int>(1200 / spacing_m);
    const auto at = [&] { return random.below(2 * reach) - reach; };
    const SampleRect tile{at(),     at(), std::int64_t{1} << size, 1 + random.below(40), 1 + random.below(40),
                          spacing_m};
    // The same samples out of a larger tile of half the step, elsewhere in its blocks.
    const int left = random.below(9), above = random.below(9);
    const bool halves = size > 0;
    const std::int64_t step = halves ? tile.step / 2 : tile.step;
    const int times = halves ? 2 : 1;
    const SampleRect other{tile.first_x - left * step,  tile.first_z - above * step, step,
                           left + times * tile.columns, above + times * tile.rows,   spacing_m};
    const std::vector<float> a = land.heights(tile), b = land.heights(other);
    for (int row = 0; row < tile.rows; ++row) {
      for (int column = 0; column < tile.columns; ++column, ++compared) {
        const float one = a[static_cast<std::size_t>(row * tile.columns + column)];
        const float two =
            b[static_cast<std::size_t>((above + times * row) * other.columns + left + times * column)];
        ASSERT_EQ(std::memcmp(&one, &two, sizeof one), 0) << one << " " << two;
      }
    }
    const int row = random.below(tile.rows), column = random.below(tile.columns);
    const float alone =
        land.height(tile.first_x + column * tile.step, tile.first_z + row * tile.step, spacing_m);
    const float inside = a[static_cast<std::size_t>(row * tile.columns + column)];
    ASSERT_EQ(std::memcmp(&alone, &inside, sizeof alone), 0);
  }
  std::printf("%llu samples of tiles compared\n", static_cast<unsigned long long>(compared));
}

TEST(ProceduralSurface, FeaturesAreWhereTheyAreSaid) {
  Land land;
  const auto at = [&](double x, double z) { return land.height(std::lround(x), std::lround(z), 1); };
  const std::vector<Feature> all = land.features;
  // What a feature adds in its middle, and nothing beyond its radius.
  for (std::size_t n = 0; n < all.size(); ++n) {
    if (all[n].kind == FeatureKind::river || all[n].kind == FeatureKind::dunes) continue;
    Land bare, with;
    bare.features.clear();
    bare.surface.features = {};
    with.features = {all[n]};
    with.surface.features = with.features;
    const glm::dvec2 middle = all[n].place_m;
    const auto difference = [&](glm::dvec2 place) {
      const std::int64_t x = std::lround(place.x), z = std::lround(place.y);
      return with.height(x, z, 1) - bare.height(x, z, 1);
    };
    EXPECT_GT(difference(middle) / all[n].height_m, 0.55) << n;
    EXPECT_LT(difference(middle) / all[n].height_m, 1.5) << n;
    EXPECT_EQ(difference(middle + glm::dvec2(all[n].radius_m + 1, 0)), 0) << n;
  }
  // A river's bed lies depth below its level wherever the ground was.
  for (const RiverPiece& piece : land.pieces) {
    if (std::abs(piece.from_m.x) > 2000) continue;
    const double height = land.heights({0, 0, 1, 1, 1, 1}).empty() ? 0 : at(piece.from_m.x, piece.from_m.y);
    const double level = 0.5 * (piece.from_level_m + piece.to_level_m);
    EXPECT_LT(height, level - 2.3);
    EXPECT_GT(height, level - 3.3);
  }
}

// Against the spline itself, looked at in fine steps.
TEST(ProceduralSurface, RiversAreWithinTheirTolerance) {
  test::Random random{8};
  for (int round = 0; round < 300; ++round) {
    std::vector<RiverPoint> points;
    const int count = 2 + random.below(6);
    for (int n = 0; n < count; ++n)
      points.push_back({{1000 * random.unit(), 1000 * random.unit()}, 10 * random.unit()});
    const double tolerance_m = 0.005 + 0.5 * random.unit();
    std::vector<RiverPiece> pieces(river_pieces(points, tolerance_m, {}));
    ASSERT_EQ(river_pieces(points, tolerance_m, pieces), pieces.size());
    EXPECT_EQ(pieces.front().from_m, points.front().place_m);
    EXPECT_EQ(pieces.back().to_m, points.back().place_m);
    std::size_t piece = 0;
    for (std::size_t k = 0; k + 1 < points.size(); ++k) {
      const glm::dvec2 b = points[k].place_m, c = points[k + 1].place_m;
      const glm::dvec2 a = k > 0 ? points[k - 1].place_m : b,
                       d = k + 2 < points.size() ? points[k + 2].place_m : c;
      const std::size_t first = piece;
      while (piece < pieces.size() && pieces[piece].to_m != c) ++piece;
      ++piece;
      const auto parts = static_cast<double>(piece - first);
      for (int n = 0; n < 500; ++n) {
        const double t = random.unit();
        // By de Boor's form of it: E. Catmull and R. Rom's basis.
        const glm::dvec2 on = 0.5 * (2.0 * b + t * (c - a) + t * t * (2.0 * a - 5.0 * b + 4.0 * c - d) +
                                     t * t * t * (3.0 * b - a - 3.0 * c + d));
        const auto in = std::min(first + static_cast<std::size_t>(t * parts), piece - 1);
        const glm::dvec2 from = pieces[in].from_m, way = pieces[in].to_m - from;
        const double length = glm::dot(way, way);
        const double share = length > 0 ? std::clamp(glm::dot(on - from, way) / length, 0.0, 1.0) : 0;
        ASSERT_LE(glm::length(on - from - share * way), tolerance_m * (1 + 1e-9));
      }
    }
  }
}

TEST(ProceduralSurface, FeaturesAreOrderedByKindAlone) {
  test::Random random{21};
  for (int count = 0; count < 40; ++count) {
    std::vector<Feature> features;
    for (int n = 0; n < count; ++n)
      features.push_back({static_cast<FeatureKind>(random.below(4)), {}, 1.0 + n});
    std::vector<Feature> expected = features;
    order_features(features);
    // By its radius, which is its number: stable without a sort that takes memory of its own.
    std::sort(expected.begin(), expected.end(), [](const Feature& a, const Feature& b) {
      return a.kind != b.kind ? a.kind < b.kind : a.radius_m < b.radius_m;
    });
    for (std::size_t n = 0; n < features.size(); ++n) ASSERT_EQ(features[n].radius_m, expected[n].radius_m);
  }
}

// Sizes of nothing: noise without amplitude and features of no height leave one height, and no -0.
TEST(ProceduralSurface, NothingIsNothing) {
  Feature hill{FeatureKind::hill, {3, 4}, 10, -0.0};
  const ProceduralSurface surface{1, {-0.0, 0, 100, 0.5, 3}, {&hill, 1}, {}};
  std::vector<std::uint32_t> near(3);
  std::vector<float> out(25);
  procedural_heights(surface, {-2, -2, 1, 5, 5, 1}, near, out);
  for (const float v : out) {
    EXPECT_EQ(v, 0.0f);
    EXPECT_FALSE(std::signbit(v));
  }
}

}  // namespace
}  // namespace karst::core
