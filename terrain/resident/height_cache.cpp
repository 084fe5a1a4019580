// SPDX-License-Identifier: MIT
#include "terrain/resident/height_cache.h"

#include <algorithm>

namespace karst::core {
namespace {

std::size_t group_samples(int level) {
  return std::size_t{kHeightGroup} * static_cast<std::size_t>(patch_vertices(level));
}

}  // namespace

void HeightCache::create(const Storage& storage) {
  *this = HeightCache();
  storage_ = storage;
}

Status HeightCache::reset(int level, std::uint32_t blocks) {
  level_ = level;
  blocks_ = blocks;
  groups_ = (blocks + kHeightGroup - 1) / kHeightGroup;
  filled_ = 0;
  now_ = 0;
  const std::size_t room = std::min(
      {storage_.samples.size() / group_samples(level), storage_.group_of_slot.size(), storage_.used.size()});
  slots_ = static_cast<std::uint32_t>(std::min<std::size_t>(room, groups_));
  const bool enough = slots_ == groups_ || slots_ >= kLeastGroups;
  if (!enough || groups_ > storage_.slot_of_group.size()) {
    blocks_ = groups_ = slots_ = 0;
    return {StatusCode::limit_reached, "too small for the heights around one patch", "max_height_blocks",
            std::min(blocks, kLeastGroups * kHeightGroup)};
  }
  std::fill_n(storage_.slot_of_group.begin(), groups_, kNowhere);
  return {};
}

std::span<std::int16_t> HeightCache::slot(std::uint32_t index, std::uint32_t group) const {
  const std::uint32_t blocks = std::min(kHeightGroup, blocks_ - group * kHeightGroup);
  return storage_.samples.subspan(index * group_samples(level_),
                                  blocks * static_cast<std::size_t>(patch_vertices(level_)));
}

// Ages wrap around with the counter, which does no harm.
std::uint32_t HeightCache::oldest() const {
  std::uint32_t best = 0;
  for (std::uint32_t s = 1; s < slots_; ++s) {
    if (now_ - storage_.used[s] > now_ - storage_.used[best]) best = s;
  }
  return best;
}

Status HeightCache::hold(std::uint32_t block, const HeightSource& source) {
  const std::uint32_t group = block / kHeightGroup;
  std::uint32_t& place = storage_.slot_of_group[group];
  if (place != kNowhere) {
    storage_.used[place] = now_;
    return {};
  }
  std::uint32_t to = filled_;
  if (filled_ == slots_) {
    to = oldest();
    if (storage_.used[to] == now_) {
      return {StatusCode::limit_reached, "too small for the heights around one patch", "max_height_blocks"};
    }
    if (storage_.group_of_slot[to] != kNowhere) storage_.slot_of_group[storage_.group_of_slot[to]] = kNowhere;
    storage_.group_of_slot[to] = kNowhere;  // until it holds something again
  }
  if (const Status status = source.read(source.context, group, slot(to, group)); !status.ok()) return status;
  if (to == filled_) ++filled_;
  ++groups_read_;
  storage_.group_of_slot[to] = group;
  storage_.used[to] = now_;
  place = to;
  return {};
}

Heights HeightCache::heights() const {
  return {level_, storage_.samples.first(slots_ * group_samples(level_)),
          storage_.slot_of_group.first(groups_)};
}

void HeightCache::hold_rest() {
  for (std::uint32_t group = 0; group < groups_; ++group) {
    if (storage_.slot_of_group[group] != kNowhere) continue;
    storage_.group_of_slot[filled_] = group;
    storage_.used[filled_] = now_;
    storage_.slot_of_group[group] = filled_++;
  }
}

}  // namespace karst::core
