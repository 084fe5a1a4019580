// SPDX-License-Identifier: MIT
// How the surface goes through a cell, for all states of its corners, generated at compile time from one rule
// (L 3.2, 4.3): on each face there is a curve around each run of solid corners, so that solid corners that
// are diagonal stay apart. A face looks the same from both its sides: no choice is left, and cells close
// against each other whatever they hold. Curves close into loops, and loops are cut into triangles so that no
// inner edge lies in a face that another cell has, too.
//
// Cells of one resolution have eight corners, o = x + 2y + 4z, and 256 states; bit o: corner o is solid.
// A transition cell stands between a face of four fine cells and one of a coarse cell. It has nine samples,
// s = u + 3v, and 512 states; the coarse face has those of its corners. w = u x v leads from the fine face to
// the coarse one.
//
// Triangles are counter-clockwise as seen from the empty side.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace karst::core {

inline constexpr int kCellEdges = 12;
inline constexpr int kTransitionEdges = 16;
inline constexpr std::size_t kMostCellTriangles = 5;
inline constexpr std::size_t kMostTransitionTriangles = 9;

// Edge 4a + k of a cell runs along axis a; of the other two axes the lower one is at k & 1, the higher one at
// k >> 1.
constexpr int edge_axis(int edge) {
  return edge >> 2;
}
constexpr std::array<int, 3> edge_start(int edge) {
  const int a = edge & 1, b = edge >> 1 & 1;
  if (edge >> 2 == 0) return {0, a, b};
  return edge >> 2 == 1 ? std::array<int, 3>{a, 0, b} : std::array<int, 3>{a, b, 0};
}

// Edges of a transition cell: 0..5 along u, u + 2v; 6..11 along v, 6 + u + 3v; (u, v) is where they begin.
// Those of the coarse face: 12 and 13 along u at v = 0 and 2, 14 and 15 along v at u = 0 and 2.
inline constexpr int kFirstCoarseEdge = 12;

template <std::size_t kMost>
struct CellCase {
  std::uint8_t triangles = 0;
  std::uint8_t edge[3 * kMost]{};  // three a triangle: vertices lie on edges
};

extern const std::array<CellCase<kMostCellTriangles>, 256> kCellTable;
extern const std::array<CellCase<kMostTransitionTriangles>, 512> kTransitionTable;

}  // namespace karst::core
