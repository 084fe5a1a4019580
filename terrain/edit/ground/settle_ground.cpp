// SPDX-License-Identifier: MIT
// Measures of nodes that edits leave for later.
#include <algorithm>

#include "terrain/base/check.h"
#include "terrain/edit/ground/edit_ground.h"

namespace karst::core {

// Places that nodes of the coarsest exact size would join become one.
void EditGround::wait(const GridRect& samples, int least_size) {
  if (info_.top_size() < least_size) return;
  constexpr std::int64_t kNear = std::int64_t{kNodeQuads} << kReferenceSizes;
  const auto is_near = [&](const GridRect& other) {
    bool near = true;
    for (int axis = 0; axis < 2; ++axis) {
      near = near && samples.low[axis] <= other.high[axis] + kNear &&
             other.low[axis] <= samples.high[axis] + kNear;
    }
    return near;
  };
  const bool was_waiting = waiting_ > 0;
  std::size_t n = 0;
  while (n < waiting_ && !is_near(waiting_at_[n])) ++n;
  n = std::min(n, kWaiting - 1);
  if (n == waiting_) {
    waiting_at_[waiting_++] = samples;
  } else {
    waiting_at_[n].take(samples.low[0], samples.low[1]);
    waiting_at_[n].take(samples.high[0], samples.high[1]);
  }
  wait_size_ = was_waiting && wait_size_ < least_size ? wait_size_ : least_size;
  wait_turn_ = 0;
}

// Size by size, because each looks at what finer ones around have.
void EditGround::settle_some(GroundChange& change) {
  KARST_ASSERT(!is_settled());
  change = {};
  change.changed = true;
  change.samples = waiting_at_[wait_turn_];
  change.stamp = ++stamp_;
  MeasureEdits measure(info_, overlay_, file_, blocks_.scratch[0].measure, growths(), stamp_);
  measure.measure_again(wait_size_, change.samples);
  change.measured = measure.measured();
  if (!measure.trouble().ok()) trouble_ = measure.trouble();
  if (++wait_turn_ < waiting_) return;
  wait_turn_ = 0;
  if (++wait_size_ > info_.top_size()) waiting_ = 0;
}

void EditGround::show_measures(const GroundChange& change, Ground& ground) const {
  for (const EditedTile& tile : overlay_.tiles()) {
    if (tile.stamp == change.stamp) ground.replace(tile.key, tile.tile);
  }
}

}  // namespace karst::core
