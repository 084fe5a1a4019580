// SPDX-License-Identifier: MIT
// The order of vertices in a slot. A vertex belongs to the coarsest level whose grid holds it: level 1's nine
// vertices, then for m = 2, 3, ... those with an odd coordinate in the grid of level m, row by row. With
// h = 2^(m-1), an even row of level m adds the h vertices of odd i, an odd row all 2h + 1 of them.
#include "terrain/patch/gpu_vertex.h"

namespace karst::core {
namespace {

Status check(int level, std::span<std::uint16_t> out) {
  if (level < 1 || level > kMaxLevel) return {StatusCode::invalid_argument, "not a level of detail", "level"};
  const auto needed = static_cast<std::size_t>(patch_vertices(level));
  if (out.size() < needed) return {StatusCode::invalid_argument, "too small for the level", "out", needed};
  return {};
}

// Calls visit(index, grid) for every vertex of the level in slot order, where grid = j * side + i.
template <class Visit>
void visit_in_order(int level, Visit visit) {
  const int side = patch_side(level);
  int index = 0;
  for (int m = 1; m <= level; ++m) {
    const int stride = 1 << (level - m);  // grid cells of `level` between neighbours of level m
    const int cells = patch_cells(m);
    for (int j = 0; j <= cells; ++j) {
      const bool odd_only = m > 1 && (j & 1) == 0;
      for (int i = odd_only ? 1 : 0; i <= cells; i += odd_only ? 2 : 1) {
        visit(index++, j * stride * side + i * stride);
      }
    }
  }
}

}  // namespace

int vertex_order(int level, int i, int j) {
  int m = level;
  while (m > 1 && ((i | j) & 1) == 0) {
    i >>= 1;
    j >>= 1;
    --m;
  }
  if (m == 1) return j * patch_side(1) + i;
  const int h = patch_cells(m - 1);
  const int row_pair = (j >> 1) * (3 * h + 1);
  const int in_pair = (j & 1) == 0 ? i >> 1 : h + i;
  return patch_vertices(m - 1) + row_pair + in_pair;
}

// A vertex of an odd row goes between its parents in the rows beside it, one of an even row between those in
// its own.
SlotRange vertices_of_rows(int level, int m, GridRows rows) {
  if (!rows.any()) return {};
  const int stride = 1 << (level - m);
  int low = (rows.low + stride - 1) / stride;
  int high = rows.high / stride;
  if (low > high) return {};
  if (m == 1) return {patch_side(1) * low, patch_side(1) * (high + 1)};
  if (low > 0 && low % 2 == 0) --low;
  if (high < patch_cells(m) && high % 2 == 0) ++high;
  const int h = patch_cells(m - 1);
  const auto begin = [&](int row) {
    return patch_vertices(m - 1) + (row >> 1) * (3 * h + 1) + ((row & 1) != 0 ? h : 0);
  };
  return {begin(low), begin(high + 1)};
}

Status build_vertex_order(int level, std::span<std::uint16_t> out) {
  if (const Status status = check(level, out); !status.ok()) return status;
  visit_in_order(level, [&](int index, int grid) {
    out[static_cast<std::size_t>(grid)] = static_cast<std::uint16_t>(index);
  });
  return {};
}

Status build_grid_order(int level, std::span<std::uint16_t> out) {
  if (const Status status = check(level, out); !status.ok()) return status;
  visit_in_order(level, [&](int index, int grid) {
    out[static_cast<std::size_t>(index)] = static_cast<std::uint16_t>(grid);
  });
  return {};
}

}  // namespace karst::core
