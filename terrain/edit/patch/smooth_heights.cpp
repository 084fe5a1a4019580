// SPDX-License-Identifier: MIT
#include "terrain/edit/patch/smooth_heights.h"

#include "terrain/patch/corner_fan.h"
#include "terrain/patch/displacement.h"

namespace karst::core {

std::int32_t HeightsAround::at(PatchId patch, int i, int j) const {
  const std::uint32_t block = surface_.patches[patch].height_block;
  return block == kNoHeights ? 0 : heights_.block(block)[j * patch_side(level_) + i];
}

// Three of the row behind an edge, counted from the edge's first corner.
void HeightsAround::add_row(PatchId patch, int edge, int t, Sum& sum) const {
  const GridLine row = GridLine::along_edge(edge, 1, level_, false);
  for (int k = t - 1; k <= t + 1; ++k) sum.add(at(patch, row.i0 + k * row.di, row.j0 + k * row.dj));
}

HeightsAround::Sum HeightsAround::around_border(PatchId patch, int edge, int t) const {
  Sum sum;
  const GridLine border = GridLine::along_edge(edge, 0, level_, false);
  for (const int k : {t - 1, t + 1}) sum.add(at(patch, border.i0 + k * border.di, border.j0 + k * border.dj));
  add_row(patch, edge, t, sum);
  const PatchEdge other = surface_.patches[patch].neighbour[edge];
  if (other.exists()) add_row(other.patch(), other.edge(), patch_cells(level_) - t, sum);
  return sum;
}

HeightsAround::Sum HeightsAround::around_corner(PatchId patch, int corner) const {
  Sum sum;
  const int n = patch_cells(level_);
  PatchCorner fan[kMaxCornerFan];
  const int count = corner_fan(surface_.patches, {patch, corner}, fan);
  const auto add = [&](PatchId id, const GridLine& line, int t) {
    sum.add(at(id, line.i0 + t * line.di, line.j0 + t * line.dj));
  };
  for (int f = 0; f < count; ++f) {
    const PatchId id = fan[f].patch;
    const Patch& own = surface_.patches[id];
    const int c = fan[f].corner;
    const bool is_apex = own.collapsed != 0 && c == 0;
    add(id, GridLine::along_edge(c, 0, level_, false), 1);
    // The edge that ends here is the next patch's, too.
    const int before = is_apex ? 2 : (c + 3) & 3;
    if (!own.neighbour[before].exists()) add(id, GridLine::along_edge(before, 0, level_, false), n - 1);
    if (is_apex) {
      sum.add(at(id, 1, n / 2));
    } else {
      add(id, GridLine::along_edge(c, 1, level_, false), 1);
    }
  }
  return sum;
}

double HeightsAround::mean(PatchId patch, int i, int j) const {
  const int n = patch_cells(level_);
  Sum sum;
  const bool on_i = i == 0 || i == n, on_j = j == 0 || j == n;
  if (i == 0 && surface_.patches[patch].collapsed != 0) {
    sum = around_corner(patch, 0);
  } else if (on_i && on_j) {
    sum = around_corner(patch, j == 0 ? (i == 0 ? 0 : 1) : (i == 0 ? 3 : 2));
  } else if (on_j) {
    sum = around_border(patch, j == 0 ? 0 : 2, j == 0 ? i : n - i);
  } else if (on_i) {
    sum = around_border(patch, i == n ? 1 : 3, i == n ? j : n - j);
  } else {
    for (int dj = -1; dj <= 1; ++dj) {
      for (int di = -1; di <= 1; ++di) {
        if (di != 0 || dj != 0) sum.add(at(patch, i + di, j + dj));
      }
    }
  }
  return static_cast<double>(sum.heights) / sum.count;
}

}  // namespace karst::core
