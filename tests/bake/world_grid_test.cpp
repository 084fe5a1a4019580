// SPDX-License-Identifier: MIT
// Where voxels lie, column tops, and the taking away of what is one voxel wide.
#include "bake/elevation/elevation_solid.h"
#include "bake/voxels/settle_voxels.h"
#include "tests/bake/bake_jobs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace karst::bake {
namespace {

std::string error_of(const Box& box, double voxel_m) {
  WorldGrid grid;
  return WorldGrid::around(box, voxel_m, grid).text();
}

TEST(WorldGrid, ContentIsCentredAndPadded) {
  const WorldGrid grid = grid_around({{-500, 95, -250}, {500, 321, 250}}, 10);
  EXPECT_EQ(grid.extent, glm::ivec3(101, 2 + 24 + 1, 51));
  EXPECT_EQ(grid.origin_m, glm::dvec3(-505, 70, -255));  // half a voxel around, two layers below 90
  EXPECT_EQ(grid.depth, 7);
  EXPECT_EQ(grid.to_m({0.5, 2, 50.5}), glm::dvec3(-500, 90, 250));
}

TEST(WorldGrid, CutsToWholeVoxels) {
  const WorldGrid grid = grid_around({{-14, 0, -10}, {14, 1, 10}}, 8);
  EXPECT_EQ(grid.extent.x, 4);  // three whole voxels of content
  EXPECT_EQ(grid.origin_m.x, -16);
  EXPECT_EQ(grid.extent.z, 3);
}

TEST(WorldGrid, NamesTheVoxelSizeThatIsWrong) {
  EXPECT_NE(error_of({{-500, 0, -500}, {500, 10, 500}}, 1).find("--voxel"), std::string::npos);
  EXPECT_NE(error_of({{-5, 0, -5}, {5, 1000, 5}}, 1).find("along y"), std::string::npos);
  EXPECT_NE(error_of({{-5, 0, -5}, {5, 1, 5}}, 11).find("wider than the world"), std::string::npos);
  EXPECT_NE(error_of({{-1e9, 0, -1e9}, {1e9, 1, 1e9}}, 1e-6).find("--voxel"), std::string::npos);
  // 512 voxels are the most there are: 511 of content.
  EXPECT_EQ(error_of({{0, 0, 0}, {511, 1, 511}}, 1), "");
  EXPECT_EQ(error_of({{0, 0, 0}, {511.9, 1, 511.9}}, 1), "") << "what is left of a voxel is cut away";
  EXPECT_NE(error_of({{0, 0, 0}, {512, 1, 511}}, 1), "");
}

// What is suggested works, as it is printed, and is not much larger than what does not.
TEST(WorldGrid, SuggestedVoxelSizeFits) {
  const auto check = [](const Box& box, double voxel_m) {
    const std::string message = error_of(box, voxel_m);
    const std::size_t at = message.find("try --voxel ");
    ASSERT_NE(at, std::string::npos) << message;
    const double suggested = std::stod(message.substr(at + 12));
    EXPECT_EQ(error_of(box, suggested), "") << message;
    if (suggested > voxel_m) {
      EXPECT_NE(error_of(box, suggested / 1.2), "") << message;
    }
  };
  check({{0, 0, 0}, {10'000, 100, 700}}, 3);
  check({{0, 0, 0}, {700, 100, 10'000}}, 19);
  check({{0, 0, 0}, {512, 1, 511}}, 1);
  check({{-5, 0, -5}, {5, 1'000, 5}}, 1);
  check({{-5, 8'848.86, -5}, {5, 9'358.9, 5}}, 1);
  check({{0, -0.26, 0}, {0.9, 0.77, 0.5}}, 0.001);
  check({{0, 0, 0}, {1e9, 1, 1e9}}, 1e-6);
  check({{-1e-3, 0, -1e-3}, {1e-3, 1e-3, 1e-3}}, 1e-6);
  check({{-5, 0, -5}, {5, 1, 5}}, 11);
  for (double size = 100; size < 1'000; size *= 1.007) check({{0, 0.3, 0}, {size, size * 1.7, 20}}, 0.1);
}

TEST(WorldGrid, WhereNoVoxelSizeFitsNoneIsSuggested) {
  for (const double voxel_m : {0.3, 0.4275, 0.51, 0.7}) {
    const std::string message = error_of({{0, 500, 0}, {256, 501, 0.5}}, voxel_m);
    EXPECT_NE(message.find("no size fits"), std::string::npos) << message;
  }
  EXPECT_NE(error_of({{-5, 0, -5}, {5, 9'000, 5}}, 11).find("no size fits"), std::string::npos);
  // A half of the shorter side is too small, all of it is not.
  EXPECT_NE(error_of({{0, 0, 0}, {400, 1, 1}}, 3).find("try --voxel 0.99"), std::string::npos);
}

Elevation slope(int width, int height) {
  Elevation e;
  e.width = width;
  e.height = height;
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) e.heights_m.push_back(static_cast<float>(2 * i + j));
  }
  e.valid.assign(e.heights_m.size(), 1);
  return e;
}

TEST(ColumnTops, AreMeansOfTheFootprint) {
  const Elevation e = slope(41, 31);
  const ElevationSolid solid(e, false);
  const WorldGrid grid = grid_around({{-20, 0, -15}, {20, 110, 15}}, 10);
  const auto tops = column_tops(solid, e, grid, 1);
  ASSERT_EQ(tops.size(), 5u * 4u);
  // The plane's mean over an inner column is its height at the middle: 2 * 20 + 15 = 55 m at the world's
  // centre.
  const auto mean = [&](int x, int z) {
    return (55 + 2 * ((x + 0.5) * 10 - 25) + ((z + 0.5) * 10 - 20)) / 10 + 2;
  };
  for (int z = 1; z < 3; ++z) {
    for (int x = 1; x < 4; ++x) EXPECT_NEAR(tops[static_cast<std::size_t>(z * 5 + x)], mean(x, z), 0.5001);
  }
  EXPECT_EQ(column_tops(solid, e, grid, 3), tops);
}

TEST(ColumnTops, HolesHaveNone) {
  Elevation e = slope(41, 31);
  for (int j = 0; j < 31; ++j) {
    for (int i = 0; i < 16; ++i) e.valid[e.at(i, j)] = 0;
  }
  const ElevationSolid solid(e, true);
  const WorldGrid grid = grid_around({{-20, 0, -15}, {20, 110, 15}}, 10);
  const auto tops = column_tops(solid, e, grid, 1);
  for (int z = 0; z < 4; ++z) {
    for (int x = 0; x < 5; ++x) {
      EXPECT_EQ(std::isnan(tops[static_cast<std::size_t>(z * 5 + x)]), x < 2) << x << ' ' << z;
    }
  }
  // The sides of the hole: the solid ends between the last void column of samples and the next.
  EXPECT_LT(solid.value_m({-20 + 15.4, -100, 0}), 0);
  EXPECT_GT(solid.value_m({-20 + 15.6, -100, 0}), 0);
}

// Rules of settle_tops, counted where they are broken.
int broken_rules(const std::vector<float>& tops, int width, int height) {
  const auto top = [&](int x, int z) {
    return tops[static_cast<std::size_t>(std::clamp(z, 0, height - 1) * width + std::clamp(x, 0, width - 1))];
  };
  int broken = 0;
  for (int z = 0; z < height; ++z) {
    for (int x = 0; x < width; ++x) {
      int as_high = 0, as_low = 0;
      for (const auto& [i, j] : {std::pair{x - 1, z}, {x + 1, z}, {x, z - 1}, {x, z + 1}}) {
        as_high += top(i, j) >= top(x, z) ? 1 : 0;
        as_low += top(i, j) <= top(x, z) ? 1 : 0;
      }
      broken += as_high < 2 || as_low < 2 ? 1 : 0;
      if (x + 1 == width || z + 1 == height) continue;
      const float a = top(x, z), b = top(x + 1, z), c = top(x + 1, z + 1), d = top(x, z + 1);
      broken += std::min(a, c) > std::max(b, d) || std::min(b, d) > std::max(a, c) ? 1 : 0;
    }
  }
  return broken;
}

TEST(SettleTops, LeavesNoTipPitOrDiagonal) {
  constexpr int kWidth = 60, kHeight = 50;
  std::uint32_t state = 7;
  const auto random = [&] {
    state = state * 1664525u + 1013904223u;
    return static_cast<float>(state >> 8) / 16777216.0f;
  };
  for (int run = 0; run < 20; ++run) {
    std::vector<float> tops(kWidth * kHeight);
    for (int k = 0; k < kWidth * kHeight; ++k) {
      const float hills = 5 + 3 * std::sin(0.2f * static_cast<float>(k % kWidth)) +
                          3 * std::cos(0.17f * static_cast<float>(k / kWidth));
      tops[static_cast<std::size_t>(k)] = hills + 1.5f * random();
    }
    std::vector<float> rounded = tops;
    for (float& t : rounded) t = std::ceil(t - 0.5f);
    ASSERT_GT(broken_rules(rounded, kWidth, kHeight), 50);
    const std::vector<float> means = tops;
    settle_tops(tops, kWidth, kHeight);
    EXPECT_EQ(broken_rules(tops, kWidth, kHeight), 0);
    for (std::size_t k = 0; k < tops.size(); ++k) {
      EXPECT_EQ(tops[k], std::round(tops[k]));
      ASSERT_NEAR(tops[k], means[k], 2.6f);
    }
  }
}

TEST(SettleTops, KeepsSlopesAndHoles) {
  const float hole = std::numeric_limits<float>::quiet_NaN();
  std::vector<float> tops = {1, 1, 2, 3, 1, 1, 2, 3, hole, hole, 2, 3};
  const std::vector<float> before = tops;
  settle_tops(tops, 4, 3);
  for (std::size_t k = 0; k < tops.size(); ++k) {
    if (std::isnan(before[k])) {
      EXPECT_TRUE(std::isnan(tops[k]));
    } else {
      EXPECT_EQ(tops[k], before[k]);
    }
  }
}

std::vector<float> box_of_air(glm::ivec3 extent) {
  return std::vector<float>(static_cast<std::size_t>(extent.x * extent.y * extent.z), -1.0f);
}

TEST(SettleVoxels, TakesTipsAndKeepsBodies) {
  const glm::ivec3 extent(9, 9, 9);
  std::vector<float> values = box_of_air(extent);
  const auto at = [&](int x, int y, int z) -> float& {
    return values[static_cast<std::size_t>((z * 9 + y) * 9 + x)];
  };
  for (int z = 2; z < 6; ++z) {
    for (int y = 0; y < 4; ++y) {
      for (int x = 2; x < 6; ++x) at(x, y, z) = 1;
    }
  }
  const std::vector<float> body = values;
  EXPECT_EQ((SettleVoxels{extent, values}.run()), 0u);
  EXPECT_EQ(values, body);
  at(3, 4, 3) = 1;   // a lone voxel on top
  at(7, 6, 7) = 1;   // one in the air
  at(4, 2, 2) = -1;  // a dent of one voxel
  EXPECT_EQ((SettleVoxels{extent, values}.run()), 3u);
  EXPECT_LT(at(3, 4, 3), 0);
  EXPECT_LT(at(7, 6, 7), 0);
  EXPECT_GT(at(4, 2, 2), 0);
}

TEST(SettleVoxels, PartsDiagonalsAtTheLeastSureVoxel) {
  const glm::ivec3 extent(8, 6, 8);
  std::vector<float> values = box_of_air(extent);
  const auto at = [&](int x, int y, int z) -> float& {
    return values[static_cast<std::size_t>((z * 6 + y) * 8 + x)];
  };
  // Two quarters of the box that meet along a vertical edge.
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < 8; ++x) at(x, y, z) = (x < 4) == (z < 4) ? 1.0f : -1.0f;
    }
  }
  for (int y = 0; y < 4; ++y) at(4, y, 3) = -0.1f;
  SettleVoxels{extent, values}.run();
  for (int y = 0; y < 4; ++y) {
    const bool a = at(3, y, 3) > 0, b = at(4, y, 3) > 0, c = at(4, y, 4) > 0, d = at(3, y, 4) > 0;
    EXPECT_FALSE(a == c && b == d && a != b) << y;
  }
  EXPECT_GT(at(4, 1, 3), 0);
}

TEST(SettleVoxels, TopLayerStaysAir) {
  const glm::ivec3 extent(5, 4, 5);
  std::vector<float> values(5 * 4 * 5, 1.0f);
  for (int z = 0; z < 5; ++z) {
    for (int x = 0; x < 5; ++x) values[static_cast<std::size_t>((z * 4 + 3) * 5 + x)] = -1;
  }
  EXPECT_EQ((SettleVoxels{extent, values}.run()), 0u);
}

}  // namespace
}  // namespace karst::bake
