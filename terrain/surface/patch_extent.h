// SPDX-License-Identifier: MIT
// What of a patch's grid an edit of heights moved: in which rows, and how near to its borders, which is what
// the normals of others depend on.
#pragma once

#include <cstdint>

#include "terrain/base/lattice.h"

namespace karst::core {

// Rows of a patch's grid at its full level, both ends included; none where low > high.
struct GridRows {
  std::uint8_t low = 255;
  std::uint8_t high = 0;

  static constexpr GridRows all(int level) { return {0, static_cast<std::uint8_t>(patch_cells(level))}; }
  constexpr bool any() const { return low <= high; }
  constexpr void join(GridRows other) {
    low = other.low < low ? other.low : low;
    high = other.high > high ? other.high : high;
  }
};

struct PatchExtent {
  GridRows rows;            // that hold a moved vertex
  std::uint8_t around = 0;  // bit e: a vertex on edge e or beside it moved; bit 4 + c: the same of corner c

  static constexpr PatchExtent all(int level) { return {GridRows::all(level), 0xff}; }

  void add(int level, int i, int j) {
    const int n = patch_cells(level);
    const unsigned edges =
        unsigned{j <= 1} | unsigned{i >= n - 1} << 1 | unsigned{j >= n - 1} << 2 | unsigned{i <= 1} << 3;
    // Corner c lies between edges c - 1 and c.
    const unsigned corners = edges & (edges << 1 | edges >> 3);
    around = static_cast<std::uint8_t>(around | edges | (corners & 15u) << 4);
    rows.join({static_cast<std::uint8_t>(j), static_cast<std::uint8_t>(j)});
  }
};

}  // namespace karst::core
