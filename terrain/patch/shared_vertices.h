// SPDX-License-Identifier: MIT
// All grid vertices that are one vertex of the surface: copies of a border vertex in the patches that share
// it, and the collapsed edge of a three-edge patch. Whoever writes a height writes it to all of them.
#pragma once

#include "terrain/patch/corner_fan.h"
#include "terrain/patch/displacement.h"

namespace karst::core {

struct GridVertex {
  PatchId patch;
  int i, j;
};

// Calls visit(GridVertex) once for every copy of vertex (i, j) of a patch at a level, itself first.
template <class Visitor>
void for_each_copy(std::span<const Patch> patches, int level, GridVertex v, Visitor&& visit) {
  const int n = patch_cells(level);
  if (v.i > 0 && v.i < n && v.j > 0 && v.j < n) {
    visit(v);
    return;
  }
  const auto visit_apex = [&](PatchId p) {
    for (int j = 0; j <= n; ++j) visit(GridVertex{p, 0, j});
  };
  const bool corner = (v.i == 0 || v.i == n) && (v.j == 0 || v.j == n);
  const bool on_apex = patches[v.patch].collapsed != 0 && v.i == 0;
  if (!corner && !on_apex) {
    visit(v);
    for (int e = 0; e < 4; ++e) {
      const GridLine line = GridLine::along_edge(e, 0, level, false);
      const int t = line.di != 0 ? (v.i - line.i0) * line.di : (v.j - line.j0) * line.dj;
      if (line.i0 + t * line.di != v.i || line.j0 + t * line.dj != v.j) continue;
      const PatchEdge other = patches[v.patch].neighbour[e];
      if (!other.exists()) return;
      const GridLine theirs = GridLine::along_edge(other.edge(), 0, level, true);
      visit(GridVertex{other.patch(), theirs.i0 + t * theirs.di, theirs.j0 + t * theirs.dj});
      return;
    }
    return;
  }
  const int which = on_apex ? 0 : (v.j == 0 ? (v.i == 0 ? 0 : 1) : (v.i == 0 ? 3 : 2));
  PatchCorner fan[kMaxCornerFan];
  const int count = corner_fan(patches, {v.patch, which}, fan);
  for (int f = 0; f < count; ++f) {
    const int c = fan[f].corner;
    if (patches[fan[f].patch].collapsed != 0 && c == 0) {
      visit_apex(fan[f].patch);
    } else {
      visit(GridVertex{fan[f].patch, c == 1 || c == 2 ? n : 0, c >= 2 ? n : 0});
    }
  }
}

}  // namespace karst::core
