// SPDX-License-Identifier: MIT
// Queries against all triangles of the level, one by one in double, on worlds with caves, arches and rough
// heights.
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "terrain/base/lattice.h"
#include "tests/support/query_world.h"

namespace karst::core {
namespace {

using test::Random;
using test::TestQuery;
using test::TestQueryWorld;
using test::TestWorld;
using test::TriangleSoup;

constexpr double kStep = 1.0 / kStepsPerVoxel;  // voxels

// Hills with caves in them and arches over them.
TestWorld make_world(std::uint64_t seed) {
  const glm::ivec3 extent(10, 9, 10);
  TestWorld world(extent, [=](glm::ivec3 v) {
    const double hill = 3.5 + 2.0 * test::value_noise(seed, glm::dvec3(v.x, 0, v.z) / 5.0);
    const bool cave = test::value_noise(seed + 1, glm::dvec3(v) / 3.0) > 0.45;
    const bool arch = v.y == 7 && (v.x + v.z) % 9 == 4;
    return v.y == 0 || arch || (v.y < hill && !cave);
  });
  // Rough but without folds; every third world white.
  if (seed % 3 == 0) {
    world.roughen(4, seed, 300);
  } else {
    world.set_heights(4, [seed](glm::dvec3 p) { return 2500.0 * test::value_noise(seed + 2, 2.0 * p); });
  }
  return world;
}

struct Asked {
  TestWorld world;
  TestQueryWorld lent;
  TriangleSoup soup;

  Asked(std::uint64_t seed, int level) : world(make_world(seed)), lent(world), soup(world, level) {}

