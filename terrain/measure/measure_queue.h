// SPDX-License-Identifier: MIT
// Patches that edits touched and that are to be measured when there is time. Until then their boxes are
// exact or, of what is loose, no less than that, their errors are no less than what will be measured, and
// their cones hold all directions: whatever is asked of measures is answered safely, and costs more. Once
// none is left, all are what MeasurePatches gives.
//
//   queue.add(surface, heights, changed, touched, scratch, out);  // after an edit
//   while (queue.loose() > 0 && there is time) { before(queue.next_loose()); queue.fit(...) }
//   while (queue.left() > 0 && there is time) queue.measure_next(surface, heights, room, out)
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "terrain/base/budget.h"
#include "terrain/base/config.h"
#include "terrain/measure/measure_patches.h"

namespace karst::core {

class MeasureQueue {
 public:
  // By slot. Borrowed for the queue's life.
  struct Storage {
    std::span<OwnErrors> own;
    std::span<std::uint8_t> states;

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      const std::size_t slots = config.edit_patches > 0 ? config.max_patches : 0;
      visit(Consumer::edits, slots, own);
      visit(Consumer::edits, slots, states);
    }
  };
  void create(const Storage& storage) { storage_ = storage; }
  // All patches of a world are measured, nothing is known of how.
  void reset();

  // changed: patches whose volume, edges or heights are others; touched: of find_touched(), and rows of each
  // that hold what may be other vertices. None is free, each is there once. Gives them measures for the time
  // being. exact: how many of those changed get exact boxes; the others are loose.
  void add(const Surface& surface, const Heights& heights, std::span<const PatchId> changed,
           std::span<const PatchId> touched, std::span<const GridRows> rows, PatchScratch* scratch,
           const PatchMeasures& out, std::size_t exact = kAll);
  static constexpr std::size_t kAll = ~std::size_t{0};
  // A slot that is free now.
  void forget(PatchId slot);

  std::uint32_t left() const { return left_; }
  // Of them, those whose boxes are not exact yet.
  std::uint32_t loose() const { return loose_; }
  // Precondition: loose() > 0.
  PatchId next_loose();
  // A loose patch's box is exact from now on.
  void fit(const Surface& surface, const Heights& heights, PatchId patch, PatchScratch* scratch,
           const PatchMeasures& out);
  // Precondition: left() > 0, loose() is 0. Its measures are final, until the next edit.
  PatchId measure_next(const Surface& surface, const Heights& heights, const MeasurePatches::Room& room,
                       const PatchMeasures& out);

 private:
  // Bits of a state.
  enum : unsigned {
    kWaits = 1,
    kErrors = 2,   // its errors are to be measured, too,
    kCone = 4,     // and the cone of what is drawn
    kBounded = 8,  // `own` has bounds,
    kKnown = 16,   // or what was measured
    kLoose = 32
  };

  std::span<std::uint16_t> row_of(const Heights& heights, PatchId patch, const PatchMeasures& out) const {
    const std::size_t row = level_error_values(heights.level);
    return out.level_errors.subspan(patch * row, row);
  }
  void wait(PatchId patch, unsigned more);
  void set_loose(PatchId patch, bool loose);
  void bound(const GenerateVertices& generate, PatchId patch, const PatchMeasures& out);
  void know(const LevelGrid& grid, PatchId patch);
  void join_bounds(const Surface& surface, const Heights& heights, PatchId patch, const PatchMeasures& out);

  Storage storage_;
  std::uint32_t left_ = 0, loose_ = 0;
  std::size_t next_ = 0, next_loose_ = 0;  // where looking for one goes on
};

}  // namespace karst::core
