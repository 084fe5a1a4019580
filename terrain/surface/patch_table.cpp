// SPDX-License-Identifier: MIT
// Open addressing with linear probing; a removed entry is filled by those behind it (Knuth, "The Art of
// Computer Programming", volume 3, 6.4, algorithm R), so that searches never slow down.
#include "terrain/surface/patch_table.h"

#include <algorithm>
#include <bit>

#include "terrain/base/check.h"

namespace karst::core {

void PatchTable::create(const Blocks& blocks) {
  KARST_ASSERT(blocks.entries.size() == entry_count(blocks.keys.size()));
  blocks_ = blocks;
  clear();
}

void PatchTable::clear() {
  std::fill(blocks_.entries.begin(), blocks_.entries.end(), 0u);
  size_ = 0;
  end_ = 0;
  free_head_ = kNone;
}

// The highest bits of the product (Fibonacci hashing: 2^64 / golden ratio).
std::size_t PatchTable::home_of(std::uint64_t key) const {
  const int bits = std::countr_zero(blocks_.entries.size());
  return static_cast<std::size_t>((key * 0x9e3779b97f4a7c15u) >> (64 - bits));
}

std::size_t PatchTable::entry_of(std::uint64_t key) const {
  std::size_t at = home_of(key);
  while (blocks_.entries[at] != 0 && blocks_.keys[blocks_.entries[at] - 1] != key) at = next(at);
  return at;
}

PatchId PatchTable::find(PatchKey key) const {
  if (blocks_.entries.empty()) return kNone;
  return blocks_.entries[entry_of(key.bits())] - 1;  // 0 - 1 is kNone
}

Status PatchTable::take(PatchKey key, PatchId& slot) {
  if (size_ == capacity())
    return {StatusCode::limit_reached, "slots of patches are used up", "max_patches",
            std::uint64_t{size_} + 1};
  const std::size_t entry = entry_of(key.bits());
  KARST_ASSERT(blocks_.entries[entry] == 0);
  if (free_head_ != kNone) {
    slot = free_head_;
    free_head_ = static_cast<PatchId>(blocks_.keys[slot] & ~kFree);
  } else {
    slot = end_++;
  }
  blocks_.keys[slot] = key.bits();
  blocks_.entries[entry] = slot + 1;
  ++size_;
  return {};
}

void PatchTable::release(PatchId slot) {
  KARST_ASSERT(slot < end_ && is_used(slot));
  std::size_t hole = entry_of(blocks_.keys[slot]);
  for (std::size_t at = next(hole); blocks_.entries[at] != 0; at = next(at)) {
    // What lies behind the hole moves into it unless its own search begins behind the hole, too.
    const std::size_t home = home_of(blocks_.keys[blocks_.entries[at] - 1]);
    const std::size_t mask = blocks_.entries.size() - 1;
    if (((at - home) & mask) < ((at - hole) & mask)) continue;
    blocks_.entries[hole] = blocks_.entries[at];
    hole = at;
  }
  blocks_.entries[hole] = 0;
  blocks_.keys[slot] = kFree | free_head_;
  free_head_ = slot;
  --size_;
}

}  // namespace karst::core
