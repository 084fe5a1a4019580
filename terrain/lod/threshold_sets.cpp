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
  std::fill(blocks_.dirty.begin(), blocks_.dirty.end(), std::uint64_t{0});
  std::fill(blocks_.rows.begin(), blocks_.rows.end(), kNoHalf);
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

void ThresholdSets::update(SetThresholds job, std::span<PatchId> list, std::size_t changed, PatchId first,
                           const ResidentPool& pool) {
  for (int s = 0; s < count_; ++s) {
    Set& set = sets_[static_cast<std::size_t>(s)];
    if (set.version == 0) continue;
    if (set.key.top_level < job.errors.level) {
      set.version = 0;  // what finer levels had is not kept
      continue;
    }
    job.scale = set.key.scale;
    job.morphing = set.key.morphing;
    job.max_level = set.key.top_level;
    job.lods = all_lods(s).subspan(first, job.surface.patches.size());
    const std::size_t count = job.update(list, changed);
    set.version = ++versions_;
    const auto touch = [&](PatchId patch) {
      const std::uint32_t row = pool.row(first + patch);
      if (row != ResidentPool::kNoRow) touch_row(s, job.surface, first, first + patch, row);
    };
    // Edges have the smaller threshold of two.
    for (const PatchId patch : list.first(count)) {
      touch(patch);
      for (const PatchEdge edge : job.surface.patches[patch].neighbour) {
        if (edge.exists()) touch(edge.patch());
      }
    }
  }
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
  dirty_of(index)[row / 64] |= std::uint64_t{1} << row % 64;
}

// A few rows that did not change are less than a call more.
MorphRows ThresholdSets::take() {
  constexpr std::uint32_t kGap = 8;
  for (int s = 0; s < count_; ++s) {
    Set& set = sets_[static_cast<std::size_t>(s)];
    const std::span<std::uint64_t> dirty = dirty_of(s);
    const auto is_dirty = [&](std::uint32_t row) { return (dirty[row / 64] >> row % 64 & 1u) != 0; };
    std::uint32_t begin = set.dirty_begin;
    while (begin < set.dirty_end && !is_dirty(begin)) ++begin;
    std::uint32_t end = begin;  // behind the last one that is dirty
    for (std::uint32_t row = begin; row < set.dirty_end && row - end <= kGap; ++row) {
      if (!is_dirty(row)) continue;
      dirty[row / 64] &= ~(std::uint64_t{1} << row % 64);
      end = row + 1;
    }
    set.dirty_begin = end;
    if (end == set.dirty_end) set.dirty_begin = set.dirty_end = 0;
    if (begin == end) continue;
    const std::uint32_t first = first_row(s) + begin;
    return {first,
            blocks_.rows.subspan(std::size_t{first} * kMorphRow, std::size_t{end - begin} * kMorphRow)};
  }
  return {};
}

}  // namespace karst::core
