// SPDX-License-Identifier: MIT
// The nine index batches: for every level and every state of the four edges, the triangles of a patch tile
// its square once, wind counter-clockwise, and leave exactly the border that the neighbours expect.
#include "terrain/draw/index_batches.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <map>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "terrain/patch/gpu_vertex.h"

namespace karst::core {
namespace {

struct Point {
  int i, j;
  friend bool operator==(const Point&, const Point&) = default;
  friend bool operator<(const Point& a, const Point& b) { return a.i != b.i ? a.i < b.i : a.j < b.j; }
};
using Triangle = std::array<Point, 3>;
using Segment = std::pair<Point, Point>;

class IndexBatches : public testing::Test {
 protected:
  void SetUp() override {
    table_.resize(index_count(kMaxLevel));
    ASSERT_TRUE(build_index_tables(kMaxLevel, table_).ok());
  }

  // The triangles of a range on the grid; fails the test on an index out of the level's range.
  std::vector<Triangle> triangles(int level, IndexRange range) const {
    std::vector<std::uint16_t> grid(static_cast<std::size_t>(patch_vertices(level)));
    EXPECT_TRUE(build_grid_order(level, grid).ok());
    std::vector<Triangle> result;
    EXPECT_EQ(range.count % 3, 0u);
    for (std::uint32_t n = range.first; n < range.first + range.count; n += 3) {
      Triangle triangle{};
      for (std::uint32_t v = 0; v < 3; ++v) {
        const std::uint16_t index = table_.at(n + v);
        if (index >= grid.size()) {
          ADD_FAILURE() << "index " << index << " at level " << level;
          return {};
        }
        triangle[v] = {grid[index] % patch_side(level), grid[index] / patch_side(level)};
      }
      result.push_back(triangle);
    }
    return result;
  }

  std::vector<Triangle> patch(int level, unsigned lower, unsigned skipped) const {
    IndexRange ranges[kMaxIndexRanges];
    const int used = index_ranges(level, lower, skipped, ranges);
    std::vector<Triangle> result;
    for (int n = 0; n < used; ++n) {
      const auto part = triangles(level, ranges[n]);
      result.insert(result.end(), part.begin(), part.end());
    }
    return result;
  }

