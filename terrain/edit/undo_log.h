// SPDX-License-Identifier: MIT
// Steps that can be taken back, in a ring of fixed size: what was there before, cell by cell. A *cell* is
// what an edit replaces as a whole (a block of voxels, the heights of a patch, a block of the ground's
// samples). Taking a step back exchanges each of its cells with what the log has of it, and so does taking it
// again: no edit needs an inverse.
//
//   log.begin();
//   log.add(kind, key, before)  for each cell, before it is changed; once a cell and step
//   log.end();
//   log.undo([](UndoCell cell) { ... });  log.redo(...)
//
// The oldest steps give way to new ones. A step that is larger than the ring is refused; one larger than
// half of it may be.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"

namespace karst::core {

enum class CellKind : std::uint8_t { voxels, patch_heights, ground_samples, paint };

struct UndoCell {
  CellKind kind = CellKind::voxels;
  std::uint64_t key = 0;       // what the kind goes by
  std::span<std::byte> bytes;  // in: what shall be there; out: what was there, as many
};

class UndoLog {
 public:
  // Of a cell with so many bytes.
  static constexpr std::size_t cell_bytes(std::size_t bytes) {
    return sizeof(Header) + (bytes + 7) / 8 * 8 + kFooterBytes;
  }

  // memory: borrowed, aligned to 8; 2^31 bytes of it are used at most.
  void create(std::span<std::byte> memory);
  // Forgets all steps.
  void clear();

  // Begins a step. Precondition: none is open.
  void begin();
  bool is_open() const { return open_; }
  // Of the open step. What was taken back can't be taken again from then on. limit_reached ("undo_bytes",
  // bytes that would do): nothing is added, but older steps may be lost.
  Status add(CellKind kind, std::uint64_t key, std::span<const std::byte> before);
  // Whether the open step has the cell.
  bool holds(CellKind kind, std::uint64_t key) const;
  // Cells of the open step.
  std::uint32_t open_cells() const { return open_cells_; }
  // Forgets those beyond the first `cells`: of an edit that failed. Precondition: there are as many.
  void drop_cells(std::uint32_t cells);
  // A step without cells is none.
  void end();

  // Calls exchange(UndoCell) for the cells of a step, the last one first to take it back, the first one first
  // to take it again. False: there is no step, or one is open.
  template <class Exchange>
  bool undo(const Exchange& exchange) {
    if (open_ || done_ == 0) return false;
    for (bool first = false; !first;) {
      cursor_ = before(cursor_);
      first = header(cursor_).first;
      exchange(cell(cursor_));
    }
    --done_;
    return true;
  }
  template <class Exchange>
  bool redo(const Exchange& exchange) {
    if (open_ || done_ == steps_) return false;
    for (bool last = false; !last;) {
      if (is_wrapped() && cursor_ == wrap_) cursor_ = 0;
      last = header(cursor_).last;
      exchange(cell(cursor_));
      cursor_ += header(cursor_).total;
    }
    ++done_;
    return true;
  }

  std::uint32_t undo_steps() const { return done_; }
  std::uint32_t redo_steps() const { return steps_ - done_; }
  std::uint64_t lost_steps() const { return lost_; }  // since clear()

 private:
  // In front of a cell's bytes; behind them, in 8 more, `total` stands once more.
  struct Header {
    std::uint64_t key;
    std::uint32_t total;  // with header and footer
    std::uint32_t bytes;
    CellKind kind;
    bool first, last;  // of its step
    std::uint8_t unused[5];
  };
  static_assert(sizeof(Header) == 24);
  static constexpr std::size_t kFooterBytes = 8;

  Header& header(std::size_t at) { return *reinterpret_cast<Header*>(memory_.data() + at); }
  const Header& header(std::size_t at) const { return *reinterpret_cast<const Header*>(memory_.data() + at); }
  UndoCell cell(std::size_t at) {
    const Header& head = header(at);
    return {head.kind, head.key, memory_.subspan(at + sizeof(Header), head.bytes)};
  }
  // Cells lie in [base_, head_), or in [base_, wrap_) and [0, head_).
  bool is_wrapped() const { return head_ < base_; }
  // Where the cell in front of a place begins. Precondition: there is one.
  std::size_t before(std::size_t at) const;
  void forget_undone();
  void forget_oldest();
  bool make_place(std::size_t total, std::size_t& at);

  std::span<std::byte> memory_;
  std::size_t base_ = 0;
  std::size_t head_ = 0;
  std::size_t wrap_ = 0;
  std::size_t cursor_ = 0;  // what was taken back lies behind it
  bool open_ = false;
  std::uint32_t open_cells_ = 0;
  std::uint32_t steps_ = 0;  // closed ones
  std::uint32_t done_ = 0;
  std::uint64_t lost_ = 0;
};

}  // namespace karst::core
