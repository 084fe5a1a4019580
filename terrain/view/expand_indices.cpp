// SPDX-License-Identifier: MIT
// The inner loop is a widening addition over contiguous memory, which compilers turn into vector code.
#include "terrain/view/expand_indices.h"

namespace karst {

Status ExpandIndices::validate(int max_level) const {
  if (max_level < 1 || max_level > kMaxLevel) {
    return {StatusCode::invalid_argument, "not a level of detail", "max_level"};
  }
  if (table.size() < index_count(max_level)) {
    return {StatusCode::invalid_argument, "does not hold the levels", "table", index_count(max_level)};
  }
  if (!items.empty() && first_vertex.empty()) {
    return {StatusCode::invalid_argument, "missing", "first_vertex"};
  }
  if (out.size() < least_room(max_level)) {
    return {StatusCode::invalid_argument, "has no room for one patch", "out", least_room(max_level)};
  }
  return {};
}

ExpandIndices::Chunk ExpandIndices::run(std::uint32_t first_item) const {
  Chunk chunk{0, first_item, 0};
  std::uint32_t* to = out.data();
  std::size_t room = out.size();
  for (; chunk.next_item < items.size(); ++chunk.next_item) {
    const DrawItem& item = items[chunk.next_item];
    const std::uint32_t base = first_vertex[item.patch];
    if (base == kNoVertices) {
      ++chunk.left_out;
      continue;
    }
    const std::uint32_t count = patch_index_count(item.level, item.lower_edges, item.skipped_edges);
    if (count > room) break;
    room -= count;
    chunk.indices += count;
    IndexRange ranges[kMaxIndexRanges];
    const int used = index_ranges(item.level, item.lower_edges, item.skipped_edges, ranges);
    for (int r = 0; r < used; ++r) {
      const std::uint16_t* from = table.data() + ranges[r].first;
      for (std::uint32_t n = 0; n < ranges[r].count; ++n) to[n] = base + from[n];
      to += ranges[r].count;
    }
  }
  return chunk;
}

}  // namespace karst
