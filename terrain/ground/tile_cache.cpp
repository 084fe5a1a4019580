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
  want_count_ = 0;
  counts_.wanted = 0;
}

const Tile* TileCache::find(NodeKey tile) {
  const std::int32_t at = find_entry(tile);
  if (at < 0) return nullptr;
  storage_.entries[static_cast<std::size_t>(at)].last_used = frame_;
  return &storage_.tiles[static_cast<std::size_t>(at)];
}

bool TileCache::is_under_way(NodeKey key) const {
  const auto end = under_way_.begin() + counts_.under_way;
  return std::find(under_way_.begin(), end, key) != end;
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

void TileCache::ask() {
  const auto end = wants_.begin() + static_cast<std::ptrdiff_t>(want_count_);
  std::sort(wants_.begin(), end, [](const Want& a, const Want& b) { return a.urgency > b.urgency; });
  for (auto want = wants_.begin(); want != end && counts_.under_way < kMostUnderWay; ++want) {
    if (is_under_way(want->key)) continue;
    if (source_.ask == nullptr || !source_.ask(source_.context, want->key, want->place)) break;
    under_way_[counts_.under_way++] = want->key;
  }
  // Whoever still lacks them wants them again.
  want_count_ = 0;
}

void TileCache::unlink(std::int32_t entry) {
  Entry& gone = storage_.entries[static_cast<std::size_t>(entry)];
  std::int32_t* at = &chain_of(gone.key);
  while (*at != entry) at = &storage_.entries[static_cast<std::size_t>(*at)].next;
  *at = gone.next;
  gone = {};
}

// A place that nothing is in, or what was not looked at in this frame or the last one for longest; -1: none.
// The root's stays.
std::int32_t TileCache::make_room() {
  std::int32_t best = -1;
  std::uint32_t most = 1;  // frames unused, more than
  for (std::size_t n = 1; n < storage_.entries.size(); ++n) {
    const Entry& entry = storage_.entries[n];
    if (!entry.used) return static_cast<std::int32_t>(n);
    const std::uint32_t unused = frame_ - entry.last_used;
    if (unused > most) {
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
    const auto end = under_way_.begin() + counts_.under_way;
    const auto at = std::find(under_way_.begin(), end, key);
    if (at == end) continue;  // nobody asked
    *at = under_way_[--counts_.under_way];
    counts_.failing = answer == TileSource::Answer::failed;
    if (answer == TileSource::Answer::failed) {
      ++counts_.failed;
      continue;
    }
    if (find_entry(key) >= 0) continue;
    const std::int32_t room = make_room();
    if (room < 0) {
      ++counts_.dropped;
      counts_.full = true;
      continue;
    }
    Entry& entry = storage_.entries[static_cast<std::size_t>(room)];
    storage_.tiles[static_cast<std::size_t>(room)] = came_;
    entry.key = key;
    entry.used = true;
    entry.last_used = frame_;
    entry.next = chain_of(key);
    chain_of(key) = room;
    counts_.full = false;
    ++counts_.came;
    ++came;
  }
  return came;
}

}  // namespace karst::core
