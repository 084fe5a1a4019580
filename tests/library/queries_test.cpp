// SPDX-License-Identifier: MIT
// Queries through the public headers: they agree with each other and with the same world placed otherwise,
// and keep their word about files.
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include <gtest/gtest.h>

#include "tests/library/host.h"
#include "tests/library/vec3.h"

namespace karst {
namespace {

using test::HostWorld;
using test::Random;

double distance(Vec3 a, Vec3 b) {
  return std::sqrt(dot(a - b, a - b));
}

// Queries round places to 2^-22 voxel; the rest is rounding of double far from the zero point.
constexpr double kNear_m = 1e-5;

Needs query_needs(std::uint32_t queries = 2, std::uint32_t patches = 4096) {
  Needs needs;
  needs.queries = queries;
  needs.query_patches = patches;
  return needs;
}

const std::vector<Placement>& placements() {
  static const std::vector<Placement> kAll = [] {
    std::vector<Placement> all;
    for (const Axes axes : {Axes::east_up_south, Axes::east_north_up, Axes::north_east_down}) {
      all.push_back({axes, {}, 0});
      all.push_back({axes, {431'000, -5'200'000, 812.5}, 90});
      all.push_back({axes, {-1234.5, 77, 10}, -33.3});
    }
    return all;
  }();
  return kAll;
}

// A world of a placement with one query; asks in the world's own metres.
class Asker {
 public:
  explicit Asker(Placement placement = {Axes::east_up_south, {}, 0}, Needs needs = query_needs())
      : host(needs, placement) {
    EXPECT_TRUE(host.world->take_query(query).ok());
  }
  ~Asker() { host.world->release(query); }

  Vec3 place(Vec3 world_m) const { return host.world->from_world(world_m); }
  Vec3 direction(Vec3 world) const { return place(world) - place({}); }
  double up(const Hit& hit) const { return dot(hit.normal, direction({0, 1, 0})); }
  // A place in the world's box, a little larger.
  Vec3 somewhere(Random& random) const {
    const WorldInfo& info = host.world->info();
    const Vec3 size = info.high_m - info.low_m;
    const double x = random.unit() * 1.1 - 0.05;
    const double y = random.unit() * 1.4 - 0.2;
    const double z = random.unit() * 1.1 - 0.05;
    return info.low_m + Vec3{size.x * x, size.y * y, size.z * z};
  }

  HostWorld host;
  Query* query = nullptr;
};

TEST(Placements, AreWhatTheirNamesSay) {
  const auto expect_at = [](Placement placement, Vec3 world_m, Vec3 expected) {
    const HostWorld host(query_needs(0), placement);
    const Vec3 at = host.world->from_world(world_m);
    EXPECT_LT(distance(at, expected), 1e-9) << at.x << " " << at.y << " " << at.z;
    EXPECT_LT(distance(host.world->to_world(at), world_m), 1e-9);
  };
  // 3 m east, 5 m up, 7 m south.
  const Vec3 there{3, 5, 7};
  const Vec3 origin{100, 200, 300};
  expect_at({Axes::east_up_south, origin, 0}, there, origin + Vec3{3, 5, 7});
  expect_at({Axes::east_north_up, origin, 0}, there, origin + Vec3{3, -7, 5});
  expect_at({Axes::north_east_down, origin, 0}, there, origin + Vec3{-7, 3, -5});
  // The world's north points to the simulator's east: its east to the south.
  expect_at({Axes::east_up_south, origin, 90}, there, origin + Vec3{-7, 5, 3});
  expect_at({Axes::east_north_up, origin, 90}, there, origin + Vec3{-7, -3, 5});
  expect_at({Axes::north_east_down, origin, 90}, there, origin + Vec3{-3, -7, -5});
  const double half = std::sqrt(0.5);
  expect_at({Axes::east_north_up, origin, 45}, {0, 0, -2}, origin + Vec3{2 * half, 2 * half, 0});
  const double root = std::sqrt(3.0);
  expect_at({Axes::east_north_up, origin, 120}, {0, 0, -2}, origin + Vec3{root, -1, 0});
  expect_at({Axes::east_north_up, origin, 210}, {0, 0, -2}, origin + Vec3{-1, -root, 0});
  expect_at({Axes::east_north_up, origin, -60}, {0, 0, -2}, origin + Vec3{-root, 1, 0});
}

TEST(Queries, AgreeWithEachOtherInAllPlacements) {
  for (const Placement& placement : placements()) {
    SCOPED_TRACE(static_cast<int>(placement.axes) * 1000 + placement.turn_deg);
    const Asker asker(placement);
    Query& query = *asker.query;
    Random random{11};
    int grounds = 0;
    int insides = 0;
    int rays = 0;
    for (int n = 0; n < 300; ++n) {
      const Vec3 at = asker.somewhere(random);
      const Vec3 place = asker.place(at);
      std::array<Hit, 16> column;
      const std::uint32_t count = query.column(place, Wait::for_file, column);
      ASSERT_LE(count, column.size());
      // Sorted, distances below the place, and a winding that tells what is rock.
      int winding = 0;
      const Hit* stands = nullptr;
      for (std::uint32_t k = 0; k < count; ++k) {
        const Vec3 met = asker.host.world->to_world(column[k].place);
        EXPECT_NEAR(met.x, at.x, kNear_m);
        EXPECT_NEAR(met.z, at.z, kNear_m);
        EXPECT_NEAR(column[k].distance, at.y - met.y, kNear_m);
        EXPECT_NEAR(dot(column[k].normal, column[k].normal), 1, 1e-9);
        EXPECT_EQ(column[k].level, 3);
        if (k > 0) {
          EXPECT_GE(column[k].distance, column[k - 1].distance - kNear_m);
        }
        if (column[k].distance < 0) winding += asker.up(column[k]) > 0 ? 1 : -1;
        if (stands == nullptr && column[k].distance >= -0.5 && asker.up(column[k]) > 0) stands = &column[k];
      }
      EXPECT_EQ(query.inside(place, Wait::for_file), winding > 0);
      insides += winding > 0;
      Hit ground;
      ASSERT_EQ(query.ground(place, 0.5, Wait::for_file, ground), stands != nullptr);
      if (stands != nullptr) {
        EXPECT_LT(distance(ground.place, stands->place), kNear_m);
        EXPECT_EQ(ground.patch, stands->patch);
        ++grounds;
      }
      // Straight down from above everything.
      Hit hit;
      const Vec3 top = asker.place({at.x, asker.host.world->info().high_m.y + 1, at.z});
      const Vec3 below = asker.place({at.x, asker.host.world->info().low_m.y - 1, at.z});
      const bool met = query.ray(top, below, Wait::for_file, hit);
      EXPECT_EQ(met, count > 0);
      if (met && count > 0) {
        EXPECT_LT(distance(hit.place, column[0].place), 1e-4);
      }
      // A slanted one, and a sphere that is nearly a point.
      const Vec3 to = asker.place(asker.somewhere(random));
      if (query.ray(place, to, Wait::for_file, hit)) {
        ++rays;
        EXPECT_NEAR(hit.distance, distance(place, hit.place), kNear_m);
        Hit touched;
        ASSERT_TRUE(query.sphere(place, to, 1e-4, Wait::for_file, touched));
        EXPECT_LE(touched.distance, hit.distance + kNear_m);
        ASSERT_TRUE(query.sphere(place, to, 0.4, Wait::for_file, touched));
        EXPECT_LE(touched.distance, hit.distance + kNear_m);
        const double whole = distance(place, to);
        const Vec3 centre = place + (to - place) * (touched.distance / whole);
        EXPECT_LE(distance(centre, touched.place), 0.4 + kNear_m);
        if (touched.distance > 0) {
          EXPECT_GE(distance(centre, touched.place), 0.4 - kNear_m);
        }
      }
    }
    EXPECT_GT(grounds, 100);
    EXPECT_GT(insides, 30);
    EXPECT_GT(rays, 100);
  }
}

TEST(Queries, ManyRaysAreThoseOneByOne) {
  const Asker asker({Axes::east_north_up, {50, -60, 7}, 12});
  Random random{5};
  constexpr std::size_t kRays = 700;  // more than go at a time
  std::vector<Vec3> from(kRays);
  std::vector<Vec3> to(kRays);
  for (std::size_t n = 0; n < kRays; ++n) {
    from[n] = asker.place(asker.somewhere(random));
    to[n] = asker.place(asker.somewhere(random));
  }
  Hit dirty;
  dirty.found = true;
  dirty.level = 77;
  std::vector<Hit> hits(kRays, dirty);
  asker.query->rays(from, to, Wait::for_file, hits);
  int met = 0;
  for (std::size_t n = 0; n < kRays; ++n) {
    Hit one;
    const bool found = asker.query->ray(from[n], to[n], Wait::for_file, one);
    ASSERT_EQ(hits[n].found, found) << n;
    if (!found) continue;
    ++met;
    EXPECT_TRUE(one.found);
    EXPECT_EQ(hits[n].distance, one.distance);
    EXPECT_EQ(hits[n].place.x, one.place.x);
    EXPECT_EQ(hits[n].normal.z, one.normal.z);
    EXPECT_EQ(hits[n].patch, one.patch);
    EXPECT_EQ(hits[n].level, one.level);
  }
  EXPECT_GT(met, 100);
  EXPECT_LT(met, static_cast<int>(kRays) - 30);
}

TEST(Queries, APlacedWorldAnswersAsTheWorldItself) {
  const Asker plain;
  for (const Placement& placement : placements()) {
    SCOPED_TRACE(static_cast<int>(placement.axes) * 1000 + placement.turn_deg);
    const Asker placed(placement);
    // A sphere on an edge has met either triangle: its normal is not compared.
    const auto same = [&](const Hit& a, const Hit& b, bool normals) {
      const Vec3 normal = placed.direction(plain.host.world->to_world(a.normal));
      return distance(placed.host.world->to_world(b.place), plain.host.world->to_world(a.place)) < kNear_m &&
             std::abs(a.distance - b.distance) < kNear_m &&
             (!normals || distance(normal, b.normal) < kNear_m);
    };
    Random random{23};
    int asked = 0;
    int differs = 0;
    for (int n = 0; n < 300; ++n) {
      const Vec3 a = plain.somewhere(random);
      const Vec3 b = plain.somewhere(random);
      const auto compare = [&](bool found, bool other, const Hit& hit, const Hit& placed_hit,
                               bool normals = true) {
        ++asked;
        differs += found != other || (found && !same(hit, placed_hit, normals));
      };
      Hit one;
      Hit two;
      const Wait wait = Wait::for_file;
      bool found = plain.query->ground(plain.place(a), 0.3, wait, one);
      compare(found, placed.query->ground(placed.place(a), 0.3, wait, two), one, two);
      found = plain.query->ray(plain.place(a), plain.place(b), wait, one);
      compare(found, placed.query->ray(placed.place(a), placed.place(b), wait, two), one, two);
      found = plain.query->sphere(plain.place(a), plain.place(b), 0.6, wait, one);
      compare(found, placed.query->sphere(placed.place(a), placed.place(b), 0.6, wait, two), one, two, false);
      ++asked;
      differs += plain.query->inside(plain.place(a), wait) != placed.query->inside(placed.place(a), wait);
      std::array<Hit, 8> of_plain;
      std::array<Hit, 8> of_placed;
      const std::uint32_t count = plain.query->column(plain.place(b), wait, of_plain);
      ++asked;
      if (count != placed.query->column(placed.place(b), wait, of_placed)) {
        ++differs;
      } else {
        for (std::uint32_t k = 0; k < count; ++k) compare(true, true, of_plain[k], of_placed[k]);
      }
      for (const int level : {0, 3, plain.host.world->info().octree_depth}) {
        Voxel picked;
        Voxel placed_picked;
        found = plain.query->pick(plain.place(a), plain.place(b), level, picked);
        ++asked;
        if (found != placed.query->pick(placed.place(a), placed.place(b), level, placed_picked)) {
          ++differs;
        } else if (found) {
          differs += distance(placed.host.world->to_world(placed_picked.centre),
                              plain.host.world->to_world(picked.centre)) > kNear_m ||
                     picked.side_m != placed_picked.side_m || picked.level != placed_picked.level;
        }
      }
    }
    EXPECT_GT(asked, 2500);
    // Places round: what passes an edge may meet the patch on its other side.
    EXPECT_LE(differs, asked / 300);
  }
}

TEST(Queries, PickFindsVoxelsAtTheSurface) {
  const Asker asker({Axes::north_east_down, {5, 6, 7}, 20});
  const WorldInfo& info = asker.host.world->info();
  Random random{3};
  int picked = 0;
  for (int n = 0; n < 200; ++n) {
    const Vec3 at = asker.somewhere(random);
    const Vec3 top = asker.place({at.x, info.high_m.y + 1, at.z});
    const Vec3 bottom = asker.place({at.x, info.low_m.y - 1, at.z});
    Hit hit;
    Voxel voxel;
    if (!asker.query->ray(top, bottom, Wait::for_file, hit)) continue;
    if (!asker.query->pick(top, bottom, info.octree_depth, voxel)) continue;
    ++picked;
    EXPECT_EQ(voxel.side_m, info.voxel_size_m);
    const Vec3 centre = asker.host.world->to_world(voxel.centre);
    EXPECT_LE(std::abs(centre.x - at.x), voxel.side_m / 2 + kNear_m);
    EXPECT_LE(std::abs(centre.z - at.z), voxel.side_m / 2 + kNear_m);
    EXPECT_LE(std::abs(centre.y - asker.host.world->to_world(hit.place).y), 2.5);
  }
  EXPECT_GT(picked, 100);
}

TEST(Queries, ColumnTellsTheUpperOnesOfMany) {
  // Shelves: more surfaces above each other than a column tells.
  test::TestWorld shelves({6, 160, 6}, [](glm::ivec3 v) { return v.y % 2 == 0; });
  shelves.roughen(2, 3, 50);
  const HostWorld host(query_needs(1, 65'536), {}, shelves.file());
  Query* query = nullptr;
  ASSERT_TRUE(host.world->take_query(query).ok());
  const Vec3 place = host.world->from_world({3.3, 80, 2.9});
  std::vector<Hit> all(200);
  const std::uint32_t count = query->column(place, Wait::for_file, all);
  EXPECT_GT(count, 100u);
  for (std::size_t n = 0; n < all.size(); ++n) {
    EXPECT_EQ(all[n].found, n < kMostColumn) << n;
    if (n > 0 && n < kMostColumn) {
      EXPECT_GE(all[n].distance, all[n - 1].distance);
    }
  }
  std::array<Hit, 3> few;
  EXPECT_EQ(query->column(place, Wait::for_file, few), count);
  for (std::size_t n = 0; n < few.size(); ++n) EXPECT_EQ(few[n].distance, all[n].distance);
  EXPECT_EQ(query->column(place, Wait::for_file, {}), count);
  host.world->release(query);
}

TEST(Queries, AllMayBeTakenAndGivenBack) {
  const HostWorld host(query_needs(3, 64));
  Query* query = nullptr;
  std::set<Query*> taken;
  for (int n = 0; n < 3; ++n) {
    ASSERT_TRUE(host.world->take_query(query).ok());
    EXPECT_TRUE(taken.insert(query).second);
  }
  Query* more = query;
  const Status status = host.world->take_query(more);
  EXPECT_EQ(status.code(), StatusCode::limit_reached);
  EXPECT_STREQ(status.field(), "queries");
  EXPECT_EQ(status.value(), 4u);
  EXPECT_EQ(more, nullptr);
  host.world->release(nullptr);
  host.world->release(query);
  ASSERT_TRUE(host.world->take_query(more).ok());
  EXPECT_EQ(more, query);
  EXPECT_FALSE(host.world->take_query(more).ok());
  for (Query* one : taken) host.world->release(one);
}

TEST(Queries, PlacesThatAreNotFiniteFindNothing) {
  const Asker asker;
  Query& query = *asker.query;
  const Vec3 fine = asker.place({20, 30, 18});
  for (const double bad : {std::nan(""), double{INFINITY}, -double{INFINITY}, 1e300}) {
    for (const Vec3 place :
         {Vec3{bad, fine.y, fine.z}, Vec3{fine.x, bad, fine.z}, Vec3{fine.x, fine.y, bad}}) {
      Hit hit;
      Voxel voxel;
      std::array<Hit, 4> column;
      EXPECT_FALSE(query.ground(place, 1, Wait::for_file, hit));
      EXPECT_FALSE(query.ray(place, fine, Wait::for_file, hit));
      EXPECT_FALSE(query.ray(fine, place, Wait::for_file, hit));
      EXPECT_FALSE(query.sphere(fine, place, 1, Wait::for_file, hit));
      EXPECT_FALSE(query.inside(place, Wait::for_file));
      EXPECT_FALSE(query.pick(fine, place, 3, voxel));
      EXPECT_EQ(query.column(place, Wait::for_file, column), 0u);
      EXPECT_EQ(query.prepare(place, 5).code(), StatusCode::invalid_argument);
    }
  }
}

// Heights that are not in memory: the least that the world can do with.
Needs few_heights(std::uint32_t patches = 4096) {
  Needs needs = query_needs(2, patches);
  return test::without_heights(needs);
}

TEST(QueryFiles, NeverReadsNothing) {
  Asker asker({Axes::east_north_up, {100, 200, 300}, 0}, few_heights());
  ASSERT_FALSE(asker.host.plan.holds_all_heights);
  Query* exact = nullptr;
  ASSERT_TRUE(asker.host.world->take_query(exact).ok());
  const Vec3 middle{20, 14, 18};
  std::uint64_t reads = asker.host.file.reads();
  ASSERT_TRUE(asker.query->prepare(asker.place(middle), 9).ok());
  EXPECT_GT(asker.host.file.reads(), reads) << "heights were in memory";
  Random random{9};
  int near = 0;
  for (int n = 0; n < 200; ++n) {
    const Vec3 place =
        asker.place(middle + Vec3{random.unit() * 6 - 3, random.unit() * 6 - 3, random.unit() * 6 - 3});
    const Vec3 below = place - Vec3{0, 0, 4};
    reads = asker.host.file.reads();
    Hit ready;
    std::array<Hit, 8> column;
    const bool found = asker.query->ray(place, below, Wait::never, ready);
    Hit touched;
    const bool touches = asker.query->sphere(place, below, 0.3, Wait::never, touched);
    static_cast<void>(asker.query->column(place, Wait::never, column));
    static_cast<void>(asker.query->inside(place, Wait::never));
    Hit stands;
    static_cast<void>(asker.query->ground(place, 0.5, Wait::never, stands));
    ASSERT_EQ(asker.host.file.reads(), reads);
    Hit hit;
    ASSERT_EQ(found, exact->ray(place, below, Wait::for_file, hit));
    if (found) {
      ++near;
      EXPECT_EQ(ready.level, 3);
      EXPECT_EQ(ready.distance, hit.distance);
    }
    ASSERT_EQ(touches, exact->sphere(place, below, 0.3, Wait::for_file, hit));
    if (touches) {
      EXPECT_EQ(touched.distance, hit.distance);
    }
  }
  EXPECT_GT(near, 50);
  asker.host.world->release(exact);
}

TEST(QueryFiles, WhatIsNotReadyIsAnsweredCoarsely) {
  Asker asker({}, few_heights());
  Random random{4};
  const std::uint64_t reads = asker.host.file.reads();
  int coarse = 0;
  for (int n = 0; n < 100; ++n) {
    const Vec3 at = asker.somewhere(random);
    Hit hit;
    if (!asker.query->ground(asker.place({at.x, 30, at.z}), 0, Wait::never, hit)) continue;
    EXPECT_TRUE(hit.found);
    EXPECT_TRUE(hit.level == 0 || hit.level == 3) << int{hit.level};
    coarse += hit.level == 0;
  }
  EXPECT_GT(coarse, 50);
  EXPECT_EQ(asker.host.file.reads(), reads);
  EXPECT_EQ(asker.query->failed_reads(), 0u);
}

TEST(QueryFiles, FailedReadsAreCountedAndAnsweredCoarsely) {
  Asker asker({}, few_heights());
  const auto ask = [&](Hit& hit) {
    return asker.query->ground(asker.place({20.3, 30, 9.7}), 0, Wait::for_file, hit);
  };
  asker.host.file.fails = true;
  const Status prepared = asker.query->prepare(asker.place({20, 10, 10}), 4);
  EXPECT_EQ(prepared.code(), StatusCode::io);
  EXPECT_STREQ(prepared.field(), "file");
  const std::uint64_t failed = asker.query->failed_reads();
  EXPECT_GT(failed, 0u);
  Hit coarse;
  ASSERT_TRUE(ask(coarse));
  EXPECT_EQ(coarse.level, 0);
  EXPECT_GT(asker.query->failed_reads(), failed);
  asker.host.file.fails = false;
  const std::uint64_t all = asker.query->failed_reads();
  Hit exact;
  ASSERT_TRUE(ask(exact));
  EXPECT_EQ(exact.level, 3);
  EXPECT_EQ(asker.query->failed_reads(), all);
  EXPECT_NEAR(exact.distance, coarse.distance, 2);
  // What is ready needs no file any more.
  asker.host.file.fails = true;
  Hit again;
  ASSERT_TRUE(ask(again));
  EXPECT_EQ(again.distance, exact.distance);
  EXPECT_EQ(asker.query->failed_reads(), all);
}

TEST(QueryFiles, TooFewPatchesAreNamed) {
  Asker asker({}, few_heights(16));
  const Vec3 place = asker.place({20, 12, 18});
  const Status status = asker.query->prepare(place, 12);
  EXPECT_EQ(status.code(), StatusCode::limit_reached);
  EXPECT_STREQ(status.field(), "query_patches");
  ASSERT_GT(status.value(), 16u);
  const Asker enough({}, few_heights(static_cast<std::uint32_t>(status.value())));
  EXPECT_TRUE(enough.query->prepare(enough.place({20, 12, 18}), 12).ok());
  EXPECT_EQ(asker.query->prepare(place, -1).code(), StatusCode::invalid_argument);
  EXPECT_EQ(asker.query->prepare(place, std::nan("")).code(), StatusCode::invalid_argument);
}

}  // namespace
}  // namespace karst
