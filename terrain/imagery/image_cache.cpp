// SPDX-License-Identifier: MIT
#include "terrain/imagery/image_cache.h"

#include <algorithm>

#include "terrain/base/check.h"
#include "terrain/ground/key_hash.h"

namespace karst::core {

void ImageCache::reset(const ImageSource& source, NodeKey root, const TilePlace& root_place) {
  KARST_ASSERT(!storage_.entries.empty());
  source_ = source;
  root_ = root;
  root_place_ = root_place;
  want_count_ = 0;
  counts_ = {};
  pace_.reset();
  forget();
}

void ImageCache::forget() {
  std::fill(storage_.chains.begin(), storage_.chains.end(), -1);
  std::fill(storage_.entries.begin(), storage_.entries.end(), Entry{});
  ++version_;
}

std::int32_t& ImageCache::chain_of(NodeKey key) {
  return storage_.chains[key_hash(key) % storage_.chains.size()];
}

std::int32_t ImageCache::find_entry(NodeKey key) {
  std::int32_t at = chain_of(key);
  while (at >= 0 && !(storage_.entries[static_cast<std::size_t>(at)].key == key)) {
    at = storage_.entries[static_cast<std::size_t>(at)].next;
  }
  return at;
}

void ImageCache::begin_frame() {
  ++frame_;
  pace_.begin_frame();
  want_count_ = 0;
}

std::int32_t ImageCache::find(NodeKey key) {
  const std::int32_t at = find_entry(key);
  if (at < 0) return at;
  Entry& entry = storage_.entries[static_cast<std::size_t>(at)];
  entry.last_used = frame_;
  if (entry.ahead) ++counts_.ahead.used;
  entry.ahead = false;
  return at;
}

std::int32_t ImageCache::find_ahead(NodeKey key) {
  const std::int32_t at = find_entry(key);
  if (at >= 0) storage_.entries[static_cast<std::size_t>(at)].last_ahead = frame_;
  return at;
}

ImageCache::UnderWay* ImageCache::find_under_way(NodeKey key) {
  const auto end = under_way_.begin() + counts_.under_way;
  const auto at = std::find_if(under_way_.begin(), end, [&](const UnderWay& u) { return u.key == key; });
  return at == end ? nullptr : &*at;
}

void ImageCache::want(NodeKey key, const TilePlace& place, float urgency) {
  if (!place.exists()) return;
  const auto end = wants_.begin() + static_cast<std::ptrdiff_t>(want_count_);
  const auto same = std::find_if(wants_.begin(), end, [&](const Want& w) { return w.key == key; });
  if (same != end) {
    same->urgency = std::max(same->urgency, urgency);
    return;
  }
  if (want_count_ < wants_.size()) {
    wants_[want_count_++] = {key, place, urgency};
    return;
  }
  const auto least = std::min_element(wants_.begin(), wants_.end(),
                                      [](const Want& a, const Want& b) { return a.urgency < b.urgency; });
  if (least->urgency < urgency) *least = {key, place, urgency};
}

std::uint32_t ImageCache::ask_for_wants(std::uint32_t most, bool ahead) {
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
  want_count_ = 0;
  return asked;
}

void ImageCache::ask(bool all) {
  ask_for_wants(all ? std::uint32_t{kMostUnderWay} : pace_.depth(kMostUnderWay), false);
}

std::uint32_t ImageCache::ask_ahead(std::uint32_t most) {
  const std::uint32_t asked =
      ask_for_wants(std::min(counts_.under_way + most, std::uint32_t{kMostUnderWay}), true);
  counts_.ahead.asked += asked;
  return asked;
}

void ImageCache::unlink(std::int32_t entry) {
  Entry& gone = storage_.entries[static_cast<std::size_t>(entry)];
  std::int32_t* at = &chain_of(gone.key);
  while (*at != entry) at = &storage_.entries[static_cast<std::size_t>(*at)].next;
  *at = gone.next;
  if (gone.ahead) ++counts_.ahead.wasted;
  gone = {};
}

// A layer that nothing is in, or what was not looked at in this frame or the last one for longest; -1: none.
// ahead: as TileCache's.
std::int32_t ImageCache::make_room(bool ahead) {
  constexpr std::uint32_t kSoon = 64;
  std::int32_t best = -1;
  std::uint32_t most = 0;  // frames unused
  for (std::size_t n = 0; n < storage_.entries.size(); ++n) {
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

bool ImageCache::wait() {
  if (counts_.under_way == 0) return false;
  if (source_.wait != nullptr) source_.wait(source_.context);
  return true;
}

bool ImageCache::poll(std::int32_t& layer, ImageArrival& out) {
  while (counts_.under_way > 0) {
    const TileSource::Answer answer = source_.poll(source_.context, out);
    if (answer == TileSource::Answer::none) return false;
    UnderWay* const at = find_under_way(out.key);
    if (at == nullptr) continue;  // nobody asked
    const bool ahead = at->ahead;
    *at = under_way_[--counts_.under_way];
    pace_.answer();
    counts_.failing = answer == TileSource::Answer::failed;
    if (counts_.failing) {
      ++counts_.failed;
      continue;
    }
    if (find_entry(out.key) >= 0) continue;
    layer = make_room(ahead);
    if (layer < 0 && ahead) {
      ++counts_.ahead.wasted;
      continue;
    }
    if (layer < 0) {
      ++counts_.dropped;
      counts_.full = true;
      continue;
    }
    Entry& entry = storage_.entries[static_cast<std::size_t>(layer)];
    entry.key = out.key;
    entry.children = out.children;
    entry.used = true;
    entry.last_used = entry.last_ahead = frame_;
    entry.ahead = ahead;
    entry.next = chain_of(out.key);
    chain_of(out.key) = layer;
    counts_.full = false;
    ++counts_.came;
    ++version_;
    return true;
  }
  return false;
}

}  // namespace karst::core
