// SPDX-License-Identifier: MIT
// Two inner loops. Where a slot's pages follow each other in the buffer, which fresh buffers and level 1 and
// 2 always have, an index is moved by one number: a widening addition over contiguous memory, which compilers
// turn into vector code. Elsewhere each index looks its page up in a table of at most 133 numbers, which the
// first-level cache holds.
#include "terrain/draw/expand_indices.h"

#include <bit>

namespace karst::core {
namespace {

constexpr int kPageBits = std::countr_zero(kPageVertices);

// Where a slot's vertices lie in the buffer: vertex v at moved[v >> kPageBits] + v, modulo 2^32.
struct SlotPages {
  std::uint32_t moved[kMostSlotPages];
  bool contiguous = true;  // all of them the same

  // False where the patch has fewer pages than the level needs.
  bool find(const PageTable& pages, PatchId patch, int level) {
    std::uint32_t page = patch < pages.first_page.size() ? pages.first_page[patch] : kNoPage;
    const std::uint32_t needed = slot_pages(level);
    for (std::uint32_t place = 0; place < needed; ++place) {
      if (page >= pages.next_page.size()) return false;
      moved[place] = (page - place) * kPageVertices;
      contiguous = contiguous && moved[place] == moved[0];
      page = pages.next_page[page];
    }
    return true;
  }
};

std::uint32_t* write_range(const std::uint16_t* from, std::uint32_t count, const SlotPages& slot,
                           std::uint32_t* to) {
  if (slot.contiguous) {
    const std::uint32_t moved = slot.moved[0];
    for (std::uint32_t n = 0; n < count; ++n) to[n] = moved + from[n];
  } else {
    for (std::uint32_t n = 0; n < count; ++n) to[n] = slot.moved[from[n] >> kPageBits] + from[n];
  }
  return to + count;
}

}  // namespace

Status ExpandIndices::validate(int max_level) const {
  if (max_level < 1 || max_level > kMaxLevel) {
    return {StatusCode::invalid_argument, "not a level of detail", "max_level"};
  }
  if (table.size() < index_count(max_level)) {
    return {StatusCode::invalid_argument, "does not hold the levels", "table", index_count(max_level)};
  }
  if (!items.empty() && pages.first_page.empty()) {
    return {StatusCode::invalid_argument, "missing", "first_page"};
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
    const std::uint32_t count = patch_index_count(item.level, item.lower_edges, item.skipped_edges);
    SlotPages slot;
    if (!slot.find(pages, item.patch, item.level)) {
      ++chunk.left_out;
      continue;
    }
    if (count > room) break;
    room -= count;
    chunk.indices += count;
    IndexRange ranges[kMaxIndexRanges];
    const int used = index_ranges(item.level, item.lower_edges, item.skipped_edges, ranges);
    for (int r = 0; r < used; ++r)
      to = write_range(table.data() + ranges[r].first, ranges[r].count, slot, to);
  }
  return chunk;
}

}  // namespace karst::core
