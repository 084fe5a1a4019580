// SPDX-License-Identifier: MIT
// Which view uses which set of thresholds, from frame to frame.
#include "terrain/lod/threshold_sets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
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

// Where bounds and errors of a few patches change, all is made as it would be anew; the GPU gets the rows
// that are others, and few beside them.
TEST(ThresholdUpdates, AreAsIfAllWereMadeAnew) {
  test::LoadedParts parts(test::wide_world(kLevel));
  const Camera camera = test::camera_at({28, 14, 28}, 0);
  ViewRequest request;
  request.camera = &camera;
  request.lod.mode = LodMode::error;
  request.width_px = 1280;
  request.height_px = 720;
  Residency& residency = parts.residency;
  residency.begin_frame();
  ASSERT_TRUE(parts.select(request).ok());
  parts.generate();
  ThresholdSets& sets = const_cast<ThresholdSets&>(residency.thresholds());
  const int set = parts.view().threshold_set();
  while (!sets.take().halves.empty()) {
  }
  const World& world = parts.world;
  std::vector<std::uint16_t> errors(world.level_errors().values.begin(), world.level_errors().values.end());
  std::vector<PatchBounds> bounds(world.bounds().begin(), world.bounds().end());
  std::vector<PatchId> list(bounds.size());
  std::vector<PatchLod> anew(bounds.size());
  test::Random random{8};
  std::size_t spread = 0;
  for (int round = 0; round < 60; ++round) {
    const std::size_t changed = 1 + static_cast<std::size_t>(random.below(9));
    const auto first = static_cast<PatchId>(random.below(static_cast<int>(bounds.size() - changed)));
    for (std::size_t n = 0; n < changed; ++n) {
      list[n] = first + static_cast<PatchId>(n);
      bounds[list[n]].max[1] = static_cast<std::int16_t>(bounds[list[n]].max[1] + random.below(300) - 150);
      // Falls from level to level.
      const std::size_t row = list[n] * level_error_values(kLevel);
      auto error = static_cast<std::uint16_t>(random.below(4) == 0 ? 0 : random.below(3'000));
      for (int j = 0; j < kLevel - 1; ++j, error /= 3) errors[row + static_cast<std::size_t>(j)] = error;
    }
    SetThresholds job;
    job.surface = world.surface();
    job.bounds = bounds;
    job.errors = {kLevel, errors};
    const std::uint32_t before = sets.version(set);
    sets.update(job, list, changed, 0, residency.pool());
    EXPECT_NE(sets.version(set), before);
    const ThresholdSets::Key key = parts.view().threshold_key();
    job.scale = key.scale;
    job.morphing = key.morphing;
    job.max_level = key.top_level;
    job.lods = anew;
    job.run();
    for (PatchId p = 0; p < anew.size(); ++p)
      ASSERT_EQ(std::memcmp(&anew[p], &sets.lods(set)[p], sizeof(PatchLod)), 0) << round << " " << p;
    std::size_t rows = 0;
    for (MorphRows taken; !(taken = sets.take()).halves.empty();) {
      rows += taken.halves.size() / kMorphRow;
      for (std::size_t n = 0; n * kMorphRow < taken.halves.size(); ++n) {
        const auto row = static_cast<std::uint32_t>(taken.first_row - sets.first_row(set) + n);
        std::array<std::uint16_t, kMorphRow> made;
        make_morph_row(world.surface(), anew, residency.pool().row_at(row).patch, made);
        ASSERT_TRUE(std::equal(made.begin(), made.end(),
                               taken.halves.begin() + static_cast<std::ptrdiff_t>(n * kMorphRow)));
      }
    }
    EXPECT_LT(rows, residency.pool().row_end() / 2);
    spread += rows > 3 * changed ? 1 : 0;
  }
  EXPECT_GT(spread, 0u);
}

}  // namespace
}  // namespace karst::core
