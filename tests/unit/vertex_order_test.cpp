// SPDX-License-Identifier: MIT
// The order of vertices in a slot: a bijection whose prefixes are the coarser levels.
#include "terrain/patch/gpu_vertex.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <gtest/gtest.h>

namespace karst::core {
namespace {

std::size_t vertices(int level) {
  return static_cast<std::size_t>(patch_vertices(level));
}

TEST(VertexOrder, EveryIndexIsUsedOnce) {
  for (int level = 1; level <= kMaxLevel; ++level) {
    std::vector<int> uses(vertices(level), 0);
    for (int j = 0; j < patch_side(level); ++j) {
      for (int i = 0; i < patch_side(level); ++i) {
        const int index = vertex_order(level, i, j);
        ASSERT_GE(index, 0);
        ASSERT_LT(index, patch_vertices(level)) << level << ' ' << i << ' ' << j;
        ++uses[static_cast<std::size_t>(index)];
      }
    }
    for (const int n : uses) ASSERT_EQ(n, 1) << level;
  }
}

TEST(VertexOrder, CoarserLevelsAreAPrefix) {
  for (int level = 1; level < kMaxLevel; ++level) {
    for (int j = 0; j < patch_side(level); ++j) {
      for (int i = 0; i < patch_side(level); ++i) {
        ASSERT_EQ(vertex_order(level, i, j), vertex_order(level + 1, 2 * i, 2 * j));
      }
    }
  }
}

TEST(VertexOrder, NewVerticesOfALevelAreInRowOrder) {
  for (int level = 1; level <= kMaxLevel; ++level) {
    int expected = level == 1 ? 0 : patch_vertices(level - 1);
    for (int j = 0; j < patch_side(level); ++j) {
      for (int i = 0; i < patch_side(level); ++i) {
        if (level > 1 && i % 2 == 0 && j % 2 == 0) continue;
        ASSERT_EQ(vertex_order(level, i, j), expected++);
      }
    }
  }
}

TEST(VertexOrder, TablesAgreeWithTheFunction) {
  for (int level = 1; level <= kMaxLevel; ++level) {
    std::vector<std::uint16_t> order(vertices(level) + 1, 0xbeef);
    std::vector<std::uint16_t> grid(vertices(level) + 1, 0xbeef);
    ASSERT_TRUE(build_vertex_order(level, order).ok());
    ASSERT_TRUE(build_grid_order(level, grid).ok());
    for (int j = 0; j < patch_side(level); ++j) {
      for (int i = 0; i < patch_side(level); ++i) {
        const auto g = static_cast<std::size_t>(j * patch_side(level) + i);
        ASSERT_EQ(order[g], vertex_order(level, i, j));
        ASSERT_EQ(grid[order[g]], g);
      }
    }
    EXPECT_EQ(order.back(), 0xbeef);
    EXPECT_EQ(grid.back(), 0xbeef);
  }
}

TEST(VertexOrder, RefusesWrongShapes) {
  std::array<std::uint16_t, 81> out{};
  for (const auto build : {build_vertex_order, build_grid_order}) {
    EXPECT_STREQ(build(0, out).field(), "level");
    EXPECT_STREQ(build(kMaxLevel + 1, out).field(), "level");
    EXPECT_TRUE(build(3, out).ok());
    const Status small = build(3, std::span(out).first(80));
    EXPECT_EQ(small.code(), StatusCode::invalid_argument);
    EXPECT_STREQ(small.field(), "out");
    EXPECT_EQ(small.value(), 81u);
  }
}

}  // namespace
}  // namespace karst::core
