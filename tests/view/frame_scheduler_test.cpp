// SPDX-License-Identifier: MIT
// When frames are drawn, without a clock.
#include "app/view/frame_scheduler.h"

#include <gtest/gtest.h>

#include "platform/frame_times.h"

namespace karst::app {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kRefresh = 16 * kMs;

TEST(FrameScheduler, DrawsWhatChangedOnce) {
  FrameScheduler s({});
  EXPECT_TRUE(s.due(0, true, kRefresh));
  EXPECT_FALSE(s.due(0, false, kRefresh));
  s.begin(0);
  EXPECT_FALSE(s.due(1000 * kMs, true, kRefresh));
  EXPECT_EQ(s.wake_at(true, kRefresh), FrameScheduler::kNever);  // sleeps
  s.changed();
  EXPECT_FALSE(s.due(kMs, true, kRefresh));
  EXPECT_EQ(s.wake_at(false, kRefresh), FrameScheduler::kNever);  // the display wakes it
  EXPECT_TRUE(s.due(s.wake_at(true, kRefresh), true, kRefresh));
}

TEST(FrameScheduler, MovingDrawsEveryRefreshAndNoMore) {
  FrameScheduler s({});
  s.set_moving(true);
  int frames = 0;
  for (std::int64_t now = 0; now < 1000 * kMs; now += kMs / 4) {
    if (!s.due(now, true, kRefresh)) continue;
    s.begin(now);
    ++frames;
  }
  EXPECT_GE(frames, 62);
  EXPECT_LE(frames, 70);
}

TEST(FrameScheduler, FixedStepsDoNotKnowTheClock) {
  FrameScheduler real({false, kRefresh});
  FrameScheduler fixed({true, kRefresh});
  for (const std::int64_t now : {0 * kMs, 100 * kMs, 1000 * kMs}) {
    real.begin(now);
    fixed.begin(now);
  }
  EXPECT_DOUBLE_EQ(real.time_s(), 1.0);
  EXPECT_DOUBLE_EQ(fixed.time_s(), 0.032);
}

TEST(FrameTimes, CountsMissedRefreshesOfFramesInARow) {
  FrameTimes times;
  const auto frame = [&](std::int64_t began, std::int64_t shown) {
    times.begin(began);
    times.queued();
    times.shown(shown, kRefresh);
  };
  frame(0, 16 * kMs);
  frame(17 * kMs, 32 * kMs);
  EXPECT_EQ(times.missed(), 0u);
  frame(33 * kMs, 80 * kMs);  // two refreshes showed the frame before
  EXPECT_EQ(times.missed(), 2u);
  frame(5000 * kMs, 5016 * kMs);  // nothing to draw in between: nothing missed
  EXPECT_EQ(times.missed(), 2u);
  EXPECT_EQ(times.latency_ms().count(), 4u);
  EXPECT_DOUBLE_EQ(times.latency_ms().most(), 47);
  EXPECT_DOUBLE_EQ(times.latency_ms().percentile(0.5), 16);
}

}  // namespace
}  // namespace karst::app
