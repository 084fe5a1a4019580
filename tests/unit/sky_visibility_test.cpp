// SPDX-License-Identifier: MIT
#include "terrain/field/sky_visibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

#include "terrain/base/checksum.h"
#include "terrain/field/voxelize.h"
#include "tests/support/test_world.h"
#include "tests/support/tree_memory.h"

namespace karst::core {
namespace {

using Filled = std::function<bool(glm::ivec3)>;

// A world and its sky, in no more words than the finest grid takes.
struct Sky {
  Sky(glm::ivec3 extent, const Filled& filled, std::size_t words = SIZE_MAX)
      : storage(std::min(words, SkyVisibility::word_count(extent))) {
    const int most = std::max({extent.x, extent.y, extent.z});
    int depth = 1;
    while (1 << depth < most) ++depth;
    TreeMemory memory(depth);
    const auto ask = [&](glm::ivec3 v, bool) { return filled(v); };
    EXPECT_TRUE((VoxelizePredicate{extent, VoxelFunction(ask)}.run(memory.tree).ok()));
    sky.create(storage);
    sky.build(memory.tree, extent);
  }

  template <class Visit>
  void for_each(Visit visit) const {
    const glm::ivec3 cells = sky.grid().cells;
    for (int y = 0; y < cells.y; ++y) {
      for (int z = 0; z < cells.z; ++z) {
        for (int x = 0; x < cells.x; ++x) visit(glm::ivec3(x, y, z));
      }
    }
  }

  std::vector<std::uint64_t> storage;
  SkyVisibility sky;
};

// A landscape with caves and overhangs.
constexpr glm::ivec3 kExtent(37, 21, 70);
bool make_rugged(glm::ivec3 v) {
  const glm::dvec3 p = glm::dvec3(v) + 0.5;
  const double ground = 9 + 5 * test::value_noise(31, glm::dvec3(p.x, 0, p.z) / 9.0);
  return ground - p.y + 7 * test::value_noise(32, p / 5.0) > 0;
}
int number_of(glm::ivec3 v) {
  return (v.y * kExtent.z + v.z) * kExtent.x + v.x;
}
bool rugged(glm::ivec3 v) {
  static const std::vector<bool> voxels = [] {
    std::vector<bool> all;
    for (int n = 0; n < kExtent.x * kExtent.y * kExtent.z; ++n) {
      all.push_back(make_rugged({n % kExtent.x, n / (kExtent.x * kExtent.z), n / kExtent.x % kExtent.z}));
    }
    return all;
  }();
  return voxels[static_cast<std::size_t>(number_of(v))];
}

// The share of rays, evenly spread over the hemisphere, that leave the world before they meet rock: from the
// cell's middle, through all cells that they cross.
double by_rays(glm::ivec3 extent, const Filled& filled, glm::ivec3 from, int rays) {
  test::Random random{5};
  int free = 0;
  for (int n = 0; n < rays; ++n) {
    const double up = random.unit();
    const double turn = 6.283185307179586 * random.unit();
    const double level = std::sqrt(1 - up * up);
    const glm::dvec3 way(level * std::cos(turn), up, level * std::sin(turn));
    glm::ivec3 cell = from;
    glm::dvec3 next;  // along the ray, where it leaves the cell on each axis
    for (int axis = 0; axis < 3; ++axis) next[axis] = 0.5 / std::max(std::fabs(way[axis]), 1e-9);
    for (;;) {
      const int axis = next.x <= next.y && next.x <= next.z ? 0 : next.z <= next.y ? 2 : 1;
      cell[axis] += way[axis] > 0 ? 1 : -1;
      next[axis] += 1 / std::max(std::fabs(way[axis]), 1e-9);
      const bool out =
          cell.y >= extent.y || cell.x < 0 || cell.z < 0 || cell.x >= extent.x || cell.z >= extent.z;
      if (out || filled(cell)) {
        free += out;
        break;
      }
    }
  }
  return static_cast<double>(free) / rays;
}

TEST(SkyVisibility, IsTheShareOfRaysThatReachTheSky) {
  const Sky world(kExtent, rugged);
  test::Random random{9};
  double sum = 0;
  double signed_sum = 0;
  double most = 0;
  constexpr int kCells = 600;
  for (int n = 0; n < kCells;) {
    const glm::ivec3 cell{random.below(kExtent.x), random.below(kExtent.y), random.below(kExtent.z)};
    if (rugged(cell)) continue;
    const double wrong = world.sky.at(cell) / 255.0 - by_rays(kExtent, rugged, cell, 1000);
    sum += std::fabs(wrong);
    signed_sum += wrong;
    most = std::max(most, std::fabs(wrong));
    ++n;
  }
  EXPECT_LT(sum / kCells, 0.015);
  EXPECT_NEAR(signed_sum / kCells, 0, 0.005);
  EXPECT_LT(most, 0.2);
}

TEST(SkyVisibility, IsFullOverLevelGroundAndAboveEverything) {
  const Sky flat({70, 9, 20}, [](glm::ivec3 v) { return v.y < 4; });
  flat.for_each([&](glm::ivec3 c) {
    if (c.y < 4) return;
    ASSERT_EQ(flat.sky.at(c), 255);
  });
  const Sky world(kExtent, rugged);
  world.for_each([&](glm::ivec3 c) {
    if (c.y < kExtent.y) return;
    ASSERT_EQ(world.sky.at(c), 255);
  });
  EXPECT_EQ(world.sky.grid().cells, kExtent + glm::ivec3(0, 1, 0));
  EXPECT_EQ(world.sky.grid().cell_log2, 0);
}

// Rooms whose walls are a voxel thick and touch at edges only on the outside; a hole in one lights it.
TEST(SkyVisibility, IsNothingInClosedRooms) {
  const auto ball = [](glm::ivec3 v, double radius) {
    const glm::dvec3 d = glm::dvec3(v) - glm::dvec3(12, 9, 12);
    return d.x * d.x + d.y * d.y + d.z * d.z < radius * radius;
  };
  // Of the cells outside, those that share a face with one inside: the thinnest wall.
  const auto wall = [&](glm::ivec3 v) {
    if (ball(v, 6)) return false;
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {-1, 1}) {
        glm::ivec3 next = v;
        next[axis] += side;
        if (ball(next, 6)) return true;
      }
    }
    return false;
  };
  const glm::ivec3 extent(25, 20, 25);
  const Sky closed(extent, wall);
  const Sky holed(extent, [&](glm::ivec3 v) { return wall(v) && !(v.x == 12 && v.z == 12); });
  int lit = 0;
  closed.for_each([&](glm::ivec3 c) {
    if (!ball(c, 6)) return;
    ASSERT_EQ(closed.sky.at(c), 0) << c.x << ' ' << c.y << ' ' << c.z;
    lit += holed.sky.at(c) > 0;
  });
  EXPECT_GT(lit, 30);
}

