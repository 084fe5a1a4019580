// SPDX-License-Identifier: MIT
// Queries: bad input, what is ready and what is not, the cache, several threads, picking.
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "terrain/base/budget.h"
#include "tests/support/heap_count.h"
#include "tests/support/loaded_parts.h"
#include "tests/support/query_world.h"

namespace karst::core {
namespace {

using test::Random;
using test::TestQuery;
using test::TestQueryWorld;
using test::TestWorld;
using test::TriangleSoup;

void expect_same(const std::vector<QueryHit>& a, const std::vector<QueryHit>& b) {
  EXPECT_EQ(a.size(), b.size());
  EXPECT_EQ(test::first_difference(a, b), a.size());
}

TEST(Query, TakesWhatItCounts) {
  Query::Limits limits;
  Budget budget;
  Query::add_to(budget, limits);
  EXPECT_LE(budget.bytes(Consumer::queries), 128u * 1024 + 32'768);
  test::AlignedBytes memory(budget.cpu_bytes());
  Arena arena(memory.bytes());
  Query query;
  ASSERT_TRUE(query.create(limits, arena).ok());
  EXPECT_EQ(arena.used(), budget.cpu_bytes());
  Query late;
  EXPECT_EQ(late.create(limits, arena).code(), StatusCode::limit_reached);
  const struct {
    Query::Limits limits;
    const char* field;
  } bad[] = {{{{0, 128, 5}, {}}, "query_level"},
             {{{7, 128, 6}, {}}, "query_level"},
             {{{3, 0, 5}, {}}, "query_patches"},
             {{{3, 128, 2}, {}}, "max_level"},
             {{{3, 128, 7}, {}}, "max_level"}};
  for (const auto& b : bad) {
    Arena room(memory.bytes());
    EXPECT_STREQ(Query().create(b.limits, room).field(), b.field);
  }
}

TEST(Query, RefusesWorldsThatDoNotFit) {
  const TestWorld world = test::rolling_world();
  const TestQueryWorld lent(world);
  TestQuery query(lent.held(), 3, 16);
  QueryWorld bad = lent.held();
  bad.bounds = bad.bounds.first(1);
  EXPECT_STREQ(query->set_world(bad).field(), "bounds");
  QueryHit hit;
  EXPECT_FALSE(query->ground({12, 9, 12}, 0, Wait::never, hit));  // there is no world now
  bad = lent.held();
  bad.tree = nullptr;
  EXPECT_STREQ(query->set_world(bad).field(), "tree");
  bad = lent.read();
  bad.source = {};
  EXPECT_STREQ(query->set_world(bad).field(), "heights");
  ASSERT_TRUE(query->set_world(lent.held()).ok());
  EXPECT_TRUE(query->ground({12, 9, 12}, 0, Wait::never, hit));
}

TEST(Query, BadPlacesFindNothing) {
  const TestWorld world = test::rolling_world();
  const TestQueryWorld lent(world);
  TestQuery query(lent.held(), 3, 16);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  QueryHit hit;
  PickedVoxel picked;
  const glm::dvec3 good(12.3, 9, 12.1);
  ASSERT_TRUE(query->ray(good, good - glm::dvec3(0, 9, 0), Wait::never, hit));
  for (const double v : {nan, inf, -inf, 1e300, 2 * Query::kReach}) {
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 bad = good;
      bad[axis] = v;
      EXPECT_FALSE(query->ray(bad, good, Wait::for_file, hit));
      EXPECT_FALSE(query->ray(good, bad, Wait::for_file, hit));
      EXPECT_FALSE(hit.found());
      EXPECT_FALSE(query->sphere(bad, good, 1, Wait::for_file, hit));
      EXPECT_FALSE(query->sphere(good, bad, 1, Wait::for_file, hit));
      EXPECT_FALSE(query->ground(bad, 1, Wait::for_file, hit));
      EXPECT_FALSE(query->inside(bad, Wait::for_file));
      EXPECT_EQ(query->column(bad, Wait::for_file, {&hit, 1}), 0u);
      EXPECT_STREQ(query->prepare(bad, 1).field(), "place");
      EXPECT_FALSE(pick_voxel(world.octree(), bad, good, 3, picked));
    }
    EXPECT_FALSE(query->ground(good, v, Wait::for_file, hit));
    EXPECT_FALSE(query->sphere(good, good, v, Wait::for_file, hit));
    EXPECT_STREQ(query->prepare(good, v).field(), "radius");
  }
  EXPECT_FALSE(query->sphere(good, good, -1, Wait::for_file, hit));
  EXPECT_FALSE(query->ray(good, good, Wait::for_file, hit));
  // Beside the world, above it, and far away towards it.
  EXPECT_FALSE(query->ground({-50, 9, 12}, 1, Wait::for_file, hit));
  EXPECT_FALSE(query->inside({-50, 1, 12}, Wait::for_file));
  EXPECT_FALSE(query->ray({-50, 500, 12}, {50, 500, 12}, Wait::for_file, hit));
  EXPECT_TRUE(query->ray({12, 1e8, 12}, {12, -1e8, 12}, Wait::for_file, hit));
  EXPECT_NEAR(hit.place.y + hit.distance, 1e8, 1e-6);
  EXPECT_TRUE(query->inside({12, -3, 12}, Wait::for_file));
  EXPECT_FALSE(pick_voxel(world.octree(), good, good, 3, picked));
  EXPECT_FALSE(pick_voxel(world.octree(), good, {12, 0, 12}, -1, picked));
  EXPECT_FALSE(pick_voxel(world.octree(), good, {12, 0, 12}, world.octree().depth() + 1, picked));
}

TEST(Query, AnEmptyWorldHasNoSurface) {
  const TestWorld world({4, 4, 4}, [](glm::ivec3) { return true; });
  TestWorld air({4, 4, 4}, [](glm::ivec3) { return false; });
  BoundsTree tree;
  tree.create({});
  QueryWorld nothing;
  nothing.tree = &tree;
  nothing.heights.level = 4;
  ASSERT_TRUE(tree.build({}, {}).ok());
  TestQuery query(nothing, 3, 4);
  QueryHit hit;
  EXPECT_FALSE(query->ground({2, 9, 2}, 0, Wait::for_file, hit));
  EXPECT_FALSE(query->ray({2, 9, 2}, {2, -9, 2}, Wait::for_file, hit));
  EXPECT_TRUE(query->prepare({2, 2, 2}, 10).ok());
}

// The cache changes no answer, whether heights are in memory or read, however little room there is.
TEST(Query, AnswersDoNotDependOnTheCache) {
  const TestWorld world = test::rolling_world();
  const TestQueryWorld lent(world);
  TestQuery all(lent.held(), 3, 4096);
  const std::vector<QueryHit> expected = test::ask_all(*all, Wait::for_file, 1, 300);
  for (const std::uint32_t patches : {1u, 2u, 5u, 64u}) {
    TestQuery few(lent.held(), 3, patches);
    expect_same(test::ask_all(*few, Wait::for_file, 1, 300), expected);
    TestQuery reading(lent.read(), 3, patches);
    expect_same(test::ask_all(*reading, Wait::for_file, 1, 300), expected);
  }
  // Heights in memory need no file: never is as good.
  TestQuery never(lent.held(), 3, 64);
  expect_same(test::ask_all(*never, Wait::never, 1, 300), expected);
}

TEST(Query, WaitNeverTouchesNoFileAndSaysItsLevel) {
  const TestWorld world = test::rolling_world();
  const TestQueryWorld lent(world);
  TestQuery query(lent.read(), 3, 4096);
  const TriangleSoup undisplaced(world, 1, false);
  Random random{3};
  int met = 0;
  for (int n = 0; n < 500; ++n) {
    const auto place = [&] {
      return glm::dvec3(random.unit(), random.unit(), random.unit()) * glm::dvec3(24, 10, 24);
    };
    const glm::dvec3 from = place();
    const glm::dvec3 to = place();
    QueryHit hit;
    const auto expected = undisplaced.ray(from, to);
    ASSERT_EQ(query->ray(from, to, Wait::never, hit), expected.triangle != nullptr);
    if (!hit.found()) continue;
    ++met;
    EXPECT_NEAR(hit.distance, expected.at, 1.0 / kStepsPerVoxel);
    EXPECT_EQ(hit.level, 0);
    EXPECT_TRUE(hit.coarse);
  }
  EXPECT_GT(met, 100);
  EXPECT_EQ(lent.reads(), 0u);
  // What is ready is met as it is.
  ASSERT_TRUE(query->prepare({12, 4, 12}, 40).ok());
  EXPECT_GT(lent.reads(), 0u);
  EXPECT_EQ(query->groups_read(), lent.reads());
  const std::uint32_t reads = lent.reads();
  TestQuery held(lent.held(), 3, 4096);
  expect_same(test::ask_all(*query, Wait::never, 4, 200), test::ask_all(*held, Wait::for_file, 4, 200));
  expect_same(test::ask_all(*query, Wait::for_file, 4, 200), test::ask_all(*held, Wait::for_file, 4, 200));
  EXPECT_EQ(lent.reads(), reads);
}

TEST(Query, HeightsThatCannotBeReadAreAnsweredCoarsely) {
  const TestWorld world = test::rolling_world();
  TestQueryWorld lent(world);
  lent.fail(true);
  TestQuery query(lent.read(), 3, 64);
  QueryHit hit;
  query->ground({12.2, 9, 12.1}, 0, Wait::for_file, hit);
  EXPECT_GT(query->failed_reads(), 0u);
  EXPECT_EQ(query->trouble().code(), StatusCode::io);
  EXPECT_TRUE(hit.coarse || !hit.found());
  EXPECT_EQ(query->prepare({12, 4, 12}, 3).code(), StatusCode::io);
  lent.fail(false);
  ASSERT_TRUE(query->ground({12.2, 9, 12.1}, 0, Wait::for_file, hit));
  EXPECT_EQ(hit.level, 3);
}

TEST(Query, PrepareMakesTheNearestReadyWhereThereIsNoRoomForAll) {
  const TestWorld world = test::rolling_world();
  const TestQueryWorld lent(world);
  TestQuery query(lent.read(), 3, 40);
  const glm::dvec3 place(12, 4, 12);
  const Status status = query->prepare(place, 40);
  EXPECT_EQ(status.code(), StatusCode::limit_reached);
  EXPECT_STREQ(status.field(), "query_patches");
  EXPECT_EQ(status.value(), world.surface().patches.size());
  const std::uint32_t reads = lent.reads();
  QueryHit hit;
  ASSERT_TRUE(query->ground({12, 9, 12}, 0, Wait::never, hit));
  EXPECT_EQ(hit.level, 3);
  ASSERT_TRUE(query->ground({2, 9, 2}, 0, Wait::never, hit));
  EXPECT_EQ(hit.level, 0);
  EXPECT_EQ(lent.reads(), reads);
}

TEST(Query, TakesNoMemoryAfterItWasMade) {
  const TestWorld world = test::rolling_world();
  const TestQueryWorld lent(world);
  TestQuery query(lent.read(), 3, 20);
  std::vector<glm::dvec3> from, to;
  for (int n = 0; n < 100; ++n) {
    from.emplace_back(0.2 * n, 9, 3);
    to.emplace_back(3, 0, 0.2 * n);
  }
  std::vector<QueryHit> hits(from.size());
  const std::uint64_t before = test::heap_calls();
  EXPECT_FALSE(query->prepare({12, 4, 12}, 40).ok());
  query->rays(from, to, Wait::for_file, hits);
  QueryHit hit;
  query->sphere(from[1], to[1], 0.5, Wait::for_file, hit);
  query->column({12, 3, 12}, Wait::for_file, hits);
  EXPECT_EQ(test::heap_calls(), before);
}

// Against every voxel of the level that holds something filled.
TEST(PickVoxel, FindsTheNearestOfALevel) {
  const TestWorld world = TestWorld::noise(7, {16, 12, 16}, 0.3, 2.0, false);
  const Octree& tree = world.octree();
  Random random{1};
  int found = 0;
  for (int n = 0; n < 300; ++n) {
    const auto place = [&] { return 24.0 * glm::dvec3(random.unit(), random.unit(), random.unit()) - 4.0; };
    const glm::dvec3 from = place();
    glm::dvec3 to = place();
    if (n % 5 == 0) to[n % 3] = from[n % 3];
    const int level = n % (tree.depth() + 1);
    const std::int32_t size = tree.size() >> level;
    double nearest = 2.0;
    const auto enters = [&](glm::ivec3 v, double& first) {
      double last = 1.0;
      first = 0.0;
      for (int axis = 0; axis < 3; ++axis) {
        const double way = to[axis] - from[axis];
        if (way == 0.0) {
          if (from[axis] < v[axis] || from[axis] > v[axis] + size) return false;
          continue;
        }
        const double a = (v[axis] - from[axis]) / way;
        const double b = (v[axis] + size - from[axis]) / way;
        first = std::max(first, std::min(a, b));
        last = std::min(last, std::max(a, b));
      }
      return first <= last;
    };
    const auto holds = [&](glm::ivec3 v) {
      bool any = false;
      for (int z = 0; z < size; ++z) {
        for (int y = 0; y < size; ++y) {
          for (int x = 0; x < size; ++x) any = any || tree.filled(v + glm::ivec3(x, y, z));
        }
      }
      return any;
    };
    for (int z = 0; z < tree.size(); z += size) {
      for (int y = 0; y < tree.size(); y += size) {
        for (int x = 0; x < tree.size(); x += size) {
          double first = 0;
          if (enters({x, y, z}, first) && first < nearest && holds({x, y, z})) nearest = first;
        }
      }
    }
    PickedVoxel picked;
    ASSERT_EQ(pick_voxel(tree, from, to, level, picked), nearest <= 1.0) << n;
    if (nearest > 1.0) continue;
    ++found;
    EXPECT_NEAR(picked.distance, nearest * glm::length(to - from), 1e-9);
    EXPECT_EQ(picked.voxel.level(), level);
    const glm::ivec3 corner = picked.voxel.min_corner(tree.depth());
    EXPECT_TRUE(holds(corner));
    double first = 0;
    EXPECT_TRUE(enters(corner, first));
    EXPECT_NEAR(first, nearest, 1e-9);
    if (picked.has_before) {
      const glm::ivec3 d = picked.before.min_corner(tree.depth()) - corner;
      EXPECT_EQ(std::abs(d.x) + std::abs(d.y) + std::abs(d.z), size);
    }
  }
  EXPECT_GT(found, 150);
}

}  // namespace
}  // namespace karst::core
