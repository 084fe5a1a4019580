// SPDX-License-Identifier: MIT
#include "terrain/nodes/family_pool.h"

#include <algorithm>
#include <bit>

#include "terrain/ground/key_hash.h"

namespace karst::core {

void FamilyPool::reset() {
  std::fill(storage_.families.begin(), storage_.families.end(), Family{});
  std::fill(storage_.chains.begin(), storage_.chains.end(), kNone);
  hand_ = 0;
  has_room_ = true;
  seen_ = 0;
  most_ = count();
}

std::uint32_t& FamilyPool::chain_of(NodeKey key) {
  return storage_.chains[key_hash(key) % storage_.chains.size()];
}

std::uint32_t FamilyPool::see(NodeKey parent) {
  std::uint32_t at = chain_of(parent);
  while (at != kNone && !(storage_.families[at].key == parent)) at = storage_.families[at].next;
  const bool is_seen = at != kNone && storage_.families[at].used && storage_.families[at].last_seen == frame_;
  if (!is_seen && seen_ >= most_) return kNone;
  if (at == kNone) {
    at = make_room();
    if (at == kNone) return kNone;
    Family& made = storage_.families[at];
    made.key = parent;
    made.used = true;
    made.filled = 0;
    made.tries = tries_;
    std::uint32_t& chain = chain_of(parent);
    made.next = chain;
    chain = at;
  }
  if (!is_seen) ++seen_;
  storage_.families[at].last_seen = frame_;
  return at;
}

void FamilyPool::undo_tries() {
  for (std::uint32_t at = 0; at < count(); ++at) {
    Family& family = storage_.families[at];
    if (!family.used || family.tries != tries_ || family.last_seen != frame_ || family.filled != 0) continue;
    unlink(at);
    family = {};
    --seen_;
    has_room_ = true;
  }
}

void FamilyPool::unlink(std::uint32_t family) {
  if (storage_.families[family].key.size < 0) return;
  std::uint32_t* at = &chain_of(storage_.families[family].key);
  while (*at != family) at = &storage_.families[*at].next;
  *at = storage_.families[family].next;
}

std::uint32_t FamilyPool::retire(NodeKey parent) {
  std::uint32_t* link = &chain_of(parent);
  while (*link != kNone && !(storage_.families[*link].key == parent)) link = &storage_.families[*link].next;
  if (*link == kNone) return 0;
  Family& gone = storage_.families[*link];
  *link = gone.next;
  gone.key = {-1, 0, 0};
  gone.next = kNone;
  return static_cast<std::uint32_t>(std::popcount(gone.filled));
}

// A clock's hand: the first from where it stands that was unseen for eight frames, else the longest unseen.
std::uint32_t FamilyPool::make_room() {
  // What a frame has seen it goes on seeing.
  if (!has_room_) return kNone;
  constexpr std::uint32_t kLongUnseen = 8;
  const std::uint32_t all = count();
  std::uint32_t best = kNone;
  std::uint32_t most = in_flight_;
  for (std::uint32_t n = 0; n < all; ++n) {
    const std::uint32_t at = hand_ + n < all ? hand_ + n : hand_ + n - all;
    const Family& family = storage_.families[at];
    const std::uint32_t unseen = family.used ? frame_ - family.last_seen : 0xffffffffu;
    if (unseen <= most) continue;
    most = unseen;
    best = at;
    if (unseen >= kLongUnseen) break;
  }
  has_room_ = best != kNone;
  if (best == kNone) return kNone;
  hand_ = best + 1 < all ? best + 1 : 0;
  Family& gone = storage_.families[best];
  if (gone.used) unlink(best);
  gone = {};
  return best;
}

}  // namespace karst::core
