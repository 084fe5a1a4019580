// SPDX-License-Identifier: MIT
#include "terrain/ground/family_row.h"

#include "terrain/base/check.h"
#include "terrain/patch/gpu_vertex.h"

namespace karst::core {
namespace {

// Of a vertex among the children's 9 x 9.
int class_of(int i, int k) {
  constexpr int kLast = 2 * kNodeQuads;
  const bool north = k == 0;
  const bool east = i == kLast;
  const bool south = k == kLast;
  const bool west = i == 0;
  if (north && west) return family_corner(0);
  if (north && east) return family_corner(1);
  if (south && east) return family_corner(2);
  if (south && west) return family_corner(3);
  if (north) return family_edge(0);
  if (east) return family_edge(1);
  if (south) return family_edge(2);
  if (west) return family_edge(3);
  return kFamilyInside;
}

}  // namespace

void build_family_entries(std::span<std::uint8_t> out) {
  KARST_ASSERT(out.size() == kMorphEntries);
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const std::size_t first = (kFirstGroundPlace + static_cast<std::size_t>(quadrant)) * kPageVertices;
    for (int k = 0; k < kNodeSide; ++k) {
      for (int i = 0; i < kNodeSide; ++i) {
        const auto vertex = static_cast<std::size_t>(vertex_order(kNodeLevel, i, k));
        const int east = i + kNodeQuads * (quadrant & 1);
        const int south = k + kNodeQuads * (quadrant >> 1);
        out[first + vertex] = static_cast<std::uint8_t>(class_of(east, south));
      }
    }
  }
}

}  // namespace karst::core
