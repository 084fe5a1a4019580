// SPDX-License-Identifier: MIT
#include "terrain/resident/resident_pool.h"

#include <algorithm>
#include <bit>

#include "terrain/base/check.h"

namespace karst::core {
namespace {

// Rows that are compared for one choice of what gives way. The hand goes around, so all get their turn; the
// oldest of this many is among the oldest of all most of the time.
constexpr std::uint32_t kWindow = 64;

}  // namespace

void ResidentPool::create(const Storage& storage) {
  *this = ResidentPool();
  storage_ = storage;
}

void ResidentPool::reset(std::uint32_t patches, int base_level) {
  const Storage storage = storage_;
  create(storage);
  patches_ = patches;
  base_level_ = base_level;
  std::fill_n(storage_.first_page.begin(), patches, kNoPage);
  std::fill_n(storage_.row_of_patch.begin(), patches, kNoRow);
  std::fill_n(storage_.levels.begin(), patches, std::uint8_t{0});
  for (Row& row : storage_.rows) row = {};
  std::fill(storage_.free_pages.begin(), storage_.free_pages.end(), ~std::uint64_t{0});
  if (page_count() % 64 != 0) storage_.free_pages.back() = (std::uint64_t{1} << page_count() % 64) - 1;
  free_count_ = page_count();
  first_free_ = 0;
}

void ResidentPool::begin_frame() {
  ++frame_;
  List& list = kept_[frame_ % kFramesInFlight];
  set_free(list);
  list = {};
  promised_ = 0;
}

void ResidentPool::release_kept() {
  for (List& list : kept_) {
    set_free(list);
    list = {};
  }
  promised_ = 0;
  idle_frame_ = frame_;
}

std::uint32_t ResidentPool::kept_back() const {
  std::uint32_t count = 0;
  for (const List& list : kept_) count += list.count;
  return count;
}

void ResidentPool::append(List& list, const List& pages) {
  if (pages.count == 0) return;
  if (list.count == 0) {
    list = pages;
    return;
  }
  storage_.next_page[list.last] = pages.first;
  list.last = pages.last;
  list.count += pages.count;
}

void ResidentPool::set_free(const List& pages) {
  std::uint32_t page = pages.first;
  for (std::uint32_t i = 0; i < pages.count; ++i, page = storage_.next_page[page]) {
    storage_.free_pages[page / 64] |= std::uint64_t{1} << page % 64;
    first_free_ = std::min(first_free_, page);
  }
  free_count_ += pages.count;
}

// The first page from this one on that is free, or is not; page_count() where there is none.
std::uint32_t ResidentPool::next_page(std::uint32_t page, bool is_free, std::uint32_t end) const {
  while (page < end) {
    const std::uint64_t bits = storage_.free_pages[page / 64];
    const std::uint64_t wanted = (is_free ? bits : ~bits) >> page % 64;
    if (wanted != 0) return std::min(page + static_cast<std::uint32_t>(std::countr_zero(wanted)), end);
    page = (page / 64 + 1) * 64;
  }
  return end;
}

// The shortest stretch of free pages that holds so many, of the first and those soon behind it, or else the
// longest one.
ResidentPool::Stretch ResidentPool::find_free(std::uint32_t pages) {
  Stretch best;
  std::uint32_t last = page_count();
  std::uint32_t first = next_page(first_free_, true, last);
  first_free_ = first;
  while (first < last) {
    const std::uint32_t end = next_page(first, false, std::min(last, first + std::max(kFar, pages)));
    const std::uint32_t count = end - first;
    if (count == pages) return {first, count};
    if (best.count < pages && count > pages) last = std::min(last, first + kFar);
    if (best.count < pages ? count > best.count : count > pages && count < best.count) best = {first, count};
    first = next_page(end, true, last);
  }
  return best;
}

// Precondition: as many are free.
ResidentPool::List ResidentPool::take_free(std::uint32_t pages, std::uint32_t before) {
  List taken;
  free_count_ -= pages;
  while (taken.count < pages) {
    const std::uint32_t next = before == kNoPage ? page_count() : before + 1;
    const bool goes_on = taken.count == 0 && next < page_count() && next_page(next, true, next + 1) == next &&
                         next_page(next, false, std::min(next + pages, page_count())) - next >= pages;
    const Stretch stretch = goes_on ? Stretch{next, pages} : find_free(pages - taken.count);
    const std::uint32_t end = stretch.first + std::min(stretch.count, pages - taken.count);
    for (std::uint32_t page = stretch.first; page < end; ++page) {
      storage_.free_pages[page / 64] &= ~(std::uint64_t{1} << page % 64);
      append(taken, {page, page, 1});
    }
  }
  storage_.next_page[taken.last] = kNoPage;
  return taken;
}

bool ResidentPool::has_room(PatchId patch, int level) const {
  const std::uint32_t have = pages_at(storage_.levels[patch]);
  const bool row =
      storage_.row_of_patch[patch] != kNoRow || free_row_ != kNoRow || row_end_ < storage_.rows.size();
  return row && pages_at(level) - have <= free_count_;
}

bool ResidentPool::raise(PatchId patch, int level) {
  const int old_level = storage_.levels[patch];
  if (level <= old_level || !has_room(patch, level)) return false;
  std::uint32_t& row = storage_.row_of_patch[patch];
  if (row == kNoRow) {
    if (free_row_ != kNoRow) {
      row = free_row_;
      free_row_ = storage_.rows[row].patch;
    } else {
      row = row_end_++;
    }
    storage_.rows[row] = {patch, frame_, static_cast<std::uint8_t>(level), true, selection_};
    ++resident_;
  }
  const std::uint32_t pages = pages_at(level) - pages_at(old_level);
  if (pages > 0) {
    std::uint32_t* link = &storage_.first_page[patch];
    std::uint32_t last = kNoPage;
    while (*link != kNoPage) last = *link, link = &storage_.next_page[last];
    *link = take_free(pages, last).first;
  }
  storage_.levels[patch] = static_cast<std::uint8_t>(level);
  return true;
}

void ResidentPool::give_back(PatchId patch, std::uint32_t row, const List& pages) {
  const bool in_flight = frame_ != idle_frame_ && frame_ - storage_.rows[row].last_seen < kFramesInFlight;
  if (in_flight) {
    append(kept_[frame_ % kFramesInFlight], pages);
  } else {
    set_free(pages);
  }
  if (storage_.levels[patch] != 0) return;
  storage_.rows[row] = {free_row_, 0, 0, false, 0};
  free_row_ = row;
  storage_.row_of_patch[patch] = kNoRow;
  --resident_;
}

void ResidentPool::lower(PatchId patch, int level) {
  const int old_level = storage_.levels[patch];
  if (level >= old_level) return;
  const std::uint32_t keep = pages_at(level);
  std::uint32_t* link = &storage_.first_page[patch];
  for (std::uint32_t i = 0; i < keep; ++i) link = &storage_.next_page[*link];
  List taken = {*link, *link, pages_at(old_level) - keep};
  *link = kNoPage;
  for (std::uint32_t i = 1; i < taken.count; ++i) taken.last = storage_.next_page[taken.last];
  storage_.levels[patch] = static_cast<std::uint8_t>(level);
  give_back(patch, storage_.row_of_patch[patch], taken);
}

void ResidentPool::replace(PatchId patch, std::uint32_t first, std::uint32_t count) {
  KARST_ASSERT(count > 0 && count <= free_count_ && first + count <= pages_at(storage_.levels[patch]));
  std::uint32_t before = kNoPage;
  std::uint32_t* link = &storage_.first_page[patch];
  for (std::uint32_t i = 0; i < first; ++i) before = *link, link = &storage_.next_page[*link];
  List old = {*link, *link, count};
  for (std::uint32_t i = 1; i < count; ++i) old.last = storage_.next_page[old.last];
  const List made = take_free(count, before);
  storage_.next_page[made.last] = storage_.next_page[old.last];
  *link = made.first;
  give_back(patch, storage_.row_of_patch[patch], old);
}

int ResidentPool::yields_to(std::uint32_t index, const Claim& claim) const {
  const Row& row = storage_.rows[index];
  if (!row.used || row.patch == claim.spared) return kMaxLevel + 1;
  const int level = storage_.levels[row.patch];
  int target = claim.unseen;
  if (row.last_seen == frame_) target = claim.holes ? base_level_ : std::max<int>(row.needed, base_level_);
  // Levels that share a page with the one below make no room.
  return target < level && pages_at(target) < pages_at(level) ? target : kMaxLevel + 1;
}

// One choice: of the rows in a window, the one unseen for longest. Goes on until a window holds a candidate.
bool ResidentPool::take_oldest(const Claim& claim) {
  for (std::uint32_t looked = 0; looked < row_end_;) {
    std::uint32_t best = kNoRow;
    const std::uint32_t window = std::min(kWindow, row_end_ - looked);
    for (std::uint32_t i = 0; i < window; ++i, ++looked) {
      if (hand_ >= row_end_) hand_ = 0;
      const std::uint32_t index = hand_++;
      if (yields_to(index, claim) > kMaxLevel) continue;
      const auto age = [&](std::uint32_t r) { return frame_ - storage_.rows[r].last_seen; };
      if (best == kNoRow || age(index) > age(best)) best = index;
    }
    if (best == kNoRow) continue;
    lower(storage_.rows[best].patch, yields_to(best, claim));
    return true;
  }
  return false;
}

bool ResidentPool::make_room(PatchId patch, int level, bool casts_only) {
  const std::uint32_t wanted = pages_at(level) - std::min(pages_at(level), pages_at(storage_.levels[patch]));
  // What is kept back comes free soon, and is promised to whoever made room first: taking more for the same
  // need would empty the pool.
  const auto take = [&](int unseen, bool holes) {
    while (free_count_ + kept_back() < wanted + promised_ && take_oldest({patch, unseen, holes})) {
    }
  };
  take(base_level_, false);
  if (!keeps_base()) take(0, false);
  if (storage_.levels[patch] == 0 && level <= base_level_ && !casts_only) take(0, true);
  if (storage_.row_of_patch[patch] == kNoRow && free_row_ == kNoRow && row_end_ == storage_.rows.size()) {
    take_oldest({patch, 0, false});
  }
  if (has_room(patch, level)) return true;
  if (free_count_ + kept_back() >= wanted + promised_) promised_ += wanted;
  return false;
}

}  // namespace karst::core
