// SPDX-License-Identifier: MIT
#include "terrain/ground/tile_cache.h"

#include <algorithm>

#include "terrain/base/check.h"
#include "terrain/ground/key_hash.h"

namespace karst::core {
void TileCache::reset(const TileSource& source, NodeKey root, const Tile& root_tile) {
  KARST_ASSERT(!storage_.tiles.empty());
  source_ = source;
  std::fill(storage_.chains.begin(), storage_.chains.end(), -1);
  std::fill(storage_.entries.begin(), storage_.entries.end(), Entry{});
  want_count_ = 0;
  counts_ = {};
  pace_.reset();
  storage_.tiles[0] = root_tile;
  storage_.entries[0].key = root;
  storage_.entries[0].used = true;
  chain_of(root) = 0;
}

std::int32_t& TileCache::chain_of(NodeKey key) {
  return storage_.chains[key_hash(key) % storage_.chains.size()];
}

std::int32_t TileCache::find_entry(NodeKey key) {
  std::int32_t at = chain_of(key);
  while (at >= 0 && !(storage_.entries[static_cast<std::size_t>(at)].key == key)) {
    at = storage_.entries[static_cast<std::size_t>(at)].next;
  }
  return at;
}

void TileCache::begin_frame() {
  ++frame_;
  pace_.begin_frame();
  want_count_ = 0;
  counts_.wanted = 0;
}

const Tile* TileCache::find(NodeKey tile) {
  const std::int32_t at = find_entry(tile);
  if (at < 0) return nullptr;
  Entry& entry = storage_.entries[static_cast<std::size_t>(at)];
  entry.last_used = frame_;
  if (entry.ahead) ++counts_.ahead.used;
  entry.ahead = false;
  return &storage_.tiles[static_cast<std::size_t>(at)];
}

const Tile* TileCache::find_ahead(NodeKey tile) {
  const std::int32_t at = find_entry(tile);
  if (at < 0) return nullptr;
  storage_.entries[static_cast<std::size_t>(at)].last_ahead = frame_;
  return &storage_.tiles[static_cast<std::size_t>(at)];
}

TileCache::UnderWay* TileCache::find_under_way(NodeKey key) {
  const auto end = under_way_.begin() + counts_.under_way;
  const auto at = std::find_if(under_way_.begin(), end, [&](const UnderWay& u) { return u.key == key; });
  return at == end ? nullptr : &*at;
}

void TileCache::want(NodeKey tile, const TilePlace& place, float urgency) {
  if (!place.exists()) return;
  const auto end = wants_.begin() + static_cast<std::ptrdiff_t>(want_count_);
  const auto same = std::find_if(wants_.begin(), end, [&](const Want& w) { return w.key == tile; });
  if (same != end) {
    same->urgency = std::max(same->urgency, urgency);
    return;
  }
  ++counts_.wanted;
  if (want_count_ < wants_.size()) {
    wants_[want_count_++] = {tile, place, urgency};
    return;
  }
  const auto least = std::min_element(wants_.begin(), wants_.end(),
                                      [](const Want& a, const Want& b) { return a.urgency < b.urgency; });
  if (least->urgency < urgency) *least = {tile, place, urgency};
}

std::uint32_t TileCache::ask_for_wants(std::uint32_t most, bool ahead) {
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
    if (source_.ask == nullptr || !source_.ask(source_.context, want->key, want->place)) break;
    pace_.ask(counts_.under_way);
    under_way_[counts_.under_way++] = {want->key, ahead};
    ++asked;
  }
  // Whoever still lacks them wants them again.
  want_count_ = 0;
  return asked;
}

void TileCache::ask(bool all) {
  ask_for_wants(all ? std::uint32_t{kMostUnderWay} : pace_.depth(kMostUnderWay), false);
}

std::uint32_t TileCache::ask_ahead(std::uint32_t most) {
  const std::uint32_t asked =
      ask_for_wants(std::min(counts_.under_way + most, std::uint32_t{kMostUnderWay}), true);
  counts_.ahead.asked += asked;
  return asked;
}

void TileCache::unlink(std::int32_t entry) {
  Entry& gone = storage_.entries[static_cast<std::size_t>(entry)];
  std::int32_t* at = &chain_of(gone.key);
  while (*at != entry) at = &storage_.entries[static_cast<std::size_t>(*at)].next;
  *at = gone.next;
  if (gone.ahead) ++counts_.ahead.wasted;
  gone = {};
}

// A place that nothing is in, or what was not looked at in this frame or the last one for longest; -1: none.
// The root's stays. ahead: for what is not lacking yet, nothing gives way that will be looked at soon.
std::int32_t TileCache::make_room(bool ahead) {
  constexpr std::uint32_t kSoon = 64;  // frames in which find_ahead() looks at everything
  std::int32_t best = -1;
  std::uint32_t most = 0;  // frames unused
  for (std::size_t n = 1; n < storage_.entries.size(); ++n) {
    const Entry& entry = storage_.entries[n];
    if (!entry.used) return static_cast<std::int32_t>(n);
    if (frame_ - entry.last_used <= 1) continue;
    const std::uint32_t unused = frame_ - std::max(entry.last_used, entry.last_ahead);
    if (ahead && unused < kSoon) continue;
    if (best < 0 || unused > most) {
      most = unused;
      best = static_cast<std::int32_t>(n);
    }
  }
  if (best >= 0) unlink(best);
  return best;
}

bool TileCache::wait() {
  if (counts_.under_way == 0) return false;
  if (source_.wait != nullptr) source_.wait(source_.context);
  return true;
}

std::uint32_t TileCache::poll(bool one) {
  std::uint32_t came = 0;
  NodeKey key;
  while (counts_.under_way > 0 && !(one && came > 0)) {
    const TileSource::Answer answer = source_.poll(source_.context, key, came_);
    if (answer == TileSource::Answer::none) break;
    UnderWay* const at = find_under_way(key);
    if (at == nullptr) continue;  // nobody asked
    const bool ahead = at->ahead;
    *at = under_way_[--counts_.under_way];
    pace_.answer();
    counts_.failing = answer == TileSource::Answer::failed;
    if (answer == TileSource::Answer::failed) {
      ++counts_.failed;
      continue;
    }
    if (find_entry(key) >= 0) continue;
    const std::int32_t room = make_room(ahead);
    if (room < 0 && ahead) {
      ++counts_.ahead.wasted;
      continue;
    }
    if (room < 0) {
      ++counts_.dropped;
      counts_.full = true;
      continue;
    }
    Entry& entry = storage_.entries[static_cast<std::size_t>(room)];
    storage_.tiles[static_cast<std::size_t>(room)] = came_;
    entry.key = key;
    entry.used = true;
    entry.last_used = entry.last_ahead = frame_;
    entry.ahead = ahead;
    entry.next = chain_of(key);
    chain_of(key) = room;
    counts_.full = false;
    ++counts_.came;
    ++came;
  }
  return came;
}

}  // namespace karst::core
