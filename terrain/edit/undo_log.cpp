// SPDX-License-Identifier: MIT
#include "terrain/edit/undo_log.h"

#include <algorithm>

#include "terrain/base/check.h"

namespace karst::core {

void UndoLog::create(std::span<std::byte> memory) {
  memory_ = memory.first(std::min(memory.size(), std::size_t{1} << 31));
  KARST_ASSERT(reinterpret_cast<std::uintptr_t>(memory_.data()) % 8 == 0);
  open_ = open_lost_ = false;
  lost_ = 0;
  clear();
}

void UndoLog::clear() {
  base_ = head_ = wrap_ = cursor_ = 0;
  open_cells_ = steps_ = done_ = 0;
  is_taking_ = false;
}

std::size_t UndoLog::before(std::size_t at) const {
  if (at == 0) at = wrap_;
  std::uint32_t total = 0;
  std::memcpy(&total, memory_.data() + at - kFooterBytes, sizeof total);
  return at - total;
}

void UndoLog::begin() {
  KARST_ASSERT(!open_ && !is_taking_);
  open_ = fresh_part_ = true;
  open_lost_ = false;
  open_cells_ = 0;
}

// Steps that were taken back: the ring ends where they begin.
void UndoLog::forget_undone() {
  steps_ = done_;
  head_ = cursor_;
  if (steps_ == 0) base_ = head_ = cursor_ = 0;
}

// Precondition: there is a closed step, and none that was taken back.
void UndoLog::forget_oldest() {
  for (bool last = false; !last;) {
    if (is_wrapped() && base_ == wrap_) base_ = 0;
    last = header(base_).last;
    base_ += header(base_).total;
  }
  if (is_wrapped() && base_ == wrap_) base_ = 0;
  --steps_;
  --done_;
  ++lost_;
}

// A place of so many bytes; head_ is behind it then. False: there is none, however much is forgotten.
bool UndoLog::make_place(std::size_t total, std::size_t& at) {
  if (total > memory_.size()) return false;
  while (true) {
    if (steps_ == 0 && open_cells_ == 0) base_ = head_ = 0;
    if (!is_wrapped()) {
      if (head_ + total <= memory_.size()) break;
      if (total < base_) {
        wrap_ = head_;
        head_ = 0;
        break;
      }
    } else if (head_ + total < base_) {
      break;
    }
    if (steps_ == 0) return false;
    forget_oldest();
  }
  at = head_;
  head_ += total;
  return true;
}

void UndoLog::lose() {
  KARST_ASSERT(open_);
  if (open_lost_) return;
  // What lies before it cannot be taken back without it.
  lost_ += std::uint64_t{done_} + 1;
  open_lost_ = fresh_part_ = true;
  clear();
}

std::span<std::byte> UndoLog::add(CellKind kind, std::uint64_t key, std::size_t bytes) {
  KARST_ASSERT(open_);
  if (open_lost_) return {};
  if (open_cells_ == 0) forget_undone();
  const std::size_t total = cell_bytes(bytes);
  std::size_t at = 0;
  if (!make_place(total, at)) {
    lose();
    return {};
  }
  Header& head = header(at);
  head = {key,
          static_cast<std::uint32_t>(total),
          static_cast<std::uint32_t>(bytes),
          kind,
          open_cells_ == 0,
          false,
          fresh_part_,
          {}};
  if (fresh_part_) {
    fresh_part_ = false;
    part_kind_ = kind;
    ++part_number_;
    part_cells_ = 0;
  }
  ++part_cells_;
  std::memcpy(memory_.data() + at + total - kFooterBytes, &head.total, sizeof head.total);
  ++open_cells_;
  cursor_ = head_;
  return memory_.subspan(at + sizeof(Header), bytes);
}

std::optional<UndoPart> UndoLog::next(bool back) {
  if (open_ || (!is_taking_ && done_ == (back ? 0 : steps_))) return {};
  KARST_ASSERT(!is_taking_ || takes_back_ == back);
  takes_back_ = back;
  std::uint32_t cells = 0;
  if (back) {
    do {
      cursor_ = before(cursor_);
      ++cells;
    } while (!header(cursor_).begins_part);
    is_taking_ = !header(cursor_).first;
    if (!is_taking_) --done_;
    return UndoPart(this, cursor_, cells);
  }
  bool last = false;
  cursor_ = place(cursor_);
  const std::size_t at = cursor_;
  do {
    last = header(cursor_).last;
    cursor_ = place(cursor_ + header(cursor_).total);
    ++cells;
  } while (!last && !header(cursor_).begins_part);
  is_taking_ = !last;
  if (last) ++done_;
  return UndoPart(this, at, cells);
}

void UndoLog::end() {
  KARST_ASSERT(open_);
  open_ = open_lost_ = false;
  if (open_cells_ == 0) return;
  header(before(head_)).last = true;
  ++steps_;
  ++done_;
  open_cells_ = 0;
}

}  // namespace karst::core
