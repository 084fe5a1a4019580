// SPDX-License-Identifier: MIT
#include "terrain/lod/demand_curve.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "terrain/resident/page_table.h"

namespace karst::core {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr std::uint32_t kOne = 127u << 23;  // 1.0f
constexpr int kStepShift = 23 - 4;          // sixteen steps a doubling
static_assert(DemandCurve::kStepsPerDoubling == 1 << (23 - kStepShift));

// A part of the pages that is left is worth no coarser picture.
constexpr std::uint32_t kWorthwhile = 16;

constexpr float kSteepest = 1.1547006f;  // morph.h: G
constexpr float kMorphStarts = 1.0f - kMorphShare;

// Below this scale a level is needed for what it removes itself; 0 where that is nothing.
float scale_of(const LevelErrors& errors, PatchId patch, int level, float apparent, float pixels) {
  const std::uint16_t error = errors.error(patch, level - 1);
  if (error == 0) return 0;
  if (error == kUnboundedError) return kInfinite;
  const float left = apparent - kSteepest / kMorphStarts * static_cast<float>(errors.reach(patch, level)) -
                     static_cast<float>(error);
  return left > 0 ? pixels * static_cast<float>(error) / left : kInfinite;
}

}  // namespace

float DemandCurve::scale_at(int step) {
  return std::bit_cast<float>(kOne + (static_cast<std::uint32_t>(step) << kStepShift));
}

int DemandCurve::step_below(float scale) {
  if (!(scale > 1.0f)) return 0;
  const std::uint32_t step = (std::bit_cast<std::uint32_t>(scale) - kOne) >> kStepShift;
  return static_cast<int>(std::min<std::uint32_t>(step, kSteps - 1));
}

void DemandCurve::add(const LevelErrors& errors, PatchId patch, const PatchLod& lod, float apparent,
                      float pixels, float weight, int top_level) {
  for (int level = 3; level <= std::min(top_level, errors.level); ++level) {
    float least = 0;
    float at = apparent;
    for (int finer = level; finer <= errors.level; ++finer) {
      least = std::max(least, scale_of(errors, patch, finer, at, pixels));
      at = at * kMorphStarts - 2.0f * lod.reach;
    }
    if (least <= 1.0f) continue;
    pages_[static_cast<std::size_t>(step_below(least * weight))] += slot_pages(level) - slot_pages(level - 1);
  }
}

void DemandCurve::finish() {
  for (std::size_t step = pages_.size() - 1; step > 0; --step) pages_[step - 1] += pages_[step];
}

int DemandCurve::coarsest_step(int last) const {
  const std::uint32_t left = detail_pages(last);
  int step = last;
  while (step > 0 && detail_pages(step - 1) <= left + left / kWorthwhile) --step;
  return step;
}

}  // namespace karst::core