TEST(SkyVisibility, OfAMirroredWorldIsMirrored) {
  const Sky world(kExtent, rugged);
  const auto mirrored = [](glm::ivec3 v, bool x, bool z) {
    return glm::ivec3(x ? kExtent.x - 1 - v.x : v.x, v.y, z ? kExtent.z - 1 - v.z : v.z);
  };
  for (int way = 1; way < 4; ++way) {
    const bool x = (way & 1) != 0;
    const bool z = (way & 2) != 0;
    const Sky other(kExtent, [&](glm::ivec3 v) { return rugged(mirrored(v, x, z)); });
    other.for_each([&](glm::ivec3 c) { ASSERT_EQ(other.sky.at(c), world.sky.at(mirrored(c, x, z))); });
  }
}

TEST(SkyVisibility, NeverFallsWhereRockIsTakenAway) {
  const Sky before(kExtent, rugged);
  const auto less = [&](glm::ivec3 v) {
    return rugged(v) && test::mix(static_cast<std::uint64_t>(number_of(v))) % 9 != 0;
  };
  const Sky after(kExtent, less);
  int risen = 0;
  before.for_each([&](glm::ivec3 c) {
    if (c.y < kExtent.y && rugged(c)) return;
    ASSERT_GE(after.sky.at(c), before.sky.at(c));
    risen += after.sky.at(c) > before.sky.at(c);
  });
  EXPECT_GT(risen, 1000);
}

// Filled cells have the mean of the open ones around.
TEST(SkyVisibility, SpreadsIntoFilledCells) {
  const Sky world(kExtent, rugged);
  const auto open = [](glm::ivec3 c) { return c.y >= kExtent.y || !rugged(c); };
  int buried = 0;
  world.for_each([&](glm::ivec3 c) {
    if (open(c)) return;
    int sum = 0;
    int found = 0;
    for (int n = 0; n < 27; ++n) {
      const glm::ivec3 other = c + glm::ivec3(n % 3, n / 3 % 3, n / 9) - 1;
      if (std::min({other.x, other.y, other.z}) < 0 || other.x >= kExtent.x || other.z >= kExtent.z) continue;
      if (!open(other)) continue;
      sum += world.sky.at(other);
      ++found;
    }
    buried += found == 0;
    const double mean = found > 0 ? static_cast<double>(sum) / found : 0;
    ASSERT_NEAR(world.sky.at(c), mean, 0.5);
  });
  EXPECT_GT(buried, 1000);
}

