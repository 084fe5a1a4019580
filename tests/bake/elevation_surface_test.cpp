// SPDX-License-Identifier: MIT
// Voids that are filled, and the surface between samples.
#include "bake/elevation/elevation.h"

#include <gtest/gtest.h>

#include <cmath>

namespace karst::bake {
namespace {

TEST(FillVoids, PlaneStaysAPlaneAndRangeIsKept) {
  Elevation e;
  e.width = 40;
  e.height = 33;
  for (int j = 0; j < e.height; ++j) {
    for (int i = 0; i < e.width; ++i) {
      const bool in_hole = (i > 10 && i < 25 && j > 8 && j < 20) || (i > 30 && j < 4);
      e.heights_m.push_back(in_hole ? 0.0f : static_cast<float>(3 * i + 2 * j));
      e.valid.push_back(in_hole ? 0 : 1);
    }
  }
  const std::vector<std::uint8_t> known = e.valid;
  fill_voids(e);
  for (int j = 0; j < e.height; ++j) {
    for (int i = 0; i < e.width; ++i) {
      const std::size_t k = e.at(i, j);
      const float plane = static_cast<float>(3 * i + 2 * j);
      if (known[k] != 0) {
        ASSERT_EQ(e.heights_m[k], plane);
      } else if (i < 30) {  // harmonic inside known samples: the plane again
        EXPECT_NEAR(e.heights_m[k], plane, 1.5) << i << ' ' << j;
      } else {  // open to the border: smooth, within what surrounds it
        EXPECT_GT(e.heights_m[k], 85);
        EXPECT_LT(e.heights_m[k], 130);
      }
      ASSERT_EQ(e.valid[k], 1);
    }
  }
}

TEST(FillVoids, OneSampleFillsEverything) {
  Elevation e;
  e.width = 9;
  e.height = 2;
  e.heights_m.assign(18, 0);
  e.valid.assign(18, 0);
  e.heights_m[13] = 42;
  e.valid[13] = 1;
  fill_voids(e);
  for (const float h : e.heights_m) EXPECT_EQ(h, 42);
}

TEST(ElevationSurface, IsBilinearAndClamped) {
  Elevation e;
  e.width = 3;
  e.height = 2;
  e.heights_m = {0, 10, 20, 100, 110, 130};
  e.valid = {1, 1, 0, 1, 1, 1};
  e.spacing_x_m = 4;
  e.spacing_z_m = 2;
  const ElevationSurface s(e);
  EXPECT_EQ(s.half_width_m(), 4);
  EXPECT_EQ(s.half_height_m(), 1);
  EXPECT_EQ(s.at(-4, -1), 0);
  EXPECT_EQ(s.at(4, 1), 130);
  EXPECT_EQ(s.at(0, -1), 10);
  EXPECT_EQ(s.at(2, 0), (15 + 120) / 2.0);
  EXPECT_EQ(s.at(-100, -100), 0);
  EXPECT_EQ(s.at(100, 100), 130);
  EXPECT_EQ(s.at(std::nan(""), -1), 0);
  EXPECT_EQ(s.validity(4, -1), 0);
  EXPECT_EQ(s.validity(2, -1), 0.5);
  EXPECT_EQ(s.validity(-2, 0), 1);
}

}  // namespace
}  // namespace karst::bake
