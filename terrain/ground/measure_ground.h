// SPDX-License-Identifier: MIT
// What is measured of nodes (NodeMeasure), size by size and row by row, so that only a few rows need to be in
// memory: of quads, of nodes, of nodes with those around.
//
// Words. The *full* surface is that of size 0; a size's surface has its diagonals as the index batches of
// patches have them: quad (i, k) from its north-west corner where i + k is even, else from its north-east
// one. So the eight triangles of a quad's four children have a corner of the quad, the middle of one of its
// edges and its centre each. The *way* of a middle or centre is what it moves by, from home to its target.
// Of a triangle T of size s, *I*(T) holds the full surface less any state of the morph from size s - 1 to s,
// over T and along y:
//   I(T) = hull over T's four children t of I(t) + [least, greatest of 0, -way of edge, -way of centre]
// and I = [0, 0] at size 0. Vertices of a quad that reaches beyond the last sample move sideways, so that
// there I = [-r, r], r being what the heights of its samples differ by.
//
// Edges are numbered as families have them (family_row.h): 0 west, 1 south, 2 east, 3 north. A quad's
// triangle 0 has its north edge, triangle 1 its south edge. Lengths are lattice steps of size 0, heights
// kVertexStep.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "terrain/ground/ground.h"

namespace karst::core {

// Nodes, or quads, of a size along an axis (0: x, 1: z).
inline std::int64_t quads_along(const GroundInfo& info, int axis, int size) {
  return (info.samples[axis] - 2 + (std::int64_t{1} << size)) >> size;
}
inline std::int64_t nodes_along(const GroundInfo& info, int axis, int size) {
  return (quads_along(info, axis, size) + kNodeQuads - 1) / kNodeQuads;
}

// A row of quads; spans of kNodeQuads x nodes_along() each.
struct QuadRow {
  std::span<std::int32_t> low, high;       // of all samples in the quad
  std::array<std::span<float>, 2> below;   // I of its triangles: least, 0 or less
  std::array<std::span<float>, 2> above;   // and greatest
  std::array<std::span<float>, 4> border;  // greatest |I + [0, -way]| of children at the edge
  std::span<float> tall;                   // greatest height that a child with its targets spans, and |I|
};

// A row of nodes; spans of nodes_along() each.
struct NodeRow {
  std::span<std::int32_t> low, high;
  std::span<float> full;  // greatest |I| of its triangles
  std::array<std::span<float>, 4> border;
  std::span<float> tall;
  std::span<float> error, chain;  // NodeMeasure's
};

// Quads of size 0. north, south: heights of kNodeQuads x nodes_along() + 1 vertices, as Tile has them beyond
// the last sample.
void measure_quads(std::span<const std::int32_t> north, std::span<const std::int32_t> south,
                   const QuadRow& out);

struct MeasureQuads {
  const GroundInfo* info = nullptr;
  int size = 1;        // 1 or more
  std::int64_t k = 0;  // the row, less than quads_along()
  // Of the next smaller size: heights of vertices in rows 2 k to 2 k + 2, and quads in rows 2 k and 2 k + 1.
  std::array<std::span<const std::int32_t>, 3> heights;
  std::array<QuadRow, 2> children;
  QuadRow out;

  void run() const;
};

// Puts a row of quads that is beyond the last one, and belongs to nodes that are not: what is above it.
void repeat_quads(const QuadRow& above, const QuadRow& out);

// Takes row k of quads into its row of nodes, in ascending order of k.
void gather_nodes(const GroundInfo& info, int size, std::int64_t k, const QuadRow& quads, const NodeRow& out);

// error and chain of a row of nodes, which touches those above and below it, and is touched by rows 2 z - 1
// to 2 z + 2 of the next smaller size. E and C of NodeMeasure, so that (1) and (2) of ground_view.h hold:
//   E(p) is the greatest of |I| in p; of |I + [0, -way]| / (1 - sigma) of children at an edge of p, and of
//   those on its other side undivided; with the rounding of vertices; of E(q) / (1 - sigma)
//   C(p) is the greatest of G reach / (1 - sigma); of (C(q) + R(q)) / (1 - sigma)
// for all nodes q of the next smaller size that touch p. Rounded up to 12 bits, which files hold in fewer
// bytes.
struct MeasureNodes {
  const GroundInfo* info = nullptr;
  int size = 0;
  // Null: there is none. Of size 0 own alone is needed.
  const NodeRow* north = nullptr;
  const NodeRow* own = nullptr;  // gathered; error and chain are the output
  const NodeRow* south = nullptr;
  std::array<const NodeRow*, 4> finer{};

  void run() const;
};

}  // namespace karst::core
