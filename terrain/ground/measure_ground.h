// SPDX-License-Identifier: MIT
// What is measured of nodes (NodeMeasure), size by size and row by row, so that only a few rows need to be in
// memory: of quads, of nodes, of nodes with those around.
//
// Words. The *full* surface is that of size 0; a size's surface has its diagonals as the index batches of
// patches have them: quad (i, k) from its north-west corner where i + k is even, else from its north-east
// one. So the eight triangles of a quad's four children have a corner of the quad, the middle of one of its
// edges and its centre each. The *way* of a middle or centre is what it moves by, from home to its target. In
// a *state* each of them has gone any share of its way.
//
// Bands. How near a drawn point is to the eye follows from the vertices that move there: a deviation is kept
// with how far the point is from one of them (morph.h: G reach). In a child triangle m is the middle, c the
// centre; e11 is the deviation of the full surface from the state in which both have arrived, e10 from that
// in which m has and c has not, e01 the other way round, e00 with both at home; dm and dc are the distances
// of the full surface's point from m and c at home. With rho >= (1 - sigma) D + s sigma D where a vertex has
// gone the share s > 0 of its way, and k e00 <= (1 - sigma) D - G d by (2) of ground_view.h for all d within
// a child, each point of the triangle is within the bound if
//   D >= k e11 + G dm, k e10 + G dm, (k e01 + G dm) / (1 - sigma) and k e01 + G dc
// or the same with m and c exchanged: deviations are linear in the two shares, and what is to hold is linear
// in them from one of e00, e10 (or e01) and e11 to the next. The first is asked of points nearer to m, the
// second of points nearer to c, or the other way round where deviations are smaller then, and the second
// wherever m lies on the node's border: there it may have gone further than its own threshold says. A band
// holds the points for which d, over 1 - sigma where the deviation is, is at most a share of a child quad's
// diagonal (kBandReach), the last one the rest.
//
// Deviations are along y, and exact at the vertices of a *reference* grid kReferenceSizes finer, where they
// are largest but for what the reference itself strays from the full surface, which is known of each of its
// quads. So the sizes up to kReferenceSizes are exact, and coarser ones off by little.
//
// A quad that reaches beyond the last sample has vertices that move sideways. There all states lie, like the
// full surface, between two planes that are parallel to its slope; the distance of the planes counts.
//
// Of a curved basis deviations in height are measured alike, and MeasureNodes adds the most that the basis
// itself bends, in space; nodes that bend by more than is drawn have thresholds that nothing is beyond.
//
// Edges are numbered as families have them (family_row.h): 0 west, 1 south, 2 east, 3 north. Lengths are
// lattice steps of size 0, heights kVertexStep.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "terrain/ground/ground.h"
#include "terrain/ground/tile.h"

namespace karst::core {

// Quads, or nodes, of a size along an axis (0: x, 1: z).
inline std::int64_t quads_along(const GroundInfo& info, int axis, int size) {
  return (info.samples[axis] - 2 + (std::int64_t{1} << size)) >> size;
}
inline std::int64_t nodes_along(const GroundInfo& info, int axis, int size) {
  return (quads_along(info, axis, size) + kNodeQuads - 1) / kNodeQuads;
}

inline constexpr int kReferenceSizes = 5;
constexpr int reference_size(int size) {
  return size > kReferenceSizes ? size - kReferenceSizes : 0;
}
inline constexpr int kMostReferenceRows = 1 << kReferenceSizes;  // of the reference's quads in one

// In diagonals of a child quad, as seen from above; of the last band: of all that a child spans.
inline constexpr int kBands = 7;
inline constexpr double kBandReach[kBands - 1] = {0.125, 0.25, 0.375, 0.5, 0.75, 1.0};

// A row of quads; spans of kNodeQuads x nodes_along() each.
struct QuadRow {
  std::span<std::int32_t> low, high;  // of all samples in the quad
  std::span<float> below, above;      // the full surface less the size's own: least, 0 or less; and greatest
  std::array<std::span<float>, kBands>
      most;  // by band: greatest deviation as the morph from the size below counts
  std::array<std::span<float>, 4>
      border;             // at each edge of a node, the same with the edge's middle alone on its way; else 0
  std::span<float> tall;  // greatest height that a child spans, with its targets
};

// A row of nodes; spans of nodes_along() each, but thresholds, of kDemands times as many.
struct NodeRow {
  std::span<std::int32_t> low, high;
  std::array<std::span<float>, kBands> most;
  std::array<std::span<float>, 4> border;
  std::span<float> tall;
  std::span<std::uint16_t> thresholds;  // NodeMeasure's, node by node
};

// Quads of size 0. north, south: heights of kNodeQuads x nodes_along() + 1 vertices, as Tile has them beyond
// the last sample.
void measure_quads(std::span<const std::int32_t> north, std::span<const std::int32_t> south,
                   const QuadRow& out);

struct MeasureQuads {
  const GroundInfo* info = nullptr;
  int size = 1;        // 1 or more
  std::int64_t k = 0;  // the row, less than quads_along()
  // Of r = reference_size(size), n = 2^(size - r): heights of vertices in the n + 1 rows from n k on, and
  // quads in the n rows from n k on. Rows beyond the last one are as the last one, and quads there are not
  // looked at.
  std::span<const std::span<const std::int32_t>> heights;
  std::span<const QuadRow> finer;
  QuadRow out;

  // All of it.
  void run() const { run(0, static_cast<std::int64_t>(out.low.size())); }
  // Quads first .. last - 1, of which some may be beyond the ground. Ranges may be measured by several
  // threads.
  void run(std::int64_t first, std::int64_t last) const;
};

// Takes row k of quads into its row of nodes, in ascending order of k.
void gather_nodes(const GroundInfo& info, int size, std::int64_t k, const QuadRow& quads, const NodeRow& out);

// Thresholds of a row of nodes, which touches those above and below it, and is touched by rows 2 z - 1 to 2 z
// + 2 of the next smaller size. D(k) is the greatest of
//   k error + G reach of each band, error being its greatest deviation and the rounding of vertices; of the
//   middles of its border alone on their way k error + G reach, over 1 - sigma in the node and undivided on
//   its other side; G reach / (1 - sigma); and
//   (D(q)(k) + R(q)) / (1 - sigma) for each node q of the next smaller size that touches it
// and the first node of a ground that closes, of what ends in the middle of the last one's family there
// (has_seam_inside()) and in those beside it, too,
// so that (1) and (2) of ground_view.h hold; of a node that has a region in part, so that (3) holds, also
//   k region.error + G (region.reach + the diagonal of the node's box).
struct RegionMeasure {
  // How far what is seen of the region is from the ground that stands for it where the region is not drawn.
  double error = 0;
  double reach = 0;  // diagonal of a box of the region and of the ground beneath it
};

struct MeasureNodes {
  const GroundInfo* info = nullptr;
  int size = 0;
  // Null: there is none. Of size 0 own alone is needed.
  const NodeRow* north = nullptr;
  const NodeRow* own = nullptr;  // gathered; thresholds are the output
  const NodeRow* south = nullptr;
  std::array<const NodeRow*, 4> finer{};
  std::int64_t first = 0, z = 0;           // own's first node; used where the ground has regions
  std::span<const RegionMeasure> regions;  // of them

  void run() const;
};

}  // namespace karst::core
