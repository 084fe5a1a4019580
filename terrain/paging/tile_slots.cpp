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
  pace_.reset();
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
  pace_.begin_frame();
  want_count_ = 0;
  counts_.wanted = 0;
}

std::int32_t TileSlots::find(NodeKey key) {
  const std::int32_t at = slot_of(key);
  if (at < 0) return at;
  TileSlot& slot = storage_.slots[static_cast<std::size_t>(at)];
  slot.last_used = frame_;
  if (slot.ahead) ++counts_.ahead.used;
  slot.ahead = false;
  return at;
}

std::int32_t TileSlots::find_ahead(NodeKey key) {
  const std::int32_t at = slot_of(key);
  if (at >= 0) storage_.slots[static_cast<std::size_t>(at)].last_ahead = frame_;
  return at;
}

TileSlots::UnderWay* TileSlots::find_under_way(NodeKey key) {
  const auto end = under_way_.begin() + counts_.under_way;
  const auto at = std::find_if(under_way_.begin(), end, [&](const UnderWay& u) { return u.key == key; });
  return at == end ? nullptr : &*at;
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

std::uint32_t TileSlots::ask_for_wants(Asks asks, void* context, std::size_t most, bool ahead) {
  const auto end = wants_.begin() + static_cast<std::ptrdiff_t>(want_count_);
  std::sort(wants_.begin(), end, [](const Want& a, const Want& b) { return a.urgency > b.urgency; });
  std::uint32_t asked = 0;
  for (auto want = wants_.begin(); want != end; ++want) {
    if (UnderWay* const there = find_under_way(want->key); there != nullptr) {
      if (there->ahead && !ahead) {
        ++counts_.ahead.used;
        there->ahead = false;
      }
      continue;
    }
    if (counts_.under_way >= most) continue;
    if (asks == nullptr || !asks(context, want->key, want->place)) break;
    pace_.ask(counts_.under_way);
    under_way_[counts_.under_way++] = {want->key, ahead};
    ++asked;
  }
  // Whoever still lacks them wants them again.
  want_count_ = 0;
  return asked;
}

void TileSlots::ask(Asks asks, void* context, bool all) {
  const auto most = static_cast<std::uint32_t>(most_under_way_);
  ask_for_wants(asks, context, all ? most : pace_.depth(most), false);
}

std::uint32_t TileSlots::ask_ahead(Asks asks, void* context, std::uint32_t most) {
  const std::uint32_t asked =
      ask_for_wants(asks, context, std::min<std::size_t>(counts_.under_way + most, most_under_way_), true);
  counts_.ahead.asked += asked;
  return asked;
}

std::uint32_t TileSlots::room_ahead() const {
  const std::uint32_t depth = pace_.depth(static_cast<std::uint32_t>(most_under_way_));
  return counts_.under_way < depth ? depth - counts_.under_way : 0;
}

void TileSlots::put(NodeKey key, std::int32_t slot) {
  TileSlot& own = storage_.slots[static_cast<std::size_t>(slot)];
  own = {key, frame_, frame_, chain_of(key), true, false};
  chain_of(key) = slot;
}

void TileSlots::unlink(std::int32_t slot) {
  TileSlot& gone = storage_.slots[static_cast<std::size_t>(slot)];
  std::int32_t* at = &chain_of(gone.key);
  while (*at != slot) at = &storage_.slots[static_cast<std::size_t>(*at)].next;
  *at = gone.next;
  if (gone.ahead) ++counts_.ahead.wasted;
  gone = {};
}

// A slot that nothing is in, or what was not looked at in this frame or the last one for longest; -1: none.
// ahead: for what is not lacking yet, nothing gives way that will be looked at soon.
std::int32_t TileSlots::make_room(bool ahead) {
  constexpr std::uint32_t kSoon = 64;  // frames in which find_ahead() looks at everything
  std::int32_t best = -1;
  std::uint32_t most = 0;  // frames unused
  for (std::size_t n = pinned_; n < storage_.slots.size(); ++n) {
    const TileSlot& slot = storage_.slots[n];
    if (!slot.used) return static_cast<std::int32_t>(n);
    if (frame_ - slot.last_used <= 1) continue;
    const std::uint32_t unused = frame_ - std::max(slot.last_used, slot.last_ahead);
    if (ahead && unused < kSoon) continue;
    if (best < 0 || unused > most) {
      most = unused;
      best = static_cast<std::int32_t>(n);
    }
  }
  if (best >= 0) unlink(best);
  return best;
}

std::int32_t TileSlots::take(NodeKey key, TileSource::Answer answer) {
  UnderWay* const at = find_under_way(key);
  if (at == nullptr) return -1;
  const bool ahead = at->ahead;
  *at = under_way_[--counts_.under_way];
  pace_.answer();
  counts_.failing = answer == TileSource::Answer::failed;
  if (counts_.failing) {
    ++counts_.failed;
    return -1;
  }
  if (slot_of(key) >= 0) return -1;
  const std::int32_t room = make_room(ahead);
  if (room < 0 && ahead) {
    ++counts_.ahead.wasted;
    return -1;
  }
  counts_.full = room < 0;
  if (room < 0) {
    ++counts_.dropped;
    return -1;
  }
  put(key, room);
  storage_.slots[static_cast<std::size_t>(room)].ahead = ahead;
  ++counts_.came;
  return room;
}

}  // namespace karst::core
