// SPDX-License-Identifier: MIT
// Queries of the ground against all of its triangles at size 0.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include <glm/geometric.hpp>

#include "terrain/query/query.h"
#include "tests/support/any_camera.h"
#include "tests/support/heap_count.h"
#include "tests/support/memory_ground.h"

namespace karst::core {
namespace {

using test::between;
using test::MemoryGround;
using test::Random;

constexpr double kSteps = kStepsPerVoxel;

class QueryOfGround : public testing::Test {
 protected:
  static constexpr int kWide = 203, kDeep = 150;

  void SetUp() override {
    Random random{7};
    heights_.resize(kWide * kDeep);
    for (std::int32_t& h : heights_) h = static_cast<std::int32_t>(between(random, -900, 900));
    ground_ = std::make_unique<MemoryGround>(
        kWide, kDeep, 2048, 1500,
        [&](std::int64_t i, std::int64_t k) { return heights_[static_cast<std::size_t>(k * kWide + i)]; },
        [](NodeKey) { return 100.0f; });
    Query::Limits limits;
    limits.patches = 16;
    limits.ground.tiles = QueryGround::kLeastTiles;
    Budget budget;
    Query::add_to(budget, limits);
    memory_.resize(budget.cpu_bytes() + Arena::kAlignment);
    void* at = memory_.data();
    std::size_t room = memory_.size();
    std::align(Arena::kAlignment, budget.cpu_bytes(), at, room);
    Arena arena({static_cast<std::byte*>(at), budget.cpu_bytes()});
    ASSERT_TRUE(query_.create(limits, arena).ok());
    reset();
  }

  void reset() {
    query_.set_ground(
        ground_->info(), &ground_->tile(ground_->root()),
        {this, [](const void* context, NodeKey tile, const TilePlace&, std::span<std::byte>, Tile& out) {
           const auto* self = static_cast<const QueryOfGround*>(context);
           if (self->fails_) return Status{StatusCode::io, "cannot be read", "file", 0};
           out = self->ground_->tile(tile);
           return Status();
         }});
  }

  glm::dvec3 place(int i, int k) const {
    return {i * 2048.0, 2.0 * heights_[static_cast<std::size_t>(k * kWide + i)],
            2.0 * double(sample_place(1500, k))};
  }
  // All triangles, corners in lattice steps.
  template <class Visit>
  void each_triangle(Visit&& visit) const {
    for (int k = 0; k + 1 < kDeep; ++k) {
      for (int i = 0; i + 1 < kWide; ++i) {
        const glm::dvec3 nw = place(i, k), ne = place(i + 1, k), sw = place(i, k + 1),
                         se = place(i + 1, k + 1);
        if ((i + k) % 2 == 0) {
          visit(nw, sw, se);
          visit(nw, se, ne);
        } else {
          visit(nw, sw, ne);
          visit(ne, sw, se);
        }
      }
    }
  }

