// SPDX-License-Identifier: MIT
#include "terrain/lod/threshold_sets.h"

#include <algorithm>

#include "terrain/base/check.h"

namespace karst::core {
namespace {

// No threshold: in rows that the GPU does not have.
constexpr std::uint16_t kNoHalf = 0xffff;

}  // namespace

Status ThresholdSets::create(const Config& config, Arena& arena) {
  count_ = static_cast<int>(config.max_views);
  patches_a_set_ = config.max_patches;
  rows_a_set_ = config.max_resident_patches;
  reset();
  return take_blocks(config, arena, blocks_);
}

void ThresholdSets::reset() {
  for (Set& set : sets_) set = {};
  patches_ = 0;
}

void ThresholdSets::forget_rows() {
  for (Set& set : sets_) set.dirty_begin = set.dirty_end = 0;
  std::fill(blocks_.rows.begin(), blocks_.rows.end(), kNoHalf);
}

void ThresholdSets::outdate() {
  for (Set& set : sets_) set.version = 0;
}

int ThresholdSets::find(const Key& key) const {
  for (int s = 0; s < count_; ++s) {
    const Set& set = sets_[static_cast<std::size_t>(s)];
    if (set.version != 0 && set.key == key) return s;
  }
  return -1;
}

int ThresholdSets::oldest_unused() const {
  int best = -1;
  for (int s = 0; s < count_; ++s) {
    const Set& set = sets_[static_cast<std::size_t>(s)];
    if (set.used) continue;
    if (best < 0 || set.last_used < sets_[static_cast<std::size_t>(best)].last_used) best = s;
  }
  return best;
}

void ThresholdSets::assign(std::span<const Key> keys, std::span<int> sets, std::uint32_t frame) {
  KARST_ASSERT(keys.size() == sets.size() && keys.size() <= static_cast<std::size_t>(count_));
  std::array<int, kMostViews> old{};
  std::copy(sets.begin(), sets.end(), old.begin());
  for (Set& set : sets_) {
    set.used = false;
    if (set.version != 0 && frame - set.last_used > kIdleFrames) set.version = 0;
  }
  const auto use = [&](std::size_t view, int s) {
    Set& set = sets_[static_cast<std::size_t>(s)];
    set.used = true;
    set.last_used = frame;
    sets[view] = s;
  };
  for (std::size_t view = 0; view < keys.size(); ++view) {
    const int same = find(keys[view]);
    sets[view] = -1;
    if (same >= 0) use(view, same);
  }
  for (std::size_t view = 0; view < keys.size(); ++view) {
    if (sets[view] >= 0) continue;
    // Views that change together go on together.
    for (std::size_t other = 0; other < view && sets[view] < 0; ++other) {
      if (keys[other] == keys[view]) sets[view] = sets[other];
    }
    if (sets[view] >= 0) continue;
    const int own = old[view];
    const bool is_free = own >= 0 && own < count_ && !sets_[static_cast<std::size_t>(own)].used;
    use(view, is_free ? own : oldest_unused());
  }
}

Status ThresholdSets::fill(int index, std::span<SetThresholds> jobs, const ResidentPool& pool) {
  Set& set = sets_[static_cast<std::size_t>(index)];
  const Key key{jobs[0].scale, jobs[0].morphing, jobs[0].max_level};
  if (set.version != 0 && set.key == key) return {};
  patches_ = 0;
  for (const SetThresholds& job : jobs) patches_ += static_cast<std::uint32_t>(job.surface.patches.size());
  std::size_t first = 0;
  for (SetThresholds& job : jobs) {
    job.lods = all_lods(index).subspan(first, job.surface.patches.size());
    first += job.lods.size();
    if (const Status status = job.validate(); !status.ok()) return status;
    job.run();
  }
  set.key = key;
  set.version = ++versions_;
  for (std::uint32_t row = 0; row < pool.row_end(); ++row) {
    if (!pool.row_at(row).used) continue;
    const PatchId patch = pool.row_at(row).patch;
    PatchId begin = 0;
    std::size_t part = 0;
    for (; patch - begin >= jobs[part].lods.size(); ++part)
      begin += static_cast<PatchId>(jobs[part].lods.size());
    touch_row(index, jobs[part].surface, begin, patch, row);
  }
  return {};
}

std::span<PatchLod> ThresholdSets::all_lods(int set) const {
  return blocks_.lods.subspan(static_cast<std::size_t>(set) * patches_a_set_, patches_);
}

std::span<const PatchLod> ThresholdSets::lods(int set) const {
  KARST_ASSERT(set >= 0 && set < count_);
  return all_lods(set);
}

void ThresholdSets::touch(const Surface& surface, PatchId patch, std::uint32_t row, PatchId first) {
  for (int s = 0; s < count_; ++s) {
    if (sets_[static_cast<std::size_t>(s)].version != 0) touch_row(s, surface, first, patch, row);
  }
}

void ThresholdSets::touch_row(int index, const Surface& surface, PatchId first, PatchId patch,
                              std::uint32_t row) {
  KARST_ASSERT(row < rows_a_set_);
  Set& set = sets_[static_cast<std::size_t>(index)];
  const std::size_t at = (std::size_t{first_row(index)} + row) * kMorphRow;
  std::array<std::uint16_t, kMorphRow> made;
  make_morph_row(surface, all_lods(index).subspan(first, surface.patches.size()), patch - first, made);
  const auto held = blocks_.rows.subspan(at, kMorphRow);
  if (std::equal(made.begin(), made.end(), held.begin())) return;
  std::copy(made.begin(), made.end(), held.begin());
  if (set.dirty_begin == set.dirty_end) set.dirty_begin = set.dirty_end = row;
  set.dirty_begin = std::min(set.dirty_begin, row);
  set.dirty_end = std::max(set.dirty_end, row + 1);
}

MorphRows ThresholdSets::take() {
  for (int s = 0; s < count_; ++s) {
    Set& set = sets_[static_cast<std::size_t>(s)];
    if (set.dirty_begin == set.dirty_end) continue;
    const std::uint32_t first = first_row(s) + set.dirty_begin;
    const std::size_t count = set.dirty_end - set.dirty_begin;
    set.dirty_begin = set.dirty_end = 0;
    return {first, blocks_.rows.subspan(std::size_t{first} * kMorphRow, count * kMorphRow)};
  }
  return {};
}

}  // namespace karst::core
