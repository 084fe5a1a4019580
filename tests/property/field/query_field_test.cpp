// SPDX-License-Identifier: MIT
// Queries of fields against all triangles of their finest level, one by one in double; beside voxels, and
// where a field lies anywhere.
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "terrain/base/lattice.h"
#include "tests/support/field_mesh.h"
#include "tests/support/query_world.h"

namespace karst::core {
namespace {

using test::Random;
using test::TestQuery;
using test::TestQueryWorld;
using test::TriangleSoup;

constexpr double kStep = 1.0 / kStepsPerVoxel;  // voxels

struct Case {
  std::uint64_t seed;
  int bits, cell_log2;
  glm::ivec3 corner, blocks;
};
constexpr Case kCases[] = {{1, 8, 13, {0, 0, 0}, {2, 2, 2}},
                           {2, 16, 13, {3, 1, 7}, {2, 1, 3}},
                           {3, 8, 11, {100, 20, 5}, {2, 3, 2}},
                           {4, 16, 10, {200, 0, 121}, {2, 2, 2}}};

// Lumps and tunnels; those of odd seeds white noise here and there.
test::FieldShape lumps(std::uint64_t seed) {
  return [seed](glm::dvec3 p) {
    const double smooth = 6 * test::value_noise(seed, p / 9.0);
    return seed % 2 == 1 && p.x > 12 ? smooth + 3 * test::value_noise(seed + 9, p) : smooth;
  };
}

// Without any voxels.
QueryWorld no_voxels() {
  static const BoundsTree tree;
  QueryWorld world;
  world.tree = &tree;
  world.heights.level = 3;
  return world;
}

// All triangles; those without area are left out.
TriangleSoup field_soup(const FieldBlocks& field) {
  std::vector<test::SoupTriangle> triangles;
  test::each_field_triangle(field, [&](const std::array<glm::ivec3, 3>& c) {
    test::SoupTriangle t{{}, QueryHit::kField};
    for (std::size_t k = 0; k < 3; ++k) t.corner[k] = glm::dvec3(c[k]) / double{kStepsPerVoxel};
    if (glm::length(glm::cross(t.corner[1] - t.corner[0], t.corner[2] - t.corner[0])) > 0)
      triangles.push_back(t);
  });
  return TriangleSoup(std::move(triangles));
}

struct Asked {
  explicit Asked(const Case& c) : own(info_of(c), 64), query(no_voxels(), 3, 16) {
    own.fill(lumps(c.seed));
    soup = field_soup(own.field);
    query->set_field(&own.field);
    low = glm::dvec3(own.field.info().corner);
    size = glm::dvec3(own.field.info().drawn_steps()) * kStep;
  }
  static FieldInfo info_of(const Case& c) {
    FieldInfo info = test::field_info(c.blocks, 0);
    info.corner = c.corner;
    info.cell_log2 = c.cell_log2;
    info.sample_bits = c.bits;
    return info;
  }
  glm::dvec3 place(Random& random) const {
    return low + size * (1.2 * glm::dvec3(random.unit(), random.unit(), random.unit()) - 0.1);
  }
  test::OwnField own;
  TestQuery query;
  TriangleSoup soup{std::vector<test::SoupTriangle>()};
  glm::dvec3 low, size;
};

void expect_on_surface(const QueryHit& hit, const test::SoupTriangle& triangle) {
  EXPECT_LT(test::triangle_distance(hit.place, triangle), kStep);
  EXPECT_LT(glm::length(hit.normal - triangle.normal()), 1e-9);
  EXPECT_EQ(hit.patch, QueryHit::kField);
  EXPECT_FALSE(hit.coarse);
}

TEST(QueryField, ColumnsGroundAndInside) {
  std::size_t most = 0;
  int in = 0, found = 0;
  for (const Case& c : kCases) {
    Asked asked(c);
    ASSERT_GT(asked.soup.triangles().size(), 500u);
    Random random{c.seed};
    std::vector<QueryHit> hits(64);
    for (int n = 0; n < 300; ++n) {
      const glm::dvec3 place = asked.place(random);
      const auto expected = asked.soup.column(place.x, place.z);
      ASSERT_EQ(asked.query->column(place, Wait::never, hits), expected.size()) << n;
      most = std::max(most, expected.size());
      for (std::size_t k = 0; k < expected.size(); ++k) {
        EXPECT_NEAR(hits[k].place.y, expected[k].at, kStep);
        EXPECT_NEAR(hits[k].distance, place.y - expected[k].at, kStep);
        expect_on_surface(hits[k], *expected[k].triangle);
      }
      const int winding = asked.soup.winding(place);
      ASSERT_EQ(asked.query->inside(place, Wait::never), winding > 0);
      in += winding > 0;
      const double step = random.unit();
      const TriangleSoup::Crossing* ground = nullptr;
      for (const auto& crossing : expected) {
        if (crossing.at > place.y + step || crossing.triangle->normal().y <= 0) continue;
        ground = &crossing;
        break;
      }
      QueryHit hit;
      ASSERT_EQ(asked.query->ground(place, step, Wait::never, hit), ground != nullptr);
      if (ground == nullptr) continue;
      ++found;
      EXPECT_NEAR(hit.place.y, ground->at, kStep);
      expect_on_surface(hit, *ground->triangle);
    }
  }
  EXPECT_GE(most, 4u);
  EXPECT_GT(in, 100);
  EXPECT_GT(found, 200);
}

TEST(QueryField, RaysMeetTheFirstTriangle) {
  int met = 0, free = 0;
  for (const Case& c : kCases) {
    Asked asked(c);
    Random random{c.seed + 10};
    for (int n = 0; n < 200; ++n) {
      const glm::dvec3 from = asked.place(random);
      glm::dvec3 to = asked.place(random);
      if (n % 5 == 1) to = from + (to - from) * 0.05;    // short
      if (n % 5 == 2) to = from + (to - from) * 300.0;   // far beyond
      if (n % 5 == 3) to[n / 5 % 3] = from[n / 5 % 3];   // in a plane of the axes
      if (n % 5 == 4) to = from, to[n / 5 % 3] += 60.0;  // along an axis
      const TriangleSoup::Crossing expected = asked.soup.ray(from, to);
      QueryHit hit;
      ASSERT_EQ(asked.query->ray(from, to, Wait::never, hit), expected.triangle != nullptr)
          << c.seed << ' ' << n;
      if (expected.triangle == nullptr) {
        ++free;
        continue;
      }
      ++met;
      EXPECT_NEAR(hit.distance, expected.at, kStep * std::max(1.0, 1e-6 * glm::length(to - from)));
      EXPECT_LT(test::triangle_distance(hit.place, *expected.triangle), kStep);
    }
  }
  EXPECT_GT(met, 200);
  EXPECT_GT(free, 60);
}

TEST(QueryField, NoRaySlipsThroughWhereTrianglesMeet) {
  test::OwnField own(test::field_info(glm::ivec3(2), 0), 8);
  own.fill([](glm::dvec3 p) {
    return glm::length(p - glm::dvec3(15.2, 16.4, 15.7)) - 9 + 2 * test::value_noise(3, p / 3.0);
  });
  TestQuery query(no_voxels(), 3, 16);
  query->set_field(&own.field);
  const glm::dvec3 inside(15.3, 16.2, 15.9);
  ASSERT_TRUE(query->inside(inside, Wait::never));
  std::size_t asked = 0;
  QueryHit hit;
  const auto soup = field_soup(own.field);
  for (const test::SoupTriangle& t : soup.triangles()) {
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 corner = t.corner[k], middle = 0.5 * (corner + t.corner[(k + 1) % 3]);
      for (const glm::dvec3& at : {corner, middle}) {
        ASSERT_TRUE(query->ray(inside, inside + 8.0 * (at - inside), Wait::never, hit)) << asked;
        ASSERT_TRUE(query->ray(inside + 8.0 * (at - inside), inside, Wait::never, hit)) << asked;
        ++asked;
      }
    }
  }
  EXPECT_GT(asked, 5'000u);
}

TEST(QueryField, SpheresTouchWhatIsNearestOnTheirWay) {
  int met = 0, touching = 0;
  for (const Case& c : kCases) {
    Asked asked(c);
    Random random{c.seed + 20};
    for (int n = 0; n < 15; ++n) {
      const glm::dvec3 from = asked.place(random);
      const glm::dvec3 to = n % 6 == 0 ? from : asked.place(random);
      const double radius = random.unit() * (n % 4 == 0 ? 3.0 : 0.7);
      const TriangleSoup::Crossing expected = asked.soup.sphere(from, to, radius);
      QueryHit hit;
      ASSERT_EQ(asked.query->sphere(from, to, radius, Wait::never, hit), expected.triangle != nullptr)
          << c.seed << ' ' << n;
      if (expected.triangle == nullptr) continue;
      ++met;
      touching += hit.distance == 0;
      EXPECT_NEAR(hit.distance, expected.at, 2 * kStep);
    }
  }
  EXPECT_GT(met, 25);
  EXPECT_GT(touching, 2);
}

TEST(QueryField, WhatIsNearerOfVoxelsAndOfAFieldIsMet) {
  const test::TestWorld world = test::rolling_world();
  const TestQueryWorld lent(world);
  TestQuery query(lent.held(), 3, 16);
  QueryHit below, hit;
  const glm::dvec3 high(12.3, 40, 12.1), low(12.3, 0, 12.1);
  ASSERT_TRUE(query->ray(high, low, Wait::never, below));
  FieldInfo info = test::field_info(glm::ivec3(1), 0);
  info.corner = {5, 14, 5};
  test::OwnField own(info, 1);
  own.fill([](glm::dvec3 p) { return glm::length(p - 8.0) - 4; });
  query->set_field(&own.field);
  ASSERT_TRUE(query->ray(high, low, Wait::never, hit));
  EXPECT_EQ(hit.patch, QueryHit::kField);
  EXPECT_NEAR(hit.place.y, 25.8, 0.1);
  ASSERT_TRUE(query->ray(low - glm::dvec3(0, 5, 0), high, Wait::never, hit));
  EXPECT_NE(hit.patch, QueryHit::kField);
  std::vector<QueryHit> column(8);
  EXPECT_EQ(query->column(high, Wait::never, column), 3u);
  query->set_field(nullptr);
  ASSERT_TRUE(query->ray(high, low, Wait::never, hit));
  EXPECT_EQ(hit.place, below.place);
}

}  // namespace
}  // namespace karst::core
