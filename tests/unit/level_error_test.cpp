// SPDX-License-Identifier: MIT
// Errors of levels against brute force over the index tables and the vertices that the GPU gets.
#include "terrain/measure/level_error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "terrain/draw/index_batches.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

using test::Random;
using test::TestWorld;

// A triangle of a level in the grid of the full one.
struct GridTriangle {
  glm::ivec2 v[3];
};

int cross(glm::ivec2 a, glm::ivec2 b) {
  return a.x * b.y - a.y * b.x;
}

std::vector<GridTriangle> triangles_of(int level, int full_level) {
  std::vector<std::uint16_t> table(index_count(kMaxLevel));
  EXPECT_TRUE(build_index_tables(kMaxLevel, table).ok());
  std::vector<std::uint16_t> grid(static_cast<std::size_t>(patch_vertices(full_level)));
  EXPECT_TRUE(build_grid_order(full_level, grid).ok());
  IndexRange ranges[kMaxIndexRanges];
  EXPECT_EQ(index_ranges(level, 0, 0, ranges), 1);
  std::vector<GridTriangle> result;
  const int side = patch_side(full_level);
  for (std::uint32_t t = 0; t < ranges[0].count; t += 3) {
    GridTriangle triangle;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const int at = grid[table[ranges[0].first + t + k]];
      triangle.v[k] = {at % side, at / side};
    }
    result.push_back(triangle);
  }
  return result;
}

// Twice the signed areas opposite the corners; all at least 0 where p is inside.
glm::ivec3 areas(const GridTriangle& t, glm::ivec2 p) {
  return {cross(t.v[1] - p, t.v[2] - p), cross(t.v[2] - p, t.v[0] - p), cross(t.v[0] - p, t.v[1] - p)};
}

bool holds(const GridTriangle& t, glm::ivec2 p) {
  const glm::ivec3 a = areas(t, p);
  return a.x >= 0 && a.y >= 0 && a.z >= 0;
}

// What the measurement rests on: a coarse triangle is a union of finer ones.
TEST(LevelErrors, LevelsAreNested) {
  for (int level = 1; level < kMaxLevel; ++level) {
    const std::vector<GridTriangle> coarse = triangles_of(level, level + 1);
    for (const GridTriangle& fine : triangles_of(level + 1, level + 1)) {
      const auto around = std::count_if(coarse.begin(), coarse.end(), [&](const GridTriangle& t) {
        return holds(t, fine.v[0]) && holds(t, fine.v[1]) && holds(t, fine.v[2]);
      });
      ASSERT_EQ(around, 1) << "level " << level;
    }
  }
}

struct Measured {
  std::vector<BorderErrors> borders;
  std::vector<std::uint16_t> own;     // before join()
  std::vector<std::uint16_t> values;  // after it
};

Measured measure(const TestWorld& world) {
  const std::size_t patches = world.surface().patches.size();
  Measured m;
  m.borders.resize(patches);
  m.values.resize(patches * level_error_values(world.heights().level));
  const MeasureLevelErrors job{world.surface(), world.heights(), m.borders, m.values};
  EXPECT_TRUE(job.validate().ok());
  job.measure(0, static_cast<PatchId>(patches));
  m.own = m.values;
  job.join(0, static_cast<PatchId>(patches));
  return m;
}

glm::dvec3 vec(const std::int16_t (&v)[3]) {
  return {v[0], v[1], v[2]};
}

// A patch's triangles of level m with vertices that have gone any share of their ways to their morph targets.
class PatchLevel {
 public:
  PatchLevel(const TestWorld& world, PatchId patch, int m)
      : full_(world.heights().level),
        m_(m),
        vertices_(world.vertices(patch, full_)),
        triangles_(triangles_of(m, full_)) {}

  const std::vector<GridTriangle>& triangles() const { return triangles_; }
  bool moves(glm::ivec2 v) const { return ((v.x | v.y) >> (full_ - m_) & 1) != 0; }
  bool on_edge(glm::ivec2 v, int edge) const {
    const int n = patch_cells(full_);
    return edge == 0 ? v.y == 0 : edge == 1 ? v.x == n : edge == 2 ? v.y == n : v.x == 0;
  }
  const GpuVertex& vertex(glm::ivec2 v) const {
    return vertices_[static_cast<std::size_t>(vertex_order(full_, v.x, v.y))];
  }
  // Distance from the full surface at a full-level vertex of a triangle. share: of each corner.
  double deviation(const GridTriangle& t, glm::ivec2 p, glm::dvec3 share) const {
    const glm::dvec3 weight = glm::dvec3(areas(t, p)) / double(cross(t.v[1] - t.v[0], t.v[2] - t.v[0]));
    glm::dvec3 at(0.0);
    for (int k = 0; k < 3; ++k) {
      const GpuVertex& g = vertex(t.v[k]);
      at += weight[k] * glm::mix(vec(g.position), vec(g.morph), moves(t.v[k]) ? share[k] : 0.0);
    }
    return glm::distance(at, vec(vertex(p).position));
  }
  // Calls visit(p) for the full-level vertices in a triangle.
  template <class Visit>
  void for_each_vertex(const GridTriangle& t, Visit visit) const {
    const glm::ivec2 low = glm::min(glm::min(t.v[0], t.v[1]), t.v[2]);
    const glm::ivec2 high = glm::max(glm::max(t.v[0], t.v[1]), t.v[2]);
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) {
        if (holds(t, {x, y})) visit(glm::ivec2(x, y));
      }
    }
  }

 private:
  int full_, m_;
  std::vector<GpuVertex> vertices_;
  std::vector<GridTriangle> triangles_;
};