  glm::dvec3 place(Random& random) const {
    const glm::dvec3 size(world.extent());
    return glm::dvec3(random.unit(), random.unit(), random.unit()) * (size + 2.0) - 1.0;
  }
};

struct Case {
  std::uint64_t seed;
  int level;
  std::uint32_t patches;
};
constexpr Case kCases[] = {{1, 3, 4096}, {2, 3, 7}, {3, 3, 1}, {4, 1, 64}, {5, 2, 64}, {6, 4, 4096}};

void expect_on_surface(const QueryHit& hit, const test::SoupTriangle& triangle) {
  EXPECT_LT(test::triangle_distance(hit.place, triangle), kStep);
  EXPECT_LT(glm::length(hit.normal - triangle.normal()), 1e-9);
  EXPECT_EQ(hit.patch, triangle.patch);
}

TEST(Query, ColumnsAreCompleteAndInOrder) {
  std::size_t most = 0;
  for (const Case& c : kCases) {
    const Asked asked(c.seed, c.level);
    TestQuery query(asked.lent.held(), c.level, c.patches);
    Random random{c.seed};
    std::vector<QueryHit> hits(64);
    for (int n = 0; n < 400; ++n) {
      const glm::dvec3 place = asked.place(random);
      const auto expected = asked.soup.column(place.x, place.z);
      const std::uint32_t count = query->column(place, Wait::for_file, hits);
      ASSERT_EQ(count, expected.size()) << place.x << ' ' << place.z;
      most = std::max(most, expected.size());
      for (std::size_t k = 0; k < count; ++k) {
        EXPECT_NEAR(hits[k].place.y, expected[k].at, kStep);
        EXPECT_NEAR(hits[k].distance, place.y - expected[k].at, kStep);
        EXPECT_EQ(hits[k].level, c.level);
        expect_on_surface(hits[k], *expected[k].triangle);
      }
      // Only as many as there is room for, and those from the top.
      std::vector<QueryHit> few(2);
      EXPECT_EQ(query->column(place, Wait::for_file, few), count);
      for (std::size_t k = 0; k < std::min<std::size_t>(2, count); ++k)
        EXPECT_EQ(few[k].place.y, hits[k].place.y);
    }
  }
  EXPECT_GE(most, 5u);
}

TEST(Query, GroundIsTheHighestThatFacesUpAndIsNotAboveTheStep) {
  for (const Case& c : kCases) {
    const Asked asked(c.seed, c.level);
    TestQuery query(asked.lent.held(), c.level, c.patches);
    Random random{c.seed + 100};
    int found = 0;
    for (int n = 0; n < 400; ++n) {
      const glm::dvec3 place = asked.place(random);
      const double step = random.unit();
      const TriangleSoup::Crossing* expected = nullptr;
      const auto column = asked.soup.column(place.x, place.z);
      for (const auto& crossing : column) {
        if (crossing.at > place.y + step || crossing.triangle->normal().y <= 0) continue;
        expected = &crossing;
        break;
      }
      QueryHit hit;
      ASSERT_EQ(query->ground(place, step, Wait::for_file, hit), expected != nullptr);
      if (expected == nullptr) continue;
      ++found;
      EXPECT_NEAR(hit.place.y, expected->at, kStep);
      EXPECT_NEAR(hit.distance, place.y - expected->at, kStep);
      expect_on_surface(hit, *expected->triangle);
    }
    EXPECT_GT(found, 100);
  }
}

TEST(Query, InsideIsWhereMoreOfTheSurfaceAboveFacesUp) {
  int in = 0;
  int out = 0;
  for (const Case& c : kCases) {
    const Asked asked(c.seed, c.level);
    TestQuery query(asked.lent.held(), c.level, c.patches);
    Random random{c.seed + 200};
    for (int n = 0; n < 400; ++n) {
      const glm::dvec3 place = asked.place(random);
      const int winding = asked.soup.winding(place);
      ASSERT_EQ(query->inside(place, Wait::for_file), winding > 0);
      (winding > 0 ? in : out)++;
    }
  }
  EXPECT_GT(in, 300);
  EXPECT_GT(out, 300);
}

TEST(Query, RaysMeetTheFirstTriangle) {
  for (const Case& c : kCases) {
    const Asked asked(c.seed, c.level);
    TestQuery query(asked.lent.held(), c.level, c.patches);
    Random random{c.seed + 300};
    std::vector<glm::dvec3> from, to;
    std::vector<QueryHit> one_by_one;
    int found = 0;
    for (int n = 0; n < 200; ++n) {
      from.push_back(asked.place(random));
      to.push_back(asked.place(random));
      // From far away as well, and along an axis.
      if (n % 4 == 1) from.back() += 1000.0 * (from.back() - to.back());
      if (n % 4 == 2) to.back() = from.back() + glm::dvec3(0, 0, 20.0 * (random.unit() - 0.5));
      const auto expected = asked.soup.ray(from.back(), to.back());
      QueryHit hit;
      ASSERT_EQ(query->ray(from.back(), to.back(), Wait::for_file, hit), expected.triangle != nullptr);
      one_by_one.push_back(hit);
      if (expected.triangle == nullptr) continue;
      ++found;
      EXPECT_NEAR(hit.distance, expected.at, kStep);
      expect_on_surface(hit, *expected.triangle);
    }
    EXPECT_GT(found, 50);
    std::vector<QueryHit> hits(from.size());
    query->rays(from, to, Wait::for_file, hits);
    for (std::size_t n = 0; n < hits.size(); ++n) {
      EXPECT_EQ(hits[n].patch, one_by_one[n].patch);
      EXPECT_EQ(hits[n].place, one_by_one[n].place);
      EXPECT_EQ(hits[n].normal, one_by_one[n].normal);
      EXPECT_EQ(hits[n].distance, one_by_one[n].distance);
    }
  }
}

TEST(Query, SpheresTouchWhatIsNearestOnTheirWay) {
  int found = 0;
  int touching = 0;
  for (const Case& c : kCases) {
    const Asked asked(c.seed, std::min(c.level, 2));
    TestQuery query(asked.lent.held(), std::min(c.level, 2), c.patches);
    Random random{c.seed + 400};
    for (int n = 0; n < 32; ++n) {
      const glm::dvec3 from = asked.place(random);
      const glm::dvec3 to = n % 8 == 0 ? from : asked.place(random);
      const double radius = 0.01 + random.unit() * random.unit();
      const auto expected = asked.soup.sphere(from, to, radius);
      QueryHit hit;
      ASSERT_EQ(query->sphere(from, to, radius, Wait::for_file, hit), expected.triangle != nullptr);
      if (expected.triangle == nullptr) continue;
      ++found;
      EXPECT_NEAR(hit.distance, expected.at, kStep);
      const glm::dvec3 centre = from == to ? from : from + hit.distance * glm::normalize(to - from);
      if (expected.at == 0) {
        ++touching;
        double least = 1e9;
        for (const auto& t : asked.soup.triangles())
          least = std::min(least, test::triangle_distance(from, t));
        EXPECT_NEAR(glm::length(hit.place - from), least, kStep);
      } else {
        EXPECT_NEAR(glm::length(hit.place - centre), radius, kStep);
      }
    }
  }
  EXPECT_GT(found, 80);
  EXPECT_GT(touching, 10);
}

// What starts in the rock of a closed surface and ends outside crosses it, wherever it is aimed at.
TEST(Query, RaysDoNotSlipThroughEdgesAndCorners) {
  int asked_rays = 0;
  int through = 0;
  for (const std::uint64_t seed : {11u, 12u, 13u, 14u, 15u}) {
    const TestWorld world = [&] {
      TestWorld w = TestWorld::noise(seed, {8, 8, 8}, 0.5, 2.5, true);
      w.roughen(3, seed, 300);
      return w;
    }();
    const TestQueryWorld lent(world);
    const TriangleSoup soup(world, 3);
    TestQuery query(lent.held(), 3, 4096);
    Random random{seed};
    const auto random_edge = [&](glm::dvec3& a, glm::dvec3& b) {
      const int count = static_cast<int>(soup.triangles().size());
      const auto& t = soup.triangles()[static_cast<std::size_t>(random.below(count))];
      const int k = random.below(3);
      a = t.corner[k];
      b = t.corner[(k + 1) % 3];
      return t;
    };
    for (int n = 0; n < 20'000; ++n, ++asked_rays) {
      glm::dvec3 a, b;
      const auto triangle = random_edge(a, b);
      const glm::dvec3 aim = n % 2 == 0 ? a : a + (n % 4 == 1 ? 0.5 : random.unit()) * (b - a);
      // From just below the aim, or from anywhere in the rock; some along an axis of the lattice.
      glm::dvec3 from = aim - 1e-3 * triangle.normal();
      if (n % 3 == 1) from = 8.0 * glm::dvec3(random.unit(), random.unit(), random.unit());
      if (n % 3 == 2) from = aim + glm::dvec3(n % 9 == 2, n % 9 == 5, n % 9 == 8) * (random.unit() - 0.5);
      if (from == aim || !query->inside(from, Wait::never)) continue;
      const glm::dvec3 to = from + 100.0 * glm::normalize(aim - from);
      QueryHit hit;
      ASSERT_TRUE(query->ray(from, to, Wait::never, hit)) << seed << ", ray " << n;
      ASSERT_TRUE(query->ray(to, from, Wait::never, hit)) << seed << ", ray " << n;
      ++through;
    }
    // Vertical lines through corners: as often into the rock as out of it.
    std::vector<QueryHit> hits(64);
    for (int n = 0; n < 20'000; ++n, ++asked_rays) {
      glm::dvec3 a, b;
      random_edge(a, b);
      const glm::dvec3 aim = n % 2 == 0 ? a : 0.5 * (a + b);
      const std::uint32_t count = query->column(aim, Wait::never, hits);
      ASSERT_EQ(count % 2, 0u);
      int up = 0;
      for (std::uint32_t k = 0; k < count; ++k) up += hits[k].normal.y > 0 ? 1 : -1;
      ASSERT_EQ(up, 0);
      for (std::uint32_t k = 1; k < count; ++k) ASSERT_GE(hits[k - 1].place.y, hits[k].place.y);
    }
  }
  EXPECT_GE(asked_rays, 100'000);
  EXPECT_GE(through, 20'000);
}

}  // namespace
}  // namespace karst::core
