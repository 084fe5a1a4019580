// SPDX-License-Identifier: MIT
// The row of thresholds that a family of nodes has on the GPU, in the place of a patch's
// (terrain/lod/morph.h).
//
// All four children of a node leave home by its one threshold, but on its border: there, by the least one of
// all nodes of its size that share the vertex. So a row has nine classes: inside, the parent's four edges,
// its four corners. A page of a node has place kFirstGroundPlace + quadrant in its texel, which no patch's
// chain reaches; the table of entries by vertex of a slot goes on with theirs.
#pragma once

#include <cstdint>
#include <span>

#include "terrain/ground/ground.h"
#include "terrain/lod/morph.h"
#include "terrain/resident/page_table.h"

namespace karst::core {

inline constexpr int kFamilyClasses = 9;
// Entries in a row. A node's slot is that of a patch (gpu_vertex.h) whose i runs south and whose j runs east,
// so that its triangles face up: vertex (i, j) has index vertex_order(kNodeLevel, i, j). Edges are numbered
// as those of patches: 0 west, 1 south, 2 east, 3 north. Corner c is where edge c begins: 0 north-west, 1
// south-west, 2 south-east, 3 north-east.
inline constexpr int kFamilyInside = 1;
constexpr int family_edge(int edge) {
  return 2 + edge;
}
constexpr int family_corner(int corner) {
  return 6 + corner;
}
static_assert(family_corner(3) == kFamilyClasses && kFamilyClasses < kMorphRow);

inline constexpr std::uint32_t kFirstGroundPlace = 252;
static_assert(kMostSlotPages <= kFirstGroundPlace && kFirstGroundPlace + 4 == kMostPlaces);
static_assert(kMostSize <= kMostPageSize);
// Entries of all slots' vertices, patches' and nodes': places of pages have 8 bits.
inline constexpr std::uint32_t kMorphEntries = kMostPlaces * kPageVertices;

// Fills what build_morph_entries() leaves of a table of kMorphEntries entries: those of nodes.
// Precondition: out.size() == kMorphEntries.
void build_family_entries(std::span<std::uint8_t> out);

}  // namespace karst::core
