// SPDX-License-Identifier: MIT
// All patches around a corner, found by walking from edge to neighbouring edge: K's shared vertex lists
// (3.5.1.2) without the lists.
#pragma once

#include <span>

#include "terrain/surface/patch.h"

namespace karst::core {

struct PatchCorner {
  PatchId patch;
  int corner;  // 0..3; corner 0 stands for the apex (corners 0 and 3) of a collapsed patch
};

// More patches than meet at any edge point of extracted surfaces (tests/property prints the most seen). A
// walk over inconsistent adjacency stops here.
inline constexpr int kMaxCornerFan = 32;

// The apex of a collapsed patch has one name.
inline int canonical_corner(const Patch& patch, int corner) {
  return patch.collapsed != 0 && corner == 3 ? 0 : corner;
}

// Writes the patches around the corner into fan, the given one first, counter-clockwise; where the surface
// ends at this corner, those beyond the end follow clockwise. Returns how many. closed tells whether the fan
// goes all the way around.
inline int corner_fan(std::span<const Patch> patches, PatchCorner start, PatchCorner (&fan)[kMaxCornerFan],
                      bool* closed = nullptr) {
  start.corner = canonical_corner(patches[start.patch], start.corner);
  int count = 0;
  fan[count++] = start;
  if (closed != nullptr) *closed = true;
  PatchCorner at = start;
  const auto same = [](PatchCorner a, PatchCorner b) { return a.patch == b.patch && a.corner == b.corner; };
  while (count < kMaxCornerFan) {
    const Patch& p = patches[at.patch];
    int exit = (at.corner + 3) & 3;
    if (p.collapsed != 0 && exit == 3) exit = 2;  // the apex: edge 3 is a point, edge 2 ends here
    const PatchEdge next = p.neighbour[exit];
    if (!next.exists()) break;
    at = {next.patch(), canonical_corner(patches[next.patch()], next.edge())};
    if (same(at, start)) return count;
    fan[count++] = at;
  }
  if (closed != nullptr) *closed = false;
  at = start;
  while (count < kMaxCornerFan) {
    const PatchEdge next = patches[at.patch].neighbour[at.corner];
    if (!next.exists()) break;
    at = {next.patch(), canonical_corner(patches[next.patch()], (next.edge() + 1) & 3)};
    if (same(at, start)) break;
    fan[count++] = at;
  }
  return count;
}

}  // namespace karst::core
