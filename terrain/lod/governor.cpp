// SPDX-License-Identifier: MIT
#include "terrain/lod/governor.h"

#include <algorithm>

namespace karst::core {
namespace {

// Of the pages for detail, what a new scale is to use; and below what use a smaller scale is looked for.
constexpr double kAimedUse = 0.9;
// Estimates are off by more than this where views see the same patches, or where neighbours ask for more.
constexpr double kLeastCorrection = 1.0 / 16;
constexpr double kMostCorrection = 8;
// Steps beyond the one where, by the estimate, nothing more is saved: it leaves neighbours out.
constexpr int kMargin = DemandCurve::kStepsPerDoubling;

std::uint32_t less(std::uint32_t a, std::uint32_t b) {
  return a - std::min(a, b);
}

}  // namespace

bool Governor::note(const Load& load) {
  const bool full = load.pages > load.page_count;
  const bool unchanged = load.still && load.pages == load_.pages && settled_;
  state_ = {load.pages, full || (load.morphing && scale_ > 1), scale_, scale_};
  load_ = load;
  if (!load.morphing) return false;
  if (!load.still) too_small_ = 0;
  if (unchanged) return false;
  settled_ = false;
  if (full) {
    too_small_ = std::max(too_small_, scale_);
    return scale_ < load.most_scale;
  }
  const std::uint64_t detail = less(load.pages, load.base);
  const std::uint64_t room = less(load.page_count, load.base);
  return scale_ > 1 && detail * 4 <= room * 3;
}

// The least step whose pages are no more than so many.
int Governor::step_for(const DemandCurve& curve, double pages) const {
  int step = 0;
  while (step < DemandCurve::kSteps - 1 && curve.detail_pages(step) > pages) ++step;
  return step;
}

void Governor::adjust(const DemandCurve& curve) {
  const double detail = less(load_.pages, load_.base);
  const double room = less(load_.page_count, load_.base);
  const int now = DemandCurve::step_below(scale_);
  const double estimated = curve.detail_pages(now);
  const double correction =
      estimated > 0 ? std::clamp(detail / estimated, kLeastCorrection, kMostCorrection) : 1;
  const float before = scale_;
  int step = step_for(curve, room * kAimedUse / correction);
  if (load_.pages > load_.page_count) {
    const int last = DemandCurve::step_below(load_.most_scale);
    step = std::min(std::max(step, now + 1), curve.coarsest_step(last) + kMargin);
    scale_ = std::max(scale_, std::min(DemandCurve::scale_at(step), load_.most_scale));
  } else {
    if (curve.detail_pages(0) * correction <= room) step = 0;
    if (too_small_ >= 1) step = std::max(step, DemandCurve::step_below(too_small_) + 1);
    scale_ = std::min(scale_, DemandCurve::scale_at(step));
  }
  settled_ = scale_ == before;
  state_.next_error_scale = scale_;
  state_.pool_full = state_.pool_full || scale_ > 1;
}

}  // namespace karst::core