TestWorld rough_world(std::uint64_t seed, int level, int amplitude) {
  TestWorld world = TestWorld::noise(seed, {8, 8, 8}, 0.5, seed % 2 == 0 ? 3.0 : 0.0, true);
  world.roughen(level, seed, amplitude);
  return world;
}

TEST(LevelErrors, OwnErrorIsTheLargestOfAllCases) {
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) {
    const int level = 3 + static_cast<int>(seed) / 2;
    const TestWorld world = rough_world(seed, level, seed < 3 ? 0 : 1500);
    const Measured m = measure(world);
    for (PatchId p = 0; p < world.surface().patches.size(); p += 23) {
      for (int j = 1; j < level; ++j) {
        const PatchLevel patch(world, p, j + 1);
        double most = 0;
        double reach = 0;
        double border[4] = {};
        for (const GridTriangle& t : patch.triangles()) {
          // A side of the patch that the triangle stands on, and which of its corners is the border vertex
          // there.
          int edge = -1;
          int on_border = -1;
          for (int e = 0; e < 4; ++e) {
            int corners = 0;
            for (const glm::ivec2 v : t.v) corners += patch.on_edge(v, e) ? 1 : 0;
            if (corners == 2) edge = e;
          }
          for (int k = 0; k < 3 && edge >= 0; ++k) {
            if (patch.on_edge(t.v[k], edge) && patch.moves(t.v[k])) on_border = k;
          }
          patch.for_each_vertex(t, [&](glm::ivec2 f) {
            for (int moved = 1; moved < 8; ++moved) {
              const glm::dvec3 share(moved & 1, moved >> 1 & 1, moved >> 2 & 1);
              bool any = false;
              for (int k = 0; k < 3; ++k) any = any || (share[k] > 0 && patch.moves(t.v[k]));
              if (any) most = std::max(most, patch.deviation(t, f, share));
            }
            if (edge >= 0) {
              glm::dvec3 alone(0.0);
              alone[on_border] = 1;
              border[edge] = std::max(border[edge], patch.deviation(t, f, alone));
            }
            for (const glm::ivec2 v : t.v) {
              if (!patch.moves(v)) continue;
              const glm::dvec3 from = vec(patch.vertex(v).position);
              reach = std::max(reach, glm::distance(from, vec(patch.vertex(f).position)));
              for (const glm::ivec2 w : t.v) {
                reach = std::max(reach, glm::distance(from, vec(patch.vertex(w).position)));
                if (patch.moves(w)) reach = std::max(reach, glm::distance(from, vec(patch.vertex(w).morph)));
              }
            }
          });
        }
        const LevelErrors own{level, m.own};
        ASSERT_EQ(own.error(p, j), std::ceil(most - 1e-9)) << "patch " << p << " level " << j;
        ASSERT_EQ(own.reach(p, j + 1), std::ceil(reach - 1e-9)) << "patch " << p << " level " << j;
        for (int e = 0; e < 4; ++e) ASSERT_EQ(m.borders[p].error[e][j - 1], std::ceil(border[e] - 1e-9));
      }
    }
  }
}

// Any shares of the way, any point between full-level vertices too.
TEST(LevelErrors, NothingBetweenTheCasesIsWorse) {
  Random random{5};
  const int level = 4;
  const TestWorld world = rough_world(8, level, 2000);
  const Measured m = measure(world);
  double closest = 0;
  for (PatchId p = 0; p < world.surface().patches.size(); p += 17) {
    for (int j = 1; j < level; ++j) {
      const PatchLevel patch(world, p, j + 1);
      const double bound = (LevelErrors{level, m.own}).error(p, j);
      for (const GridTriangle& t : patch.triangles()) {
        patch.for_each_vertex(t, [&](glm::ivec2 f) {
          // Neither at home: with both there, it is the next level's error.
          const double lead = 1;
          glm::dvec3 share(lead, random.unit(), random.unit());
          std::swap(share.x, share[random.below(3)]);
          int leader = share.x == 1 ? 0 : share.y == 1 ? 1 : 2;
          if (!patch.moves(t.v[leader])) return;
          const double off = patch.deviation(t, f, share);
          ASSERT_LE(off, bound);
          closest = std::max(closest, off / bound);
        });
      }
    }
  }
  EXPECT_GT(closest, 0.9);
}

