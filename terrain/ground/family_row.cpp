// SPDX-License-Identifier: MIT
#include "terrain/ground/family_row.h"

#include "terrain/base/check.h"
#include "terrain/patch/gpu_vertex.h"

namespace karst::core {
namespace {

// Of a vertex among the children's 9 x 9: south and east of their north-west corner.
int class_of(int south, int east) {
  constexpr int kLast = 2 * kNodeQuads;
  const bool on[4] = {east == 0, south == kLast, east == kLast, south == 0};  // edges
  for (int edge = 0; edge < 4; ++edge) {
    if (on[edge] && on[(edge + 3) % 4]) return family_corner(edge);
  }
  for (int edge = 0; edge < 4; ++edge) {
    if (on[edge]) return family_edge(edge);
  }
  return kFamilyInside;
}

}  // namespace

void build_family_entries(std::span<std::uint8_t> out) {
  KARST_ASSERT(out.size() == kMorphEntries);
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const std::size_t first = (kFirstGroundPlace + static_cast<std::size_t>(quadrant)) * kPageVertices;
    for (int j = 0; j < kNodeSide; ++j) {
      for (int i = 0; i < kNodeSide; ++i) {
        const auto vertex = static_cast<std::size_t>(vertex_order(kNodeLevel, i, j));
        const int south = i + kNodeQuads * (quadrant >> 1);
        const int east = j + kNodeQuads * (quadrant & 1);
        out[first + vertex] = static_cast<std::uint8_t>(class_of(south, east));
      }
    }
    // Those below the corners go with them.
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const int i = corner == 1 || corner == 2 ? kNodeQuads : 0;
      const int j = corner == 2 || corner == 3 ? kNodeQuads : 0;
      out[first + kNodeVertices + corner] =
          out[first + static_cast<std::size_t>(vertex_order(kNodeLevel, i, j))];
    }
  }
}

}  // namespace karst::core