// A world of twice the size in cells of twice the size is the same; so it is where memory is short.
TEST(SkyVisibility, CellsAreAsSmallAsMemoryAllows) {
  const glm::ivec3 extent(20, 14, 18);
  const Sky fine(extent, [](glm::ivec3 v) { return rugged(v); });
  const auto doubled = [](glm::ivec3 v) { return rugged(v / 2); };
  const std::size_t words = SkyVisibility::word_count(extent);
  const Sky coarse(extent * 2, doubled, words);
  ASSERT_EQ(coarse.sky.grid().cell_log2, 1);
  ASSERT_EQ(coarse.sky.grid().cells, fine.sky.grid().cells);
  fine.for_each([&](glm::ivec3 c) { ASSERT_EQ(fine.sky.at(c), coarse.sky.at(c)); });
  EXPECT_EQ(Sky(extent * 2, doubled).sky.grid().cell_log2, 0);
  EXPECT_EQ(Sky(extent * 2, doubled, words - 1).sky.grid().cell_log2, 2);
  const Sky none(extent * 2, doubled, 1);
  EXPECT_EQ(none.sky.grid().cells, glm::ivec3(1));
  EXPECT_EQ(none.sky.at({0, 0, 0}), 255) << "open everywhere";

  EXPECT_EQ(SkyVisibility::grid_for(glm::ivec3(512), SIZE_MAX).cell_log2, 3);
  for (const glm::ivec3 large : {glm::ivec3(512), glm::ivec3(512, 40, 512), glm::ivec3(9, 512, 300)}) {
    const SkyGrid grid = SkyVisibility::grid_for(large, SIZE_MAX);
    EXPECT_LE(grid.bytes(), SkyVisibility::kMostBytes);
    EXPECT_LE(std::max({grid.cells.x, grid.cells.y, grid.cells.z}), SkyVisibility::kMostSide);
    EXPECT_TRUE(glm::all(glm::greaterThanEqual(grid.cells << grid.cell_log2, large)));
  }
}

// A cell is filled where half of it is.
TEST(SkyVisibility, LargeCellsAreFilledWhereHalfIs) {
  const glm::ivec3 extent(16, 8, 16);
  const auto room = [](int floor, bool roofed) {
    return [=](glm::ivec3 v) { return v.y < floor || (roofed && v.y >= 6); };
  };
  const std::size_t words = SkyVisibility::word_count(extent / 2);
  const Sky half(
      extent, [&](glm::ivec3 v) { return room(3, false)(v); }, words);
  ASSERT_EQ(half.sky.grid().cell_log2, 1);
  EXPECT_EQ(half.sky.at({4, 1, 4}), half.sky.at({4, 2, 4})) << "filled: what the cell above has";
  const Sky less(
      extent, [&](glm::ivec3 v) { return v.y < 2 || (v.y == 2 && (v.x + v.z) % 2 == 0); }, words);
  EXPECT_EQ(less.sky.at({4, 1, 4}), 255) << "a quarter is filled: open";
}

TEST(SkyVisibility, TheLeastInABoxIsThatOfAllLookups) {
  const Sky world(kExtent, rugged);
  const auto texel = [&](glm::ivec3 c) {
    return static_cast<double>(world.sky.at(glm::clamp(c, glm::ivec3(0), world.sky.grid().cells - 1)));
  };
  test::Random random{12};
  int close = 0;
  for (int n = 0; n < 2000; ++n) {
    glm::vec3 low;
    glm::vec3 high;
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = static_cast<float>(random.unit() * (kExtent[axis] + 6) - 3);
      high[axis] = low[axis] + static_cast<float>(random.unit() * 2);
    }
    const int least = world.sky.least_in(low, high);
    double found = 255;
    for (int k = 0; k < 60; ++k) {
      glm::dvec3 p;
      for (int axis = 0; axis < 3; ++axis)
        p[axis] = glm::mix(double(low[axis]), double(high[axis]), random.unit());
      p -= 0.5;
      const glm::ivec3 first(glm::floor(p));
      const glm::dvec3 share = p - glm::dvec3(first);
      double value = 0;
      for (int o = 0; o < 8; ++o) {
        const glm::ivec3 corner(o & 1, o >> 1 & 1, o >> 2 & 1);
        const glm::dvec3 w = glm::mix(1.0 - share, share, glm::dvec3(corner));
        value += w.x * w.y * w.z * texel(first + corner);
      }
      found = std::min(found, value);
    }
    ASSERT_GE(found, least - 1e-6);
    close += found < least + 40;
  }
  EXPECT_GT(close, 1000);
}

TEST(SkyVisibility, IsTheSameOnAllPlatforms) {
  const Sky world(kExtent, rugged);
  std::uint32_t crc = 0;
  world.for_each([&](glm::ivec3 c) {
    const std::uint8_t value = world.sky.at(c);
    crc = crc32c(std::as_bytes(std::span(&value, 1)), crc);
  });
  EXPECT_EQ(crc, 3275986713u);
}

}  // namespace
}  // namespace karst::core
