// SPDX-License-Identifier: MIT
#include "terrain/basis/basis.h"

#include <cmath>
#include <cstdio>
#include <string>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "terrain/basis/sin_cos.h"
#include "tests/support/any_camera.h"

namespace karst::core {
namespace {

constexpr double kPi = 3.14159265358979323846;

Basis geographic() {
  Basis basis;
  basis.kind = BasisKind::geographic;
  basis.first[0] = 7.0;
  basis.first[1] = 48.0;
  basis.step[0] = 1.0 / 3600;
  basis.step[1] = -1.0 / 3600;
  basis.anchor_deg[0] = 7.5;
  basis.anchor_deg[1] = 47.5;
  basis.height_unit_m = 1.0 / 1024;
  EXPECT_TRUE(basis.finish().ok());
  return basis;
}

Basis cube(std::int32_t quads) {
  Basis basis;
  basis.kind = BasisKind::cube;
  basis.centred = true;
  basis.face_quads = quads;
  EXPECT_TRUE(basis.finish().ok());
  return basis;
}

Basis cylinder(double radius_m) {
  Basis basis;
  basis.kind = BasisKind::cylinder;
  basis.radius_m = radius_m;
  basis.first[0] = -500;
  basis.first[1] = -2000;
  basis.step[0] = basis.step[1] = 1;
  EXPECT_TRUE(basis.finish().ok());
  return basis;
}

TEST(Basis, SinesAreThoseOfTheLibrary) {
  double most = 0;
  for (int n = -72'000; n <= 72'000; ++n) {
    const double degrees = n * 0.0101;
    const SinCos at = plain_sin_cos_deg(degrees);
    most = std::max({most, std::abs(at.sin - std::sin(degrees * kPi / 180)),
                     std::abs(at.cos - std::cos(degrees * kPi / 180))});
    EXPECT_EQ(plain_sin_cos_deg(-degrees).sin, -at.sin);
    EXPECT_EQ(plain_sin_cos_deg(-degrees).cos, at.cos);
  }
  EXPECT_LT(most, 4e-15);
}

// EPSG Guidance Note 7-2, Geographic/geocentric conversions: the worked example, given to 1 mm.
TEST(Basis, PlacesOnWgs84AreThoseOfTheEpsgExample) {
  const Basis basis = cube(4);
  const double latitude = 53 + 48 / 60.0 + 33.820 / 3600, longitude = 2 + 7 / 60.0 + 46.380 / 3600;
  const glm::dvec3 place = place_of(basis, {longitude, latitude, 73.0});
  // The frame of a centred basis is y, z, x.
  EXPECT_NEAR(place.z, 3'771'793.968, 1e-3);
  EXPECT_NEAR(place.x, 140'253.342, 1e-3);
  EXPECT_NEAR(place.y, 5'124'304.349, 1e-3);
  Geodetic back;
  ASSERT_TRUE(geodetic_of(basis, place, back));
  EXPECT_NEAR(back.latitude_deg, latitude, 1e-13);
  EXPECT_NEAR(back.longitude_deg, longitude, 1e-13);
  EXPECT_NEAR(back.altitude_m, 73.0, 1e-8);
}

TEST(Basis, PolesAndEquatorAreExact) {
  const Basis basis = cube(4);
  EXPECT_EQ(place_of(basis, {0, 0, 0}), glm::dvec3(0, 0, kWgs84RadiusM));
  EXPECT_EQ(place_of(basis, {90, 0, 0}), glm::dvec3(kWgs84RadiusM, 0, 0));
  EXPECT_NEAR(place_of(basis, {0, 90, 0}).y, 6'356'752.314245, 1e-6);
  EXPECT_EQ(place_of(basis, {0, 90, 0}).x, 0.0);
}

TEST(Basis, AFrameIsEastUpAndSouthAtItsAnchor) {
  const Basis basis = geographic();
  EXPECT_EQ(place_of(basis, {7.5, 47.5, 0}), glm::dvec3(0.0));
  EXPECT_NEAR(glm::distance(place_of(basis, {7.5, 47.5, 100}), glm::dvec3(0, 100, 0)), 0.0, 2e-9);
  const glm::dvec3 east = place_of(basis, {7.501, 47.5, 0}), south = place_of(basis, {7.5, 47.499, 0});
  EXPECT_GT(east.x, 75.0);
  EXPECT_LT(std::abs(east.y) + std::abs(east.z), 0.002);
  EXPECT_GT(south.z, 111.0);
  EXPECT_LT(std::abs(south.y) + std::abs(south.x), 0.002);
  EXPECT_NEAR(glm::length(up_of(basis, {1000, 2000, 3000})), 1.0, 1e-15);
}

void expect_round_trips(const Basis& basis, const char* name, double i, double k, double wide, double deep,
                        double least_height, double most_height, int seed) {
  test::Random random{static_cast<std::uint64_t>(seed)};
  double most = 0;
  for (int n = 0; n < 20'000; ++n) {
    GridPlace at{i + wide * test::between(random, 0, 1), k + deep * test::between(random, 0, 1),
                 test::between(random, least_height, most_height), 0};
    if (basis.kind == BasisKind::cube) {
      at.face = static_cast<int>(random.next() % 6);
      int x = 0, z = 0;
      cube_cell(at.face, x, z);
      at.i += double(x) * basis.face_quads;
      at.k += double(z) * basis.face_quads;
    }
    const glm::dvec3 place = place_m(basis, at);
    GridPlace back;
    ASSERT_TRUE(grid_of(basis, place, back));
    EXPECT_NEAR(back.height_m, at.height_m, 1e-6);
    most = std::max(most, glm::distance(place_m(basis, back), place));
    // A little higher is that much further along up.
    GridPlace above = at;
    above.height_m += 64;
    EXPECT_NEAR(glm::distance(place_m(basis, above), place + 64.0 * up_at(basis, at)), 0.0, 1e-7);
    EXPECT_NEAR(glm::distance(up_of(basis, place), up_at(basis, at)), 0.0, 1e-9);
  }
  EXPECT_LT(most, 1e-6);
  std::printf("FIGURE %s: round trips within %.3g m\n", name, most);
}

TEST(Basis, RoundTripsAreWithinAMicrometre) {
  expect_round_trips(geographic(), "geographic", 0, 0, 3600, 3600, -11'000, 9'000, 1);
  expect_round_trips(cube(64), "cube", 0, 0, 64, 64, -11'000, 9'000, 2);
  expect_round_trips(cube(64), "cube from 20,000 km", 0, 0, 64, 64, 1e7, 2e7, 3);
  expect_round_trips(cylinder(1000), "cylinder", 0, 0, 6000, 4000, -50, 300, 4);
  expect_round_trips(cylinder(-1000), "cylinder's inside", 0, 0, 6000, 4000, -50, 300, 5);
}

TEST(Basis, ACylindersInsideHasItsUpTowardsTheAxis) {
  const Basis basis = cylinder(-1000);
  const glm::dvec3 axis(0, 1000, 0);
  for (const double i : {0.0, 500.0, 1500.0, 2500.0}) {
    const GridPlace at{i, 2000, 30, 0};
    const glm::dvec3 place = place_m(basis, at);
    EXPECT_NEAR(glm::distance(place + up_at(basis, at) * 970.0, axis), 0.0, 1e-9);
  }
  EXPECT_GT(place_m(basis, {1000, 0, 0, 0}).x, 400);  // east of the middle
}

// Every sample of every edge of the cube's faces is some other face's too, with the same bits.
TEST(Basis, FacesShareTheirEdgesToTheBit) {
  Basis basis = cube(32);
  basis.height_unit_m = 0.125;
  ASSERT_TRUE(basis.finish().ok());
  const auto vertex = [&](int face, std::int64_t i, std::int64_t k) {
    int x = 0, z = 0;
    cube_cell(face, x, z);
    return vertex_place(basis, face, axis_place(basis, 0, face, double(x * 32 + i)),
                        axis_place(basis, 1, face, double(z * 32 + k)), 12'345.0);
  };
  int shared = 0;
  for (int face = 0; face < kCubeFaces; ++face) {
    for (int n = 0; n <= 32; ++n) {
      const std::int64_t edges[4][2] = {{0, n}, {32, n}, {n, 0}, {n, 32}};
      for (const auto& at : edges) {
        const glm::i64vec3 own = vertex(face, at[0], at[1]);
        int others = 0;
        for (int other = 0; other < kCubeFaces; ++other) {
          for (int m = 0; m <= 32 && other != face; ++m) {
            const std::int64_t there[4][2] = {{0, m}, {32, m}, {m, 0}, {m, 32}};
            for (const auto& b : there) others += vertex(other, b[0], b[1]) == own ? 1 : 0;
          }
        }
        // A corner is counted by both edges of both other faces.
        EXPECT_EQ(others, n == 0 || n == 32 ? 4 : 1) << face << ' ' << at[0] << ' ' << at[1];
        shared += others;
      }
    }
  }
  EXPECT_GT(shared, 0);
}

// What bases say of how much a quad of theirs bends.
TEST(Basis, QuadsBendNoMoreThanStated) {
  struct Case {
    const char* name;
    Basis basis;
    double i, k, wide, deep;
  };
  Basis globe = geographic();
  globe.first[0] = -180;
  globe.first[1] = 90;
  globe.step[0] = 1;
  globe.step[1] = -1;
  ASSERT_TRUE(globe.finish().ok());
  const Case cases[] = {{"geographic", globe, 0, 0, 360, 180},
                        {"cube", cube(128), 0, 0, 128, 128},
                        {"cylinder", cylinder(500), 0, 0, 3000, 10},
                        {"cylinder's inside", cylinder(-500), 0, 0, 3000, 10}};
  test::Random random{7};
  for (const Case& c : cases) {
    double bend = 0, turn = 0;
    for (int n = 0; n < 30'000; ++n) {
      GridPlace at{c.i + std::floor(test::between(random, 0, c.wide - 1)),
                   c.k + std::floor(test::between(random, 0, c.deep - 1)), 0, 0};
      if (c.basis.kind == BasisKind::cube) {
        at.face = n % 6;
        int x = 0, z = 0;
        cube_cell(at.face, x, z);
        at.i += x * 128.0;
        at.k += z * 128.0;
      }
      // Any point of one of a quad's triangles, on either diagonal.
      double u = test::between(random, 0, 1), v = test::between(random, 0, 1);
      const bool other = n % 2 == 0;
      const auto corner = [&](double i, double k) {
        return place_m(c.basis, {at.i + (other ? 1 - i : i), at.k + k, 0, at.face});
      };
      const bool upper = u + v < 1;
      const glm::dvec3 flat =
          upper ? corner(0, 0) + u * (corner(1, 0) - corner(0, 0)) + v * (corner(0, 1) - corner(0, 0))
                : corner(1, 1) + (1 - u) * (corner(0, 1) - corner(1, 1)) +
                      (1 - v) * (corner(1, 0) - corner(1, 1));
      bend = std::max(bend, glm::distance(flat, corner(u, v)));
      const glm::dvec3 up = up_at(c.basis, {at.i + u, at.k + v, 0, at.face});
      turn = std::max(turn, glm::distance(up, up_at(c.basis, {at.i, at.k, 0, at.face})));
    }
    EXPECT_LE(bend, c.basis.sagitta_m * 1.000001) << c.name;
    EXPECT_LE(turn, c.basis.turn_rad * 1.000001) << c.name;
    EXPECT_GE(bend, c.basis.sagitta_m * 0.4) << c.name;
    std::printf("FIGURE %s: a quad bends by %.3f of what is stated, up by %.3f\n", c.name,
                bend / c.basis.sagitta_m, turn / c.basis.turn_rad);
  }
}

TEST(Basis, RefusesWhatIsNoBasis) {
  const auto field = [](auto change) {
    Basis basis = geographic();
    change(basis);
    return std::string(basis.finish().field());
  };
  EXPECT_EQ(field([](Basis& b) { b.height_unit_m = 0; }), "height_unit_m");
  EXPECT_EQ(field([](Basis& b) { b.base_m = NAN; }), "base_m");
  EXPECT_EQ(field([](Basis& b) { b.radius_m = -5; }), "radius_m");
  EXPECT_EQ(field([](Basis& b) { b.radius_m = 0.5; }), "radius_m");
  EXPECT_EQ(field([](Basis& b) { b.flattening = 0.2; }), "flattening");
  EXPECT_EQ(field([](Basis& b) { b.first[1] = 91; }), "first");
  EXPECT_EQ(field([](Basis& b) { b.step[1] = 0.1; }), "first");
  EXPECT_EQ(field([](Basis& b) { b.step[0] = 0; }), "first");
  EXPECT_EQ(field([](Basis& b) { b.anchor_deg[1] = -91; }), "anchor_deg");
  EXPECT_EQ(field([](Basis& b) { b.kind = BasisKind::function; }), "first");
  EXPECT_EQ(field([](Basis& b) {
              b.kind = BasisKind::function;
              b.function.up = [](const void*, double, double) { return glm::dvec3(0, 1, 0); };
            }),
            "function");
  EXPECT_EQ(field([](Basis& b) {
              b.kind = BasisKind::cube;
              b.face_quads = 12;
            }),
            "face_quads");
}

}  // namespace
}  // namespace karst::core
