// SPDX-License-Identifier: MIT
// The nine index batches a level (K 4.4.3), shared by all patches: the interior, and for each edge "neighbour at
// the same level" and "neighbour one lower". 16-bit, counter-clockwise, K's pattern of figure 3.27, in the vertex
// order of gpu_vertex.h. In each level the order is: interior, same 0..3, lower 0..3; so a patch with all
// edges "same" is one contiguous range.
#pragma once

#include <cstdint>
#include <span>

#include "terrain/base/lattice.h"
#include "terrain/base/status.h"

namespace karst {

struct IndexRange {
  std::uint32_t first = 0;  // in indices, from the start of the table of all levels
  std::uint32_t count = 0;  // in indices; three a triangle
};

inline constexpr int kBatches = 9;
constexpr int batch_same(int edge) { return 1 + edge; }
constexpr int batch_lower(int edge) { return 5 + edge; }

// Where a batch of a level (1..kMaxLevel) lies. batch 0 is the interior. At level 1 no neighbour can be lower: the
// lower batches of level 1 are empty.
IndexRange index_batch(int level, int batch);

// Indices of all levels 1..max_level together.
std::uint32_t index_count(int max_level);

// Fills out, which must hold index_count(max_level) values.
Status build_index_tables(int max_level, std::span<std::uint16_t> out);

// The ranges to draw for a patch at level with the given lower_edges bits (DrawItem), merged where contiguous.
// Returns how many of ranges are used (1..5).
int index_ranges(int level, unsigned lower_edges, IndexRange (&ranges)[5]);

}  // namespace karst
