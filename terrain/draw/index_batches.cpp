// SPDX-License-Identifier: MIT
// The nine batches (K 4.4.3, figures 4.22 - 4.25) over K's pattern (3.5.2, figure 3.27, algorithm 3.2): the
// grid is tiled by 2 x 2 cells, and eight triangles stand around each tile's centre. K winds them for a v
// axis that runs down the rows (equation 3.9); here v runs up with j, so they are wound the other way.
//
// A border triangle has two vertices on an edge of the patch. Where the neighbour is one level lower, the two
// border triangles of a tile become one, which skips the odd border vertex (K figure 4.22).
#include "terrain/draw/index_batches.h"

#include <algorithm>

#include "terrain/patch/gpu_vertex.h"

namespace karst::core {
namespace {

// Tiles in a strip of the interior. Strips are walked half a tile row at a time, which gives a post-transform
// cache of 16 entries all but one of a row's vertices back; 3 and 5 tiles do worse (index_test prints the
// misses).
constexpr int kStripTiles = 4;

struct GridVertex {
  int i, j;
};

class Writer {
 public:
  Writer(int level, std::uint16_t* out) : level_(level), out_(out) {}

  void triangle(GridVertex a, GridVertex b, GridVertex c) {
    for (const GridVertex v : {a, b, c}) *out_++ = static_cast<std::uint16_t>(vertex_order(level_, v.i, v.j));
  }
  std::uint16_t* end() const { return out_; }

 private:
  int level_;
  std::uint16_t* out_;
};

// The vertices around a tile's centre, counter-clockwise. Triangle t of a tile runs from ring vertex t to t +
// 1 and to the centre; triangles 2e and 2e + 1 stand on the tile's side e.
constexpr GridVertex kRing[9] = {{-1, -1}, {0, -1}, {1, -1}, {1, 0},  {1, 1},
                                 {0, 1},   {-1, 1}, {-1, 0}, {-1, -1}};

void write_interior(int level, Writer& out) {
  const int tiles = patch_cells(level) / 2;
  const int last = tiles - 1;
  const auto write = [&](int a, int b, int t) {
    const bool border[4] = {b == 0, a == last, b == last, a == 0};
    if (border[t / 2]) return;
    const GridVertex centre = {2 * a + 1, 2 * b + 1};
    const GridVertex from = {centre.i + kRing[t].i, centre.j + kRing[t].j};
    const GridVertex to = {centre.i + kRing[t + 1].i, centre.j + kRing[t + 1].j};
    out.triangle(from, to, centre);
  };
  for (int strip = 0; strip < tiles; strip += kStripTiles) {
    const int strip_end = std::min(strip + kStripTiles, tiles);
    for (int b = 0; b < tiles; ++b) {
      for (int a = strip; a < strip_end; ++a) {
        for (const int t : {7, 0, 1, 2}) write(a, b, t);
      }
      for (int a = strip; a < strip_end; ++a) {
        for (const int t : {6, 5, 4, 3}) write(a, b, t);
      }
    }
  }
}

// The vertex s cells along edge e and depth cells inside it, seen from the edge's first corner.
GridVertex from_edge(int level, int edge, int s, int depth) {
  const int n = patch_cells(level);
  switch (edge) {
    case 0:
      return {s, depth};
    case 1:
      return {n - depth, s};
    case 2:
      return {n - s, n - depth};
    default:
      return {depth, n - s};
  }
}

void write_edge(int level, int edge, bool lower, Writer& out) {
  for (int s = 0; s < patch_cells(level); s += 2) {
    const GridVertex first = from_edge(level, edge, s, 0);
    const GridVertex middle = from_edge(level, edge, s + 1, 0);
    const GridVertex second = from_edge(level, edge, s + 2, 0);
    const GridVertex centre = from_edge(level, edge, s + 1, 1);
    if (lower) {
      out.triangle(first, second, centre);
    } else {
      out.triangle(first, middle, centre);
      out.triangle(middle, second, centre);
    }
  }
}

}  // namespace

IndexRange index_batch(int level, int batch) {
  const auto cells = static_cast<std::uint32_t>(patch_cells(level));
  const std::uint32_t same = 3 * cells;  // indices of one same-level edge: two triangles a tile
  const std::uint32_t lower = level > 1 ? same / 2 : 0;
  const std::uint32_t interior = 3u * static_cast<std::uint32_t>(patch_triangles(level)) - 4 * same;
  const std::uint32_t start = index_count(level - 1);
  const auto b = static_cast<std::uint32_t>(batch);
  if (batch == 0) return {start, interior};
  if (batch < batch_lower(0)) return {start + interior + (b - 1) * same, same};
  return {start + interior + 4 * same + (b - 5) * lower, lower};
}

Status build_index_tables(int max_level, std::span<std::uint16_t> out) {
  if (max_level < 1 || max_level > kMaxLevel) {
    return {StatusCode::invalid_argument, "not a level of detail", "max_level"};
  }
  const std::uint32_t needed = index_count(max_level);
  if (out.size() < needed) return {StatusCode::invalid_argument, "too small for the levels", "out", needed};
  std::uint16_t* position = out.data();
  for (int level = 1; level <= max_level; ++level) {
    Writer writer(level, position);
    write_interior(level, writer);
    for (int edge = 0; edge < 4; ++edge) write_edge(level, edge, false, writer);
    for (int edge = 0; edge < 4 && level > 1; ++edge) write_edge(level, edge, true, writer);
    position = writer.end();
  }
  return {};
}

int index_ranges(int level, unsigned lower_edges, unsigned skipped_edges,
                 IndexRange (&ranges)[kMaxIndexRanges]) {
  int used = 0;
  const auto append = [&](IndexRange range) {
    if (range.count == 0) return;
    if (used > 0 && ranges[used - 1].first + ranges[used - 1].count == range.first) {
      ranges[used - 1].count += range.count;
    } else {
      ranges[used++] = range;
    }
  };
  if (level == 1) lower_edges = 0;
  append(index_batch(level, 0));
  // Same-level batches first, then lower ones: the order of the table, so that neighbours merge.
  for (int edge = 0; edge < 4; ++edge) {
    if (((lower_edges | skipped_edges) >> edge & 1u) == 0) append(index_batch(level, batch_same(edge)));
  }
  for (int edge = 0; edge < 4; ++edge) {
    if ((lower_edges & ~skipped_edges) >> edge & 1u) append(index_batch(level, batch_lower(edge)));
  }
  return used;
}

}  // namespace karst::core