  std::vector<std::uint16_t> table_;
};

int doubled_area(const Triangle& t) {
  return (t[1].i - t[0].i) * (t[2].j - t[0].j) - (t[2].i - t[0].i) * (t[1].j - t[0].j);
}

Point edge_point(int level, int edge, int s) {
  const int n = patch_cells(level);
  const std::array<Point, 4> points = {Point{s, 0}, Point{n, s}, Point{n - s, n}, Point{0, n - s}};
  return points[static_cast<std::size_t>(edge)];
}

// Directed segments that no triangle runs back along.
std::set<Segment> boundary(const std::vector<Triangle>& triangles) {
  std::set<Segment> open;
  for (const Triangle& t : triangles) {
    for (std::size_t v = 0; v < 3; ++v) {
      const Segment segment = {t[v], t[(v + 1) % 3]};
      EXPECT_TRUE(open.insert(segment).second) << "a segment runs the same way twice";
    }
  }
  std::set<Segment> result;
  for (const Segment& s : open) {
    if (!open.contains({s.second, s.first})) result.insert(s);
  }
  return result;
}

std::set<Segment> expected_boundary(int level, unsigned lower) {
  std::set<Segment> result;
  for (int edge = 0; edge < 4; ++edge) {
    const int step = lower >> edge & 1u ? 2 : 1;
    for (int s = 0; s < patch_cells(level); s += step) {
      result.insert({edge_point(level, edge, s), edge_point(level, edge, s + step)});
    }
  }
  return result;
}

TEST_F(IndexBatches, EveryEdgeStateTilesTheSquareOnce) {
  for (int level = 1; level <= kMaxLevel; ++level) {
    for (unsigned lower = 0; lower < (level == 1 ? 1u : 16u); ++lower) {
      const auto all = patch(level, lower, 0);
      int area = 0;
      std::set<Triangle> distinct;
      for (Triangle t : all) {
        ASSERT_GT(doubled_area(t), 0) << "level " << level << " state " << lower;
        area += doubled_area(t);
        std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
        ASSERT_TRUE(distinct.insert(t).second) << "a triangle comes twice";
      }
      // Positive areas that sum up to the square's, inside a closed simple boundary that is the square's: the
      // winding number is 1 everywhere inside, so every point is covered exactly once.
      ASSERT_EQ(area, 2 * patch_cells(level) * patch_cells(level));
      ASSERT_EQ(boundary(all), expected_boundary(level, lower)) << "level " << level << " state " << lower;
    }
  }
}

TEST_F(IndexBatches, TrianglesStandAroundOddCentres) {
  for (int level = 1; level <= kMaxLevel; ++level) {
    const auto all = patch(level, 0, 0);
    ASSERT_EQ(all.size(), static_cast<std::size_t>(patch_triangles(level)));
    for (const Triangle& t : all) {
      EXPECT_EQ(std::count_if(t.begin(), t.end(), [](Point p) { return p.i % 2 == 1 && p.j % 2 == 1; }), 1);
    }
  }
}

TEST_F(IndexBatches, InteriorUsesNoVertexThatALowerNeighbourLacks) {
  for (int level = 1; level <= kMaxLevel; ++level) {
    const int n = patch_cells(level);
    for (const Triangle& t : triangles(level, index_batch(level, 0))) {
      for (const Point p : t) {
        const bool on_border = p.i == 0 || p.j == 0 || p.i == n || p.j == n;
        EXPECT_FALSE(on_border && (p.i % 2 == 1 || p.j % 2 == 1)) << level << ' ' << p.i << ' ' << p.j;
      }
    }
  }
}

TEST_F(IndexBatches, BatchesLieOneAfterAnother) {
  std::uint32_t next = 0;
  for (int level = 1; level <= kMaxLevel; ++level) {
    for (int batch = 0; batch < kBatches; ++batch) {
      const IndexRange range = index_batch(level, batch);
      EXPECT_EQ(range.first, next) << level << ' ' << batch;
      next += range.count;
    }
    EXPECT_EQ(next, index_count(level));
  }
  const std::size_t bytes = next * sizeof(std::uint16_t);
  std::printf("[ measured ] index tables of levels 1..%d: %zu bytes\n", kMaxLevel, bytes);
  EXPECT_LE(bytes, 128u * 1024u);
}

TEST_F(IndexBatches, RangesAreMergedAndFew) {
  IndexRange ranges[kMaxIndexRanges];
  int most = 0;
  for (int level = 1; level <= kMaxLevel; ++level) {
    EXPECT_EQ(index_ranges(level, 0, 0, ranges), 1);
    EXPECT_EQ(ranges[0].count, max_patch_indices(level));
    for (unsigned lower = 0; lower < 16; ++lower) {
      for (unsigned skipped = 0; skipped < 16; ++skipped) {
        const int used = index_ranges(level, lower, skipped, ranges);
        most = std::max(most, used);
        std::uint32_t count = 0;
        for (int n = 0; n < used; ++n) count += ranges[n].count;
        EXPECT_EQ(count, patch_index_count(level, lower, skipped)) << level << ' ' << lower << ' ' << skipped;
        for (int n = 1; n < used; ++n) EXPECT_GT(ranges[n].first, ranges[n - 1].first + ranges[n - 1].count);
      }
    }
  }
  EXPECT_EQ(most, kMaxIndexRanges);
  EXPECT_EQ(index_ranges(4, 0b0101, 0, ranges), 4);
  EXPECT_EQ(index_ranges(4, 0b1111, 0, ranges), 2);
}

TEST_F(IndexBatches, LevelOneHasNoLowerNeighbour) {
  IndexRange same[kMaxIndexRanges];
  IndexRange lower[kMaxIndexRanges];
  ASSERT_EQ(index_ranges(1, 0, 0, same), index_ranges(1, 0b1111, 0, lower));
  EXPECT_EQ(same[0], lower[0]);
}

TEST_F(IndexBatches, SkippedEdgeLeavesOutTheTrianglesThatStandOnIt) {
  for (int level = 1; level <= kMaxLevel; ++level) {
    for (const unsigned lower : {0u, 0b0010u, 0b1000u, 0b1111u}) {
      const auto all = patch(level, lower, 0);
      const auto rest = patch(level, lower, 1u << 3);
      std::vector<Triangle> left_out;
      std::vector<Triangle> wanted;
      for (const Triangle& t : all) {
        if (std::find(rest.begin(), rest.end(), t) == rest.end()) left_out.push_back(t);
        if (std::count_if(t.begin(), t.end(), [](Point p) { return p.i == 0; }) == 2) wanted.push_back(t);
      }
      // Those with two vertices on i = 0 are exactly the ones that are a segment or a point when it is one.
      EXPECT_EQ(left_out, wanted);
      EXPECT_EQ(rest.size() + left_out.size(), all.size());
    }
  }
}

TEST_F(IndexBatches, PostTransformCacheIsUsed) {
  for (int level = 1; level <= kMaxLevel; ++level) {
    for (const std::size_t entries : {std::size_t{16}, std::size_t{32}}) {
      std::deque<std::uint16_t> cache;
      std::size_t misses = 0;
      IndexRange ranges[kMaxIndexRanges];
      index_ranges(level, 0, 0, ranges);
      for (const std::uint16_t index : std::span(table_).subspan(ranges[0].first, ranges[0].count)) {
        if (std::find(cache.begin(), cache.end(), index) != cache.end()) continue;
        ++misses;
        cache.push_back(index);
        if (cache.size() > entries) cache.pop_front();
      }
      const double acmr = static_cast<double>(misses) / patch_triangles(level);
      std::printf("[ measured ] level %d, FIFO of %zu: %.3f vertices a triangle\n", level, entries, acmr);
      // 1.15: what rows as wide as the patch would cost.
      EXPECT_LT(acmr, level >= 4 ? 0.75 : 1.15);
    }
  }
}

TEST(IndexTables, RefusesWrongShapes) {
  std::vector<std::uint16_t> out(index_count(2));
  EXPECT_TRUE(build_index_tables(2, out).ok());
  EXPECT_STREQ(build_index_tables(0, out).field(), "max_level");
  EXPECT_STREQ(build_index_tables(kMaxLevel + 1, out).field(), "max_level");
  const Status small = build_index_tables(3, out);
  EXPECT_EQ(small.code(), StatusCode::invalid_argument);
  EXPECT_STREQ(small.field(), "out");
  EXPECT_EQ(small.value(), index_count(3));
}

}  // namespace
}  // namespace karst::core