  std::vector<std::int32_t> heights_;
  std::unique_ptr<MemoryGround> ground_;
  std::vector<std::byte> memory_;
  Query query_;
  bool fails_ = false;
};

// Where a ray from a place meets a triangle, as a share of way (Moeller and Trumbore, 1997); above 1:
// nowhere.
double meets(glm::dvec3 from, glm::dvec3 way, glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
  const glm::dvec3 p = glm::cross(way, c - a);
  const double det = glm::dot(b - a, p);
  if (std::abs(det) < 1e-12) return 2;
  const double u = glm::dot(from - a, p) / det;
  const glm::dvec3 q = glm::cross(from - a, b - a);
  const double v = glm::dot(way, q) / det;
  const double t = glm::dot(c - a, q) / det;
  return u < -1e-12 || v < -1e-12 || u + v > 1 + 1e-12 || t < 0 ? 2 : t;
}

TEST_F(QueryOfGround, HeightsAreThoseOfTheTrianglesOfSizeZero) {
  Random random{3};
  double worst = 0;
  for (int n = 0; n < 300; ++n) {
    const glm::dvec3 at(between(random, 0, (kWide - 1) * 0.25), 1.0,
                        between(random, 0, (kDeep - 1) * 1500.0 / kSteps));
    double expected = -1e9;
    each_triangle([&](glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
      const double t = meets({at.x * kSteps, 1e5, at.z * kSteps}, {0, -2e5, 0}, a, b, c);
      if (t <= 1) expected = std::max(expected, 1e5 - 2e5 * t);
    });
    ASSERT_GT(expected, -1e9);
    QueryHit hit;
    ASSERT_TRUE(query_.ground(at, 0, Wait::for_file, hit));
    EXPECT_EQ(hit.patch, QueryHit::kGround);
    EXPECT_FALSE(hit.coarse);
    EXPECT_GT(hit.normal.y, 0.0);
    worst = std::max(worst, std::abs(hit.place.y * kSteps - expected));
    std::array<QueryHit, 4> hits;
    EXPECT_EQ(query_.column(at, Wait::for_file, hits), 1u);
    EXPECT_FALSE(query_.inside(at + glm::dvec3(0, 1, 0), Wait::for_file));
    EXPECT_TRUE(query_.inside(at - glm::dvec3(0, 2, 0), Wait::for_file));
  }
  EXPECT_LT(worst, 0.01);  // a line is rounded to VerticalLine::kGrain
  QueryHit hit;
  EXPECT_FALSE(query_.ground({-0.01, 5, 3}, 0, Wait::for_file, hit));
  EXPECT_FALSE(query_.ground({3, 5, (kDeep - 1) * 1500.0 / kSteps + 0.01}, 0, Wait::for_file, hit));
}

TEST_F(QueryOfGround, RaysMeetWhatTheyMeetFirst) {
  Random random{4};
  int met = 0;
  for (int n = 0; n < 200; ++n) {
    const auto somewhere = [&] {
      return glm::dvec3(between(random, -3, kWide * 0.25 + 3), between(random, -0.5, 0.8),
                        between(random, -3, kDeep * 0.19 + 3));
    };
    const glm::dvec3 from = somewhere(), to = somewhere();
    double first = 2;
    each_triangle([&](glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
      first = std::min(first, meets(from * kSteps, (to - from) * kSteps, a, b, c));
    });
    QueryHit hit;
    const bool found = query_.ray(from, to, Wait::for_file, hit);
    EXPECT_EQ(found, first <= 1) << n;
    if (!found || first > 1) continue;
    ++met;
    EXPECT_NEAR(hit.distance, first * glm::length(to - from), 1e-6);
    QueryHit ball;
    ASSERT_TRUE(query_.sphere(from, to, 0.05, Wait::for_file, ball));
    EXPECT_LE(ball.distance, hit.distance);
  }
  EXPECT_GT(met, 50);
}

TEST_F(QueryOfGround, WithoutTilesACoarserSizeAnswers) {
  QueryHit hit;
  const glm::dvec3 at(20.3, 1, 11.7);
  ASSERT_TRUE(query_.ground(at, 0, Wait::never, hit));
  EXPECT_TRUE(hit.coarse);
  EXPECT_EQ(query_.tiles_read(), 0u);
  ASSERT_TRUE(query_.prepare(at, 0.1).ok());
  const std::uint64_t heap = test::heap_calls();
  const std::uint64_t read = query_.tiles_read();
  EXPECT_GT(read, 0u);
  ASSERT_TRUE(query_.ground(at, 0, Wait::never, hit));
  EXPECT_FALSE(hit.coarse);
  EXPECT_EQ(query_.tiles_read(), read);
  EXPECT_EQ(test::heap_calls(), heap);
}

// With all tiles at hand places are found without a walk from the root: the same bits, on edges of nodes and
// of tiles and beside them too.
TEST_F(QueryOfGround, WhatIsAtHandIsAnsweredAlike) {
  Random random{9};
  for (int n = 0; n < 2000; ++n) {
    glm::dvec3 at(between(random, 0, (kWide - 1) * 0.25), 1.0,
                  between(random, 0, (kDeep - 1) * 1500.0 / kSteps));
    if (n % 2 == 0) at.x = std::floor(at.x * 4) / 4 + (n % 6 - 2) * 1e-4;
    if (n % 3 == 0) at.z = std::floor(at.z * kSteps / 1500) * 1500 / kSteps;
    if (n % 10 == 0) at.x = std::floor(at.x / 16) * 16;
    reset();
    QueryHit walked, found;
    const bool any = query_.ground(at, 0, Wait::for_file, walked);  // reads its tiles, so it walks
    ASSERT_EQ(query_.ground(at, 0, Wait::for_file, found), any) << at.x << " " << at.z;
    if (!any) continue;
    EXPECT_EQ(found.place, walked.place);
    EXPECT_EQ(found.normal, walked.normal);
  }
}

TEST_F(QueryOfGround, NoMoreIsReadThanIsAllowed) {
  QueryHit hit;
  const glm::dvec3 at(20.3, 1, 11.7);
  query_.allow_reads(1);
  ASSERT_TRUE(query_.ground(at, 0, Wait::for_file, hit));
  EXPECT_TRUE(hit.coarse);
  EXPECT_EQ(query_.tiles_read(), 1u);
  EXPECT_GT(query_.refused_reads(), 0u);
  EXPECT_EQ(query_.failed_reads(), 0u);
  const std::uint64_t refused = query_.refused_reads();
  query_.allow_reads(0xffffffffu);
  ASSERT_TRUE(query_.ground(at, 0, Wait::for_file, hit));
  EXPECT_FALSE(hit.coarse);
  EXPECT_EQ(query_.refused_reads(), refused);
}

TEST_F(QueryOfGround, WhatCannotBeReadIsAnsweredCoarsely) {
  fails_ = true;
  QueryHit hit;
  ASSERT_TRUE(query_.ground({20.3, 1, 11.7}, 0, Wait::for_file, hit));
  EXPECT_TRUE(hit.coarse);
  EXPECT_GT(query_.failed_reads(), 0u);
  EXPECT_EQ(query_.trouble().code(), StatusCode::io);
  EXPECT_EQ(query_.prepare({20.3, 1, 11.7}, 1).code(), StatusCode::io);
  fails_ = false;
  ASSERT_TRUE(query_.ground({20.3, 1, 11.7}, 0, Wait::for_file, hit));
  EXPECT_FALSE(hit.coarse);
}

}  // namespace
}  // namespace karst::core
