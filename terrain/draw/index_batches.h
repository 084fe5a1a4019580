// SPDX-License-Identifier: MIT
// The nine index batches a level (K 4.4.3), shared by all patches: the interior, and for each edge "neighbour
// at the same level" and "neighbour one lower". 16-bit, counter-clockwise, K's pattern of figure 3.27, in the
// vertex order of gpu_vertex.h. In each level the order is: interior, same 0..3, lower 0..3; so a patch with
// all edges "same" is one contiguous range. Edges are numbered as in Patch (surface.h).
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/lattice.h"

namespace karst::core {

struct IndexRange {
  std::uint32_t first = 0;  // in indices, from the start of the table of all levels
  std::uint32_t count = 0;  // in indices; three a triangle

  friend constexpr bool operator==(const IndexRange&, const IndexRange&) = default;
};

inline constexpr int kBatches = 9;
constexpr int batch_same(int edge) {
  return 1 + edge;
}
constexpr int batch_lower(int edge) {
  return 5 + edge;
}

// Where a batch of a level (1..kMaxLevel) lies. Batch 0 is the interior. At level 1 no neighbour can be
// lower: its lower batches are empty, and so is its interior.
IndexRange index_batch(int level, int batch);

// Indices of the levels 1..max_level together. A level has 3 * 2 * 4^k of interior and same-level edges, and,
// above level 1, 4 * 3 * 2^(k-1) of lower edges.
constexpr std::uint32_t index_count(int max_level) {
  std::uint32_t count = 0;
  for (int level = 1; level <= max_level; ++level) {
    count += 3u * static_cast<std::uint32_t>(patch_triangles(level));
    if (level > 1) count += 12u << (level - 1);
  }
  return count;
}
static_assert(index_count(kMaxLevel) * sizeof(std::uint16_t) <= 128 * 1024,
              "the stated limit of the index tables");

// Most indices that one patch at a level takes.
constexpr std::uint32_t max_patch_indices(int level) {
  return 3u * static_cast<std::uint32_t>(patch_triangles(level));
}

// Fills the first index_count(max_level) values of out; the rest stays as it is.
Status build_index_tables(int max_level, std::span<std::uint16_t> out);

// Indices that a patch takes in a given state of its edges; see index_ranges.
constexpr std::uint32_t patch_index_count(int level, unsigned lower_edges, unsigned skipped_edges) {
  const auto cells = static_cast<std::uint32_t>(patch_cells(level));
  const unsigned lower = level > 1 ? lower_edges & ~skipped_edges & 15u : 0u;
  // A table: without special flags compilers call a library function for std::popcount.
  constexpr std::uint8_t kBits[16] = {0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};
  const std::uint32_t lower_count = kBits[lower];
  const std::uint32_t skipped_count = kBits[skipped_edges & 15u];
  return 3 * (2 * cells * cells - lower_count * (cells / 2) - skipped_count * cells);
}

inline constexpr int kMaxIndexRanges = 4;

// The ranges to draw for a patch at level (1..kMaxLevel), merged where contiguous; returns how many are used.
// Bit e of lower_edges: the neighbour across edge e is drawn one level lower (no effect at level 1). Bit e of
// skipped_edges: the edge is a point, and the triangles that stand on it are left out (DrawItem).
int index_ranges(int level, unsigned lower_edges, unsigned skipped_edges,
                 IndexRange (&ranges)[kMaxIndexRanges]);

}  // namespace karst::core
