// SPDX-License-Identifier: MIT
// Steps that can be taken back, in a ring of fixed size: what was there before, cell by cell. A *cell* is
// what an edit replaces as a whole (a block of voxels, the heights of a patch, a block of the ground's
// samples); taking a step back, and taking it again, exchanges each cell with what the log has of it. So both
// are the same, and no edit needs an inverse.
//
//   log.begin();
//   log.add(kind, key, before)  for each cell, before it is changed; the same cell once a step
//   log.end()  or  log.cancel(exchange)
//   log.undo(exchange); log.redo(exchange)
//
// The oldest steps give way to new ones. A step that alone is larger than the ring is refused.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"

namespace karst::core {

enum class CellKind : std::uint8_t { voxels, patch_heights, ground_samples, paint };

struct UndoCell {
  CellKind kind = CellKind::voxels;
  std::uint64_t key = 0;             // what the kind goes by
  std::span<std::byte> bytes;        // in: what shall be there; out: what was
};

class UndoLog {
 public:
  // memory: borrowed, aligned to 8.
  void create(std::span<std::byte> memory);
  void clear();

  // Begins a step. What was taken back and not taken again is forgotten once a cell is added.
  void begin();
  bool is_open() const { return open_; }
  // Of the step that is open: limit_reached ("undo_bytes", bytes that it would take) where it does not fit;
  // then nothing of the edit that asks may be changed, and cells that it has added stay, as they are.
  Status add(CellKind kind, std::uint64_t key, std::span<const std::byte> before);
  bool holds(CellKind kind, std::uint64_t key) const;  // in the open step
  // A step without cells is none.
  void end();

  // Calls exchange(UndoCell&) for the cells of a step, last one first to take it back and first one first to
  // take it again. False: there is none, or one is open.
  template <class Exchange>
  bool undo(const Exchange& exchange);
  template <class Exchange>
  bool redo(const Exchange& exchange);

  std::uint32_t undo_steps() const { return done_; }
  std::uint32_t redo_steps() const { return steps_ - done_; }
  std::uint64_t lost_steps() const { return lost_; }

 private:
  bool open_ = false;
  std::uint32_t steps_ = 0;
  std::uint32_t done_ = 0;
  std::uint64_t lost_ = 0;
};

}  // namespace karst::core
