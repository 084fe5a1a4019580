// SPDX-License-Identifier: MIT
// The curve of demand against what views really take, and the governor's decisions.
#include "terrain/lod/governor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "tests/support/hilly_world.h"
#include "tests/support/loaded_parts.h"

namespace karst::core {
namespace {

TEST(DemandCurve, StepsAreScales) {
  EXPECT_EQ(DemandCurve::scale_at(0), 1.0f);
  EXPECT_EQ(DemandCurve::scale_at(DemandCurve::kStepsPerDoubling), 2.0f);
  for (int step = 0; step < DemandCurve::kSteps; ++step) {
    EXPECT_EQ(DemandCurve::step_below(DemandCurve::scale_at(step)), step);
    const float less = DemandCurve::scale_at(step) * 0.9999f;
    EXPECT_EQ(DemandCurve::step_below(less), std::max(step - 1, 0));
  }
  EXPECT_EQ(DemandCurve::step_below(0.0f), 0);
  EXPECT_EQ(DemandCurve::step_below(1e30f), DemandCurve::kSteps - 1);
}

// Pages that a view takes at an error, beyond one a patch in view; and the curve of it at another error.
TEST(DemandCurve, SaysWhatLargerErrorsTake) {
  const test::TestWorld shape = test::wide_world();
  test::LoadedParts parts(shape, 1u << 20);
  const Camera camera = test::camera_at({28, 9, 58}, 0, 60, -25);
  ViewRequest request;
  request.camera = &camera;
  request.occlusion_culling = false;
  const auto take = [&](double error_px) {
    request.lod.error_px = error_px;
    parts.residency.begin_frame();
    EXPECT_TRUE(parts.select(request).ok());
    parts.generate();
    EXPECT_TRUE(parts.select(request).ok());
    std::uint32_t pages = 0;
    for (const DrawItem& item : parts.view().items()) pages += slot_pages(item.level) - 1;
    return pages;
  };
  take(0.25);
  DemandCurve curve;
  const std::span<const PatchLod> lods = parts.residency.thresholds().lods(0);
  for (const DrawItem& item : parts.view().items()) {
    curve.add(parts.world.level_errors(), item.patch, lods[item.patch],
              least_apparent_distance(lods[item.patch], parts.view().eye()),
              static_cast<float>(double{parts.view().error_scale().pixels} / 0.25), 1, 4);
  }
  curve.finish();
  for (int step = 1; step < DemandCurve::kSteps; ++step) {
    ASSERT_LE(curve.detail_pages(step), curve.detail_pages(step - 1));
  }
  for (const int doublings : {0, 1, 2, 3, 4}) {
    const double taken = take(0.25 * (1 << doublings));
    const double said = curve.detail_pages(doublings * DemandCurve::kStepsPerDoubling);
    std::printf("%g px: %g pages for detail, %g estimated\n", 0.25 * (1 << doublings), taken, said);
    EXPECT_GT(taken, 50);
    EXPECT_GT(said, taken * 0.5) << doublings;
    EXPECT_LT(said, taken * 1.1) << doublings;
  }
  const int coarsest = curve.coarsest_step(DemandCurve::kSteps - 1);
  EXPECT_GT(coarsest, 4 * DemandCurve::kStepsPerDoubling);
  EXPECT_LE(curve.detail_pages(coarsest), curve.detail_pages(DemandCurve::kSteps - 1) * 17 / 16);
}

TEST(Governor, LeavesViewsThatFitAlone) {
  Governor governor;
  EXPECT_FALSE(
      governor.note({.pages = 100, .base = 10, .page_count = 100, .most_scale = 100, .morphing = true}));
  EXPECT_EQ(governor.scale(), 1.0f);
  EXPECT_FALSE(governor.state().pool_full);
  EXPECT_EQ(governor.state().wanted_pages, 100u);
}

// Levels that do not depend on an error are not changed by one.
TEST(Governor, SaysThatThePoolIsFullWhereItCannotHelp) {
  Governor governor;
  EXPECT_FALSE(governor.note({.pages = 101, .base = 10, .page_count = 100, .most_scale = 100}));
  EXPECT_TRUE(governor.state().pool_full);
  EXPECT_EQ(governor.scale(), 1.0f);
}

// An estimate that is too low by much, and eyes that stand still: what was too small once is not tried again.
TEST(Governor, SettlesWhereEstimatesAreWrong) {
  // Five patches that are needed at level 3 up to a scale of 16 or so: 10 pages.
  const std::uint16_t values[] = {100, 100, 0,   0,   100, 100, 0,   0,   100, 100,
                                  0,   0,   100, 100, 0,   0,   100, 100, 0,   0};
  DemandCurve curve;
  for (PatchId p = 0; p < 5; ++p) curve.add({3, values}, p, {}, 10'100, 1600, 1, 3);
  curve.finish();
  EXPECT_EQ(curve.detail_pages(0), 10u);
  EXPECT_EQ(curve.detail_pages(DemandCurve::step_below(17)), 0u);
  Governor governor;
  float last = 0;
  int changes = 0;
  for (int n = 0; n < 200; ++n) {
    // In truth 20 pages are taken below a scale of 8, and 5 from there on; there is room for 15.
    const std::uint32_t detail = governor.scale() < 8 ? 20 : 5;
    const Governor::Load load{.pages = 10 + detail,
                              .base = 10,
                              .page_count = 25,
                              .most_scale = 1000,
                              .still = n > 0,
                              .morphing = true};
    if (governor.note(load)) governor.adjust(curve);
    changes += n > 100 && governor.scale() != last ? 1 : 0;
    last = governor.scale();
  }
  EXPECT_EQ(changes, 0);
  EXPECT_GE(last, 8.0f);
  EXPECT_LT(last, 9.0f);
  // Other eyes may try.
  governor.note({.pages = 15, .base = 10, .page_count = 25, .most_scale = 1000, .morphing = true});
  governor.adjust(curve);
  EXPECT_EQ(governor.scale(), 1.0f);
}

TEST(Governor, StopsAtTheScaleBeyondWhichNoErrorGrows) {
  Governor governor;
  DemandCurve nothing;
  nothing.finish();
  for (int n = 0; n < 100; ++n) {
    const Governor::Load load{
        .pages = 500, .base = 10, .page_count = 100, .most_scale = 1.5f, .morphing = true};
    if (governor.note(load)) governor.adjust(nothing);
  }
  EXPECT_EQ(governor.scale(), 1.5f);
  EXPECT_TRUE(governor.state().pool_full);
}

}  // namespace
}  // namespace karst::core
