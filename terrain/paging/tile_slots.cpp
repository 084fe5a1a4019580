// SPDX-License-Identifier: MIT
#include "terrain/paging/tile_slots.h"

#include <algorithm>

#include "terrain/base/check.h"
#include "terrain/ground/key_hash.h"

namespace karst::core {

void TileSlots::reset() {
  KARST_ASSERT(!storage_.slots.empty());
  want_count_ = 0;
  counts_ = {};
  forget();
}

void TileSlots::forget() {
  std::fill(storage_.chains.begin(), storage_.chains.end(), -1);
  std::fill(storage_.slots.begin(), storage_.slots.end(), TileSlot{});
  pinned_ = 0;
}

void TileSlots::pin(NodeKey key) {
  KARST_ASSERT(!storage_.slots[0].used);
  pinned_ = 1;
  put(key, 0);
}

std::int32_t& TileSlots::chain_of(NodeKey key) {
  return storage_.chains[key_hash(key) % storage_.chains.size()];
}

std::int32_t TileSlots::slot_of(NodeKey key) {
  std::int32_t at = chain_of(key);
  while (at >= 0 && !(storage_.slots[static_cast<std::size_t>(at)].key == key)) {
    at = storage_.slots[static_cast<std::size_t>(at)].next;
  }
  return at;
}

void TileSlots::begin_frame() {
  ++frame_;
  want_count_ = 0;
  counts_.wanted = 0;
}

std::int32_t TileSlots::find(NodeKey key) {
  const std::int32_t at = slot_of(key);
  if (at >= 0) storage_.slots[static_cast<std::size_t>(at)].last_used = frame_;
  return at;
}

bool TileSlots::is_under_way(NodeKey key) const {
  const auto end = under_way_.begin() + counts_.under_way;
  return std::find(under_way_.begin(), end, key) != end;
}

void TileSlots::want(NodeKey key, const TilePlace& place, float urgency) {
  if (!place.exists()) return;
  const auto end = wants_.begin() + static_cast<std::ptrdiff_t>(want_count_);
  const auto same = std::find_if(wants_.begin(), end, [&](const Want& w) { return w.key == key; });
  if (same != end) {
    same->urgency = std::max(same->urgency, urgency);
    return;
  }
  ++counts_.wanted;
  if (want_count_ < wants_.size()) {
    wants_[want_count_++] = {key, place, urgency};
    return;
  }
  const auto least = std::min_element(wants_.begin(), wants_.end(),
                                      [](const Want& a, const Want& b) { return a.urgency < b.urgency; });
  if (least->urgency < urgency) *least = {key, place, urgency};
}

void TileSlots::ask(bool (*asks)(void* context, NodeKey key, const TilePlace& place), void* context) {
  const auto end = wants_.begin() + static_cast<std::ptrdiff_t>(want_count_);
  std::sort(wants_.begin(), end, [](const Want& a, const Want& b) { return a.urgency > b.urgency; });
  for (auto want = wants_.begin(); want != end && counts_.under_way < most_under_way_; ++want) {
    if (is_under_way(want->key)) continue;
    if (asks == nullptr || !asks(context, want->key, want->place)) break;
    under_way_[counts_.under_way++] = want->key;
  }
  // Whoever still lacks them wants them again.
  want_count_ = 0;
}

void TileSlots::put(NodeKey key, std::int32_t slot) {
  TileSlot& own = storage_.slots[static_cast<std::size_t>(slot)];
  own = {key, frame_, chain_of(key), true};
  chain_of(key) = slot;
}

void TileSlots::unlink(std::int32_t slot) {
  TileSlot& gone = storage_.slots[static_cast<std::size_t>(slot)];
  std::int32_t* at = &chain_of(gone.key);
  while (*at != slot) at = &storage_.slots[static_cast<std::size_t>(*at)].next;
  *at = gone.next;
  gone = {};
}

// A slot that nothing is in, or what was not looked at in this frame or the last one for longest; -1: none.
std::int32_t TileSlots::make_room() {
  std::int32_t best = -1;
  std::uint32_t most = 1;  // frames unused, more than
  for (std::size_t n = pinned_; n < storage_.slots.size(); ++n) {
    const TileSlot& slot = storage_.slots[n];
    if (!slot.used) return static_cast<std::int32_t>(n);
    const std::uint32_t unused = frame_ - slot.last_used;
    if (unused > most) {
      most = unused;
      best = static_cast<std::int32_t>(n);
    }
  }
  if (best >= 0) unlink(best);
  return best;
}

std::int32_t TileSlots::take(NodeKey key, TileSource::Answer answer) {
  const auto end = under_way_.begin() + counts_.under_way;
  const auto at = std::find(under_way_.begin(), end, key);
  if (at == end) return -1;
  *at = under_way_[--counts_.under_way];
  counts_.failing = answer == TileSource::Answer::failed;
  if (counts_.failing) {
    ++counts_.failed;
    return -1;
  }
  if (slot_of(key) >= 0) return -1;
  const std::int32_t room = make_room();
  counts_.full = room < 0;
  if (room < 0) {
    ++counts_.dropped;
    return -1;
  }
  put(key, room);
  ++counts_.came;
  return room;
}

}  // namespace karst::core
