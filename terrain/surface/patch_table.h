// SPDX-License-Identifier: MIT
// Which slot a patch has. A PatchId is a slot: what belongs to a patch lies at its slot in arrays of
// Config::max_patches entries, and stays there as long as the patch does, whatever is dug elsewhere.
//
// Slots that are handed out to an empty table are 0, 1, 2 ...: taken in the order of their keys they are the
// patches' numbers in an extraction of everything. Slots given back are handed out again, the last one first.
//
// No heap: two blocks of fixed length, 8 bytes a slot for its key, or for the next free slot, and 6 to 12 for
// an open-addressing table, at most 2/3 full.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/arena.h"
#include "terrain/base/config.h"
#include "terrain/surface/patch.h"
#include "terrain/surface/patch_key.h"

namespace karst::core {

class PatchTable {
 public:
  static constexpr PatchId kNone = 0xffffffffu;

  struct Blocks {
    std::span<std::uint64_t> keys;
    std::span<std::uint32_t> entries;

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      visit(Consumer::patches, config.max_patches, keys);
      // Tables of several regions are powers of two each.
      const std::size_t more = config.edit_patches > 0 && config.max_regions > 1 ? 2 : 1;
      visit(Consumer::patches, more * entry_count(config.max_patches) + 4 * (config.max_regions - 1),
            entries);
    }
  };
  static constexpr std::size_t entry_count(std::size_t max_patches) {
    std::size_t count = 4;
    while (count * 2 < max_patches * 3) count *= 2;
    return count;
  }

  // An empty table of as many slots as there are keys. blocks: borrowed; entries are
  // entry_count(keys.size()).
  void create(const Blocks& blocks);
  // Gives back all slots.
  void clear();

  std::uint32_t capacity() const { return static_cast<std::uint32_t>(blocks_.keys.size()); }
  std::uint32_t size() const { return size_; }  // slots in use
  std::uint32_t end() const { return end_; }    // every slot in use is below it

  // The patch's slot, or kNone where it has none.
  PatchId find(PatchKey key) const;
  // Precondition: slot < end().
  bool is_used(PatchId slot) const { return (blocks_.keys[slot] & kFree) == 0; }
  // Precondition: the slot is in use.
  PatchKey key(PatchId slot) const { return PatchKey::from_bits(blocks_.keys[slot]); }
  // Calls visit(slot, key) for the slots in use, ascending.
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (PatchId slot = 0; slot < end_; ++slot) {
      if (is_used(slot)) visit(slot, key(slot));
    }
  }

  // Hands out a slot for a patch that has none (precondition). limit_reached ("max_patches", value: slots
  // that it would take) where all are in use; nothing changes then.
  Status take(PatchKey key, PatchId& slot);
  // Precondition: the slot is in use.
  void release(PatchId slot);

 private:
  static constexpr std::uint64_t kFree = std::uint64_t{1} << 63;  // no key has it

  std::size_t home_of(std::uint64_t key) const;
  std::size_t next(std::size_t entry) const { return (entry + 1) & (blocks_.entries.size() - 1); }
  // The entry that holds the key, or the empty one where the search for it ends.
  std::size_t entry_of(std::uint64_t key) const;

  Blocks blocks_;  // keys: by slot; kFree | the next free slot where it is free. entries: slot + 1, or 0
  std::uint32_t size_ = 0;
  std::uint32_t end_ = 0;  // slots from here on were never taken
  PatchId free_head_ = kNone;
};

}  // namespace karst::core
