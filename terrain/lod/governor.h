// SPDX-License-Identifier: MIT
// Keeps what all views of a frame need within the pool of pages (design 4.8): where it is more, all views aim
// at larger errors, by one scale. The scale is computed, not crept up to, from a DemandCurve that is
// corrected by what the frame really takes; so it comes back within a few frames when the views become easy.
// It never exceeds what makes everything coarsest. While the eyes stand still it settles: a scale that was
// too small for them is not tried again.
#pragma once

#include <cstdint>

#include "terrain/lod/demand_curve.h"

namespace karst::core {

class Governor {
 public:
  // Of one select() of all views.
  struct Load {
    std::uint32_t pages = 0;  // that the views take at the levels they want, and one a patch that is kept
    std::uint32_t base = 0;   // of them, those that are taken whatever the error is: one a patch
    std::uint32_t page_count = 0;  // of the pool
    float most_scale = 1;          // beyond it no view's error grows
    bool still = false;            // views, eyes and wishes are those of the last load
    bool morphing = false;         // some view aims at an error
  };
  struct State {
    std::uint32_t wanted_pages = 0;
    // The pages do not hold what error_px wants: error_scale times as much is aimed at until they do.
    bool pool_full = false;
    float error_scale = 1;
    float next_error_scale = 1;  // of the next select()
  };

  void reset() { *this = Governor(); }
  float scale() const { return scale_; }
  const State& state() const { return state_; }

  // Notes a load. True: call adjust() with the curve of its patches in view.
  bool note(const Load& load);
  void adjust(const DemandCurve& curve);

 private:
  int step_for(const DemandCurve& curve, double pages) const;

  Load load_;
  State state_;
  float scale_ = 1;
  float too_small_ = 0;   // largest scale that was too small for these eyes
  bool settled_ = false;  // adjust() found nothing better for the last load
};

}  // namespace karst::core
