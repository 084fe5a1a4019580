// SPDX-License-Identifier: MIT
// Steps that can be taken back, in a ring of fixed size. A step is made of *parts*, each of which is taken
// back, and done again, as one: an edit, or several that changed the same kind of thing. A part is made of
// *cells*: what an edit replaces as a whole (a block of the ground's samples, the heights of a patch), as it
// was before. Whoever gets a part knows by its kind what to do with it: to exchange each cell with what is
// there, or to read what it needs; what it leaves in the cells it gets again when the part's turn comes anew.
//
//   log.begin();
//   log.begin_part(kind);               // for each edit, once nothing of it can fail any more
//   log.add(kind, key, before)          // for each cell, before it is changed; once a cell and part
//   log.end();
//   log.undo([](UndoPart part) { for (UndoCell cell : part) ... });  log.redo(...)
//
// The oldest steps give way to new ones. A step that finds no room even so is lost, and with it all steps
// before it; one that takes half of the ring finds room.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

namespace karst::core {

// Of cells. A part goes by the kind of its first one.
enum class CellKind : std::uint8_t {
  none,
  voxel_edit,      // an edit of voxels itself (terrain/edit/shape/shape_undo.h); voxels, heights follow
  voxels,          // a cube of them
  patch_heights,   // of a patch, by its key; behind a voxel_edit its material, too
  ground_samples,  // a block of them (terrain/edit/ground/edit_ground.h)
  paint,
  region_growth,   // how far a region may be from the ground (EditGround::grow_region)
  field_block,     // of a field's samples, by its number (terrain/edit/field/edit_field.h)
  field_materials  // of a block of a field, by its number (terrain/edit/field/paint_field.h)
};

struct UndoCell {
  CellKind kind = CellKind::none;
  std::uint64_t key = 0;       // what the kind goes by
  std::span<std::byte> bytes;  // aligned to 8
};

class UndoPart;

class UndoLog {
 public:
  // Of a cell with so many bytes.
  static constexpr std::size_t cell_bytes(std::size_t bytes) {
    return sizeof(Header) + (bytes + 7) / 8 * 8 + kFooterBytes;
  }

  // memory: borrowed, aligned to 8; 2^31 bytes of it are used at most.
  void create(std::span<std::byte> memory);
  bool exists() const { return !memory_.empty(); }
  // Forgets all steps.
  void clear();

  // Begins a step. Precondition: none is open.
  void begin();
  bool is_open() const { return open_; }
  // The next cell is the first one of a part. Precondition: a step is open.
  void begin_part() { fresh_part_ = true; }
  // The open step's last part, to which the next cell belongs: its kind, and a number that no other has.
  // none, where there is no such part.
  CellKind open_part() const { return fresh_part_ || !open_ ? CellKind::none : part_kind_; }
  std::uint64_t part_number() const { return part_number_; }
  std::uint32_t part_cells() const { return part_cells_; }  // so far

  // Room for a cell, to be written at once. Precondition: a step is open. What was taken back can't be taken
  // again from then on. Empty, where bytes > 0, once the step is lost.
  std::span<std::byte> add(CellKind kind, std::uint64_t key, std::size_t bytes);
  void add(CellKind kind, std::uint64_t key, std::span<const std::byte> before) {
    const std::span<std::byte> room = add(kind, key, before.size());
    if (!room.empty()) std::memcpy(room.data(), before.data(), before.size());
  }
  // Gives the open step up, of which not all can be kept. Precondition: a step is open.
  void lose();
  // Whether the open step is lost. Then nothing is kept of it, nor of those before it.
  bool is_lost() const { return open_lost_; }
  // A step without cells is none.
  void end();

  // Calls take(UndoPart) for the parts of a step, the last one first to take it back, the first one first to
  // do it again. False: there is no step, or one is open.
  template <class Take>
  bool undo(const Take& take);
  template <class Take>
  bool redo(const Take& take);
  // The same a part at a time: the next one of the step that is being taken, or the first one of another;
  // none where undo() and redo() would return false. While is_taking() more of the step follows, the same
  // way, and nothing else is done with the log; undo_steps() and redo_steps() count the step as not taken
  // yet.
  std::optional<UndoPart> next(bool back);
  bool is_taking() const { return is_taking_; }
  bool takes_back() const { return takes_back_; }  // of the step that was taken last

  std::uint32_t undo_steps() const { return done_; }
  std::uint32_t redo_steps() const { return steps_ - done_; }
  std::uint64_t lost_steps() const { return lost_; }  // since create()

 private:
  friend class UndoPart;

  // In front of a cell's bytes; behind them, in 8 more, `total` stands once more.
  struct Header {
    std::uint64_t key;
    std::uint32_t total;  // with header and footer
    std::uint32_t bytes;
    CellKind kind;
    bool first, last;  // of its step
    bool begins_part;
    std::uint8_t unused[4];
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
  // Where a cell lies that is behind the end of another.
  std::size_t place(std::size_t end) const { return is_wrapped() && end == wrap_ ? 0 : end; }
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
  bool open_lost_ = false;
  bool fresh_part_ = true;
  CellKind part_kind_ = CellKind::none;
  bool is_taking_ = false, takes_back_ = false;
  std::uint32_t open_cells_ = 0;
  std::uint64_t part_number_ = 0;
  std::uint32_t part_cells_ = 0;
  std::uint32_t steps_ = 0;  // closed ones
  std::uint32_t done_ = 0;
  std::uint64_t lost_ = 0;
};

// Cells in the order in which they were added. Valid until anything else is done with the log.
class UndoPart {
 public:
  class Iterator {
   public:
    UndoCell operator*() const { return log_->cell(at_); }
    Iterator& operator++() {
      at_ = log_->place(at_ + log_->header(at_).total);
      ++number_;
      return *this;
    }
    bool operator==(const Iterator& other) const { return number_ == other.number_; }

   private:
    friend class UndoPart;
    Iterator(UndoLog* log, std::size_t at, std::uint32_t number) : log_(log), at_(at), number_(number) {}
    UndoLog* log_;
    std::size_t at_;
    std::uint32_t number_;
  };

  CellKind kind() const { return (*begin()).kind; }
  Iterator begin() const { return {log_, at_, 0}; }
  Iterator end() const { return {log_, at_, cells_}; }

 private:
  friend class UndoLog;
  UndoPart(UndoLog* log, std::size_t at, std::uint32_t cells) : log_(log), at_(at), cells_(cells) {}
  UndoLog* log_;
  std::size_t at_;
  std::uint32_t cells_;
};

template <class Take>
bool UndoLog::undo(const Take& take) {
  for (std::optional<UndoPart> part = next(true); part; part = next(true)) {
    take(*part);
    if (!is_taking()) return true;
  }
  return false;
}

template <class Take>
bool UndoLog::redo(const Take& take) {
  for (std::optional<UndoPart> part = next(false); part; part = next(false)) {
    take(*part);
    if (!is_taking()) return true;
  }
  return false;
}

}  // namespace karst::core
