// SPDX-License-Identifier: MIT
// How many pages of vertices a frame would take if its views aimed at larger errors: an estimate for all
// error scales at once, from one look at each patch in view.
//
// A patch needs level m as long as its threshold (morph.h) is above its apparent distance rho. By (1) that is
// so below the error scale
//     s(m) = S / error_px * error(m - 1) / (rho - G reach(m) / (1 - sigma) - error(m - 1))
// and by (2) where the same holds of a finer level at a distance nearer by the box; neighbours' thresholds
// are left out, so it is a little too low. What each level adds is counted at its s(m) in steps of 2^(1/16).
#pragma once

#include <array>
#include <cstdint>

#include "terrain/lod/morph.h"
#include "terrain/measure/level_error.h"

namespace karst::core {

class DemandCurve {
 public:
  static constexpr int kStepsPerDoubling = 16;
  static constexpr int kSteps = 20 * kStepsPerDoubling;  // up to a scale of 2^20

  static float scale_at(int step);  // 0..kSteps - 1; scale_at(0) is 1
  static int step_below(float scale);

  // A patch in view. apparent: its least_apparent_distance(). pixels: ErrorScale's S over the error in pixels
  // that is aimed at where the scale is 1. weight: scales by which the view's error falls behind, 1 or more:
  // the view aims at max(1, scale / weight) times its error. top_level: finest that is drawn.
  void add(const LevelErrors& errors, PatchId patch, const PatchLod& lod, float apparent, float pixels,
           float weight, int top_level);

  // Pages beyond one a patch at a step's scale, of all patches added. Precondition: finish() was called.
  std::uint32_t detail_pages(int step) const { return pages_[static_cast<std::size_t>(step)]; }
  void finish();
  // The least step from which on, up to a last one, next to nothing more is saved: what is left is needed at
  // any scale. Precondition: finish() was called.
  int coarsest_step(int last) const;

 private:
  std::array<std::uint32_t, kSteps> pages_{};
};

}  // namespace karst::core
