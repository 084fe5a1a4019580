// SPDX-License-Identifier: MIT
// Which view uses which set of thresholds, from frame to frame.
#include "terrain/lod/threshold_sets.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "tests/support/hilly_world.h"
#include "tests/support/loaded_parts.h"

namespace karst::core {
namespace {

constexpr int kLevel = 3;

class ThresholdSetsTest : public testing::Test {
 protected:
  ThresholdSetsTest()
      : shape_(test::hilly_world(kLevel)), errors_(shape_.level_errors()), bounds_(shape_.bounds()) {
    Config config = World::config_for(shape_.info(), kLevel);
    config.max_views = 3;
    Budget budget;
    ThresholdSets::add_to(budget, config);
    memory_.emplace(budget.cpu_bytes());
    Arena arena(memory_->bytes());
    EXPECT_TRUE(sets_.create(config, arena).ok());
    EXPECT_EQ(arena.used(), budget.cpu_bytes());
  }

  static ThresholdSets::Key key(double error_px) {
    const Camera camera = test::camera_at({10, 10, 10}, 0);
    return {make_error_scale(camera, 1280, 720, error_px), true, kLevel};
  }

  // A frame of views with these errors: which set each has.
  std::vector<int> frame(const std::vector<double>& errors_px) {
    std::vector<ThresholdSets::Key> keys;
    for (const double px : errors_px) keys.push_back(key(px));
    std::vector<int> sets = last_;
    sets.resize(keys.size(), -1);
    sets_.assign(keys, sets, ++frame_);
    for (std::size_t v = 0; v < keys.size(); ++v) {
      SetThresholds job;
      job.scale = keys[v].scale;
      job.morphing = keys[v].morphing;
      job.max_level = keys[v].top_level;
      job.surface = shape_.surface();
      job.bounds = bounds_;
      job.errors = {kLevel, errors_};
      EXPECT_TRUE(sets_.fill(sets[v], job, pool_).ok());
    }
    last_ = sets;
    return sets;
  }

  test::TestWorld shape_;
  std::vector<std::uint16_t> errors_;
  std::vector<PatchBounds> bounds_;
  std::optional<test::AlignedBytes> memory_;
  ThresholdSets sets_;
  ResidentPool pool_;  // holds nothing
  std::vector<int> last_;
  std::uint32_t frame_ = 0;
};

TEST_F(ThresholdSetsTest, ViewsThatAgreeShareASet) {
  EXPECT_EQ(frame({1, 1, 1}), (std::vector<int>{0, 0, 0}));
  EXPECT_EQ(frame({1, 2, 1}), (std::vector<int>{0, 1, 0}));
  EXPECT_EQ(frame({1, 2, 2}), (std::vector<int>{0, 1, 1}));
}

TEST_F(ThresholdSetsTest, AViewKeepsItsSetWhenItsThresholdsChange) {
  EXPECT_EQ(frame({1, 2, 3}), (std::vector<int>{0, 1, 2}));
  // As the governor does it: all at a time; and views that change places.
  EXPECT_EQ(frame({1.1, 2.2, 3.3}), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(frame({1.2, 2.4, 3.6}), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(frame({2.4, 1.2, 3.6}), (std::vector<int>{1, 0, 2}));
  EXPECT_EQ(frame({5, 6, 3.6}), (std::vector<int>{1, 0, 2}));
}

TEST_F(ThresholdSetsTest, VersionsAreThoseOfContents) {
  frame({1, 2});
  const std::uint32_t first = sets_.version(0);
  const std::uint32_t second = sets_.version(1);
  EXPECT_NE(first, second);
  frame({1, 2});
  EXPECT_EQ(sets_.version(0), first);
  EXPECT_EQ(sets_.version(1), second);
  frame({1, 3});
  EXPECT_EQ(sets_.version(0), first);
  EXPECT_GT(sets_.version(1), second);
  EXPECT_FLOAT_EQ(static_cast<float>(sets_.lods(1).size()), static_cast<float>(shape_.info().patches));
}

// What nobody has used for a while is not kept up to date any more, and not taken for valid either.
TEST_F(ThresholdSetsTest, UnusedSetsAreGivenUp) {
  frame({1, 2});
  const std::uint32_t before = sets_.version(1);
  const int second = last_[1];
  for (std::uint32_t n = 0; n <= ThresholdSets::kIdleFrames; ++n) frame({1});
  EXPECT_EQ(sets_.version(1), 0u);
  last_.push_back(second);
  EXPECT_EQ(frame({1, 2})[1], second);
  EXPECT_GT(sets_.version(1), before);
}

}  // namespace
}  // namespace karst::core