TEST(LevelErrors, JoinTakesInNeighboursAndNeverRises) {
  const int level = 4;
  for (const std::uint64_t seed : {10u, 11u}) {
    const TestWorld world = rough_world(seed, level, 1000);
    const Measured m = measure(world);
    const LevelErrors errors{level, m.values};
    const LevelErrors own{level, m.own};
    EXPECT_TRUE(errors.known(world.surface().patches.size()));
    EXPECT_EQ(find_level_error_fault(level, m.values), m.values.size());
    std::size_t from_neighbours = 0;
    for (PatchId p = 0; p < world.surface().patches.size(); ++p) {
      for (int j = level - 1; j >= 1; --j) {
        double error = own.error(p, j);
        double reach = own.reach(p, j + 1);
        for (int e = 0; e < 4; ++e) {
          const PatchEdge other = world.surface().patches[p].neighbour[e];
          if (!other.exists()) continue;
          const auto& theirs = m.borders[other.patch()];
          const double before = error;
          error = std::max<double>(error, theirs.error[other.edge()][j - 1]);
          from_neighbours += error > before ? 1u : 0u;
          error = std::max(error, std::ceil(m.borders[p].error[e][j - 1] / (1 - double{kMorphShare})));
          reach = std::max<double>(reach, theirs.reach[other.edge()][j - 1]);
        }
        if (j < level - 1) {
          error = std::max<double>(error, errors.error(p, j + 1));
          reach = std::max<double>(reach, errors.reach(p, j + 2));
        }
        ASSERT_EQ(errors.error(p, j), error);
        ASSERT_EQ(errors.reach(p, j + 1), reach);
      }
    }
    EXPECT_GT(from_neighbours, 10u);
  }
}

TEST(LevelErrors, RangesGiveTheWhole) {
  const TestWorld world = rough_world(12, 3, 1000);
  const Measured whole = measure(world);
  const PatchId patches = static_cast<PatchId>(world.surface().patches.size());
  Measured parts;
  parts.borders.resize(patches);
  parts.values.resize(patches * level_error_values(3));
  const MeasureLevelErrors job{world.surface(), world.heights(), parts.borders, parts.values};
  job.measure(patches / 3, patches);
  job.measure(0, patches / 3);
  job.join(patches / 2, patches);
  job.join(0, patches / 2);
  EXPECT_EQ(parts.values, whole.values);
}

// A plane without heights is the same at every level.
TEST(LevelErrors, FlatGroundHasNone) {
  TestWorld world({9, 6, 9}, [](glm::ivec3 v) { return v.y < 3; });
  for (const double slope : {0.0, 200.0}) {
    world.set_heights(4, [=](glm::dvec3 p) { return slope * p.x; });
    const Measured m = measure(world);
    for (PatchId p = 0; p < world.surface().patches.size(); ++p) {
      const LevelErrors errors{4, m.values};
      for (int j = 1; j < 4; ++j) {
        // A slope is linear but for the rounding of heights and positions.
        EXPECT_LE(errors.error(p, j), slope == 0.0 ? 0 : 3);
        EXPECT_GE(errors.reach(p, j + 1), kStepsPerVoxel >> (j + 1));
      }
    }
  }
}

TEST(LevelErrors, FaultsAreFound) {
  // Two patches of level 3: error(1), error(2), reach(2), reach(3).
  std::vector<std::uint16_t> values = {9, 9, 7, 7, 8, 1, 9, 0};
  EXPECT_EQ(find_level_error_fault(3, values), values.size());
  for (const std::size_t at : {1u, 3u, 5u, 7u}) {
    std::vector<std::uint16_t> bad = values;
    bad[at] = static_cast<std::uint16_t>(bad[at - 1] + 1);
    EXPECT_EQ(find_level_error_fault(3, bad), at);
  }
  EXPECT_EQ(find_level_error_fault(1, {}), 0u);
}

TEST(LevelErrors, RefusesOneWrongFieldAtATime) {
  const TestWorld world = rough_world(13, 2, 100);
  Measured m = measure(world);
  const MeasureLevelErrors good{world.surface(), world.heights(), m.borders, m.values};
  MeasureLevelErrors bad = good;
  bad.heights.level = 0;
  EXPECT_STREQ(bad.validate().field(), "heights");
  bad.heights.level = kMaxLevel + 1;
  EXPECT_STREQ(bad.validate().field(), "heights");
  bad = good;
  bad.borders = bad.borders.first(1);
  EXPECT_STREQ(bad.validate().field(), "borders");
  bad = good;
  bad.values = bad.values.first(bad.values.size() - 1);
  EXPECT_STREQ(bad.validate().field(), "values");
}

}  // namespace
}  // namespace karst::core
