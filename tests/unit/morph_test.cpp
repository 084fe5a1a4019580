// SPDX-License-Identifier: MIT
// Thresholds, rows and the formulas of a morphing vertex, against their definitions in terrain/lod/morph.h.
#include "terrain/lod/morph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include "terrain/patch/gpu_vertex.h"
#include "tests/support/grid_surface.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

using test::Random;

constexpr double kSteepest = 1.1547005383792517;

Camera camera_with(double fov_y_deg, double aspect) {
  CameraSettings settings;
  settings.fov_y_deg = fov_y_deg;
  settings.aspect = aspect;
  Camera camera;
  EXPECT_TRUE(make_camera(settings, camera).ok());
  return camera;
}

glm::dvec3 direction(Random& random) {
  for (;;) {
    const glm::dvec3 d(random.unit() * 2 - 1, random.unit() * 2 - 1, random.unit() * 2 - 1);
    if (glm::length(d) > 0.1 && glm::length(d) < 1) return glm::normalize(d);
  }
}

// A grid of patches with made-up errors, from none to unbounded.
struct Made {
  GridSurface grid;
  std::vector<std::uint16_t> values;
  std::vector<PatchLod> lods;
  int level;

  Made(int level_, std::uint64_t seed) : grid(make_grid_surface(24, 24, 1.0, seed)), level(level_) {
    Random random{seed};
    for (std::size_t p = 0; p < grid.patches.size(); ++p) {
      double error = std::exp2(16.0 * random.unit()) - 1.0;
      double reach = 9000.0;
      std::array<std::uint16_t, 2 * kMaxLevel> row{};
      for (int j = 1; j < level; ++j) {
        row[static_cast<std::size_t>(j - 1)] = static_cast<std::uint16_t>(error);
        row[static_cast<std::size_t>(level + j - 2)] = static_cast<std::uint16_t>(reach);
        error *= random.unit();
        reach *= 0.6;
      }
      if (random.below(50) == 0) row[0] = kUnboundedError;
      values.insert(values.end(), row.begin(), row.begin() + 2 * (level - 1));
    }
    lods.resize(grid.patches.size());
  }

  LevelErrors errors() const { return {level, values}; }
  SetThresholds stage(const ErrorScale& scale) {
    SetThresholds set;
    set.scale = scale;
    set.surface = grid.surface();
    set.bounds = grid.bounds;
    set.errors = errors();
    set.lods = lods;
    return set;
  }
};

TEST(Morph, ApparentDistanceChangesByTwoOverRootThreeAStepAtMost) {
  Random random{1};
  double steepest = 0;
  for (int n = 0; n < 200'000; ++n) {
    const glm::vec3 forward(direction(random));
    const float least_cos2 = static_cast<float>(0.05 + 0.9 * random.unit());
    const glm::vec3 a(direction(random) * std::exp2(8 + 12 * random.unit()));
    const glm::vec3 b = a + glm::vec3(direction(random)) * static_cast<float>(random.unit()) * glm::length(a);
    const double change = std::abs(double{apparent_distance(a, forward, least_cos2)} -
                                   double{apparent_distance(b, forward, least_cos2)});
    const double step = glm::distance(glm::dvec3(a), glm::dvec3(b));
    ASSERT_LE(change, kSteepest * step + 1e-6 * glm::length(glm::dvec3(a)));
    if (step > 1) steepest = std::max(steepest, change / step);
  }
  EXPECT_GT(steepest, 1.1);
}

// Two points e apart, one of them in the picture: at most S e / (rho - e) pixels.
TEST(Morph, ApparentDistanceBoundsPixels) {
  Random random{2};
  double most = 0;
  for (int n = 0; n < 200'000; ++n) {
    const Camera camera = camera_with(15 + 100 * random.unit(), 0.4 + 2 * random.unit());
    const ErrorScale scale = make_error_scale(camera, 1, 720, 1.0);
    const double tan_y = 1 / camera.clip_from_view[1][1];
    const double tan_x = 1 / camera.clip_from_view[0][0];
    const double z = std::exp2(10 * random.unit());
    const glm::dvec3 seen(z * tan_x * (2 * random.unit() - 1), z * tan_y * (2 * random.unit() - 1), -z);
    const double rho = apparent_distance(glm::vec3(seen), {0, 0, -1}, scale.least_cos2);
    const double e = rho * 0.9 * random.unit();
    const glm::dvec3 other = seen + e * direction(random);
    ASSERT_LT(other.z, 0);
    const auto pixels = [&](glm::dvec3 p) { return glm::dvec2(p.x, p.y) * (double{scale.pixels} / -p.z); };
    const double bound = scale.pixels * e / (rho - e);
    const double px = glm::distance(pixels(seen), pixels(other));
    ASSERT_LE(px, bound * (1 + 1e-5));
    most = std::max(most, px / bound);
  }
  EXPECT_GT(most, 0.95);
}

TEST(Morph, SharesBeginAndEndExactly) {
  Random random{3};
  for (int n = 0; n < 100'000; ++n) {
    const float threshold = static_cast<float>(std::exp2(5 + 25 * random.unit()));
    ASSERT_EQ(morph_share(threshold * (1 + 0x1p-18f), threshold), 1.0f);
    ASSERT_EQ(morph_share(threshold * 0.7f * (1 - 0x1p-18f), threshold), 0.0f);
    const double apparent = threshold * (0.6 + 0.5 * random.unit());
    const double expected = std::clamp((apparent / threshold - 0.7) / 0.3, 0.0, 1.0);
    ASSERT_NEAR(morph_share(static_cast<float>(apparent), threshold), expected, 1e-5);
  }
  // Without an error a vertex has always arrived, and is never asked to move by nothing times infinity.
  EXPECT_EQ(morph_share(1.0f, 0.0f), 1.0f);
  EXPECT_EQ(morph_share(0.0f, 0.0f), 0.0f);
  EXPECT_EQ(morph_share(1e10f, threshold_steps(kNeverMorphs)), 0.0f);
}

TEST(Morph, EntriesNameLevelAndClass) {
  for (int level = 1; level <= kMaxLevel; ++level) {
    std::vector<std::uint8_t> entries(static_cast<std::size_t>(patch_vertices(level)), 99);
    ASSERT_TRUE(build_morph_entries(level, entries).ok());
    const int n = patch_cells(level);
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i) {
        int m = level;
        while (m > 1 && i % (1 << (level - m + 1)) == 0 && j % (1 << (level - m + 1)) == 0) --m;
        const int entry = entries[static_cast<std::size_t>(vertex_order(level, i, j))];
        if (m == 1) {
          EXPECT_EQ(entry, 0);
          continue;
        }
        EXPECT_EQ((entry - 1) / kMorphClasses + 2, m);
        const int expected = j == 0 ? 1 : i == n ? 2 : j == n ? 3 : i == 0 ? 4 : 0;
        EXPECT_EQ((entry - 1) % kMorphClasses, expected);
      }
    }
    // A finer level's table begins with it.
    if (level == kMaxLevel) continue;
    std::vector<std::uint8_t> finer(static_cast<std::size_t>(patch_vertices(level + 1)));
    ASSERT_TRUE(build_morph_entries(level + 1, finer).ok());
    EXPECT_TRUE(std::equal(entries.begin(), entries.end(), finer.begin()));
  }
  std::vector<std::uint8_t> room(8);
  EXPECT_STREQ(build_morph_entries(1, room).field(), "out");
  EXPECT_STREQ(build_morph_entries(0, room).field(), "level");
  EXPECT_STREQ(build_morph_entries(kMaxLevel + 1, room).field(), "level");
}

double threshold_of(const PatchLod& lod, int m) {
  return threshold_steps(lod.threshold[m]);
}

// (1) and (2) of morph.h in double, and nothing much beyond them.
TEST(Morph, ThresholdsHoldWhatTheBoundNeeds) {
  Random random{4};
  for (int round = 0; round < 60; ++round) {
    Made made(2 + round % 5, static_cast<std::uint64_t>(round));
    const Camera camera = camera_with(20 + 100 * random.unit(), 0.4 + 2 * random.unit());
    const double error_px = std::exp2(8 * random.unit() - 3);
    const int height_px = 200 + random.below(2000);
    const ErrorScale scale = make_error_scale(camera, 1, height_px, error_px);
    const double pixels = 0.5 * height_px * camera.clip_from_view[1][1];
    const SetThresholds set = made.stage(scale);
    ASSERT_TRUE(set.validate().ok());
    set.run();
    for (PatchId p = 0; p < made.lods.size(); ++p) {
      const PatchLod& lod = made.lods[p];
      const PatchBounds& b = made.grid.bounds[p];
      const double diagonal =
          glm::length(glm::dvec3(b.max[0] - b.min[0], b.max[1] - b.min[1], b.max[2] - b.min[2]));
      ASSERT_GE(2 * lod.reach, kSteepest * diagonal);
      for (int m = 2; m <= made.level; ++m) {
        const double d = threshold_of(lod, m);
        const std::uint16_t error = made.errors().error(p, m - 1);
        double least = 0;
        if (error == kUnboundedError) {
          least = threshold_steps(kNeverMorphs);
        } else if (error > 0) {
          least = (pixels / error_px + 1) * error +
                  kSteepest * made.errors().reach(p, m) / (1 - double{kMorphShare});
        }
        for (int e = -1; e < 4 && m < made.level; ++e) {
          const PatchEdge other = e < 0 ? PatchEdge::make(p, 0) : made.grid.patches[p].neighbour[e];
          if (!other.exists() || threshold_of(made.lods[other.patch()], m + 1) == 0) continue;
          const PatchLod& finer = made.lods[other.patch()];
          least = std::max(least, (threshold_of(finer, m + 1) + 2 * finer.reach) / (1 - double{kMorphShare}));
        }
        least = std::min<double>(least, threshold_steps(kNeverMorphs));
        ASSERT_GE(d, least);
        // The target also pays for rounding, and thresholds are rounded up.
        const double paid = scale.steps_per_step / (pixels / error_px + 1);
        ASSERT_LE(d, least * paid * 1.01 + 40) << "level " << m;
        if (least == 0) {
          ASSERT_EQ(d, 0);
        }
      }
      for (int m = made.level + 1; m < 8; ++m) ASSERT_EQ(lod.threshold[m], 0);
    }
  }
}

TEST(Morph, LevelsAreThoseOfTheThresholds) {
  Random random{5};
  Made made(6, 6);
  made.stage(make_error_scale(camera_with(60, 1.5), 1080, 720, 4.0)).run();
  for (int n = 0; n < 200'000; ++n) {
    const PatchLod& lod =
        made.lods[static_cast<std::size_t>(random.below(static_cast<int>(made.lods.size())))];
    float distance = static_cast<float>(std::exp2(30 * random.unit()) - 100);
    if (n % 3 == 0) {  // at a threshold, and one float beside it
      distance = threshold_steps(lod.threshold[2 + random.below(5)]);
      if (n % 2 == 0) distance = std::nextafter(distance, n % 4 == 0 ? 0.0f : 1e30f);
    }
    int level = 1;
    for (int m = 2; m <= kMaxLevel; ++m) {
      if (std::max(distance, 0.0f) < threshold_steps(lod.threshold[m])) level = m;
    }
    ASSERT_EQ(level_at(lod, distance), level) << distance;
  }
}

// An eye inside of a patch's reach: the distance is below 0, by however little, and nothing has arrived.
TEST(Morph, LevelsOfDistancesBelowZeroAreTheFinest) {
  Made made(6, 6);
  made.stage(make_error_scale(camera_with(60, 1.5), 1080, 720, 4.0)).run();
  for (const PatchLod& lod : made.lods) {
    const int finest = level_at(lod, 0.0f);
    for (const float distance : {-0.0f, -1e-45f, -1e-30f, -1e-6f, -1.0f, -1e10f, -1e38f, -HUGE_VALF}) {
      ASSERT_EQ(level_at(lod, distance), finest) << distance;
    }
  }
}

TEST(Morph, MaxLevelAndNoMorphing) {
  Made made(5, 7);
  const ErrorScale scale = make_error_scale(camera_with(60, 1.5), 1080, 720, 1.0);
  SetThresholds set = made.stage(scale);
  set.run();
  const std::vector<PatchLod> all = made.lods;
  set.max_level = 3;
  set.run();
  for (std::size_t p = 0; p < all.size(); ++p) {
    for (int m = 2; m < 8; ++m) ASSERT_EQ(made.lods[p].threshold[m], m <= 3 ? all[p].threshold[m] : 0);
  }
  set.morphing = false;
  set.run();
  for (const PatchLod& lod : made.lods) {
    for (int m = 2; m < 8; ++m) ASSERT_EQ(lod.threshold[m], m <= 3 ? kNeverMorphs : 0);
    ASSERT_EQ(level_at(lod, 1e10f), 3);
  }
}

TEST(Morph, RowsTakeTheSmallerThresholdOnEdges) {
  Made made(6, 8);
  made.stage(make_error_scale(camera_with(60, 1.5), 1080, 720, 1.0)).run();
  for (PatchId p = 0; p < made.lods.size(); ++p) {
    std::array<std::uint16_t, kMorphRow> row;
    row.fill(77);
    make_morph_row(made.grid.surface(), made.lods, p, row);
    EXPECT_EQ(row[0], kNeverMorphs);
    for (int m = 2; m <= kMaxLevel; ++m) {
      const std::uint16_t own = made.lods[p].threshold[m];
      EXPECT_EQ(row[static_cast<std::size_t>(morph_entry(m, 0))], own);
      for (int e = 0; e < 4; ++e) {
        const PatchEdge other = made.grid.patches[p].neighbour[e];
        const std::uint16_t theirs = other.exists() ? made.lods[other.patch()].threshold[m] : own;
        EXPECT_EQ(row[static_cast<std::size_t>(morph_entry(m, morph_class_edge(e)))], std::min(own, theirs));
      }
    }
    for (std::size_t n = 26; n < kMorphRow; ++n) EXPECT_EQ(row[n], 0);
  }
}

// A target that rounding alone uses up leaves nothing to save.
TEST(Morph, TinyTargetsDrawEverything) {
  Made made(4, 9);
  const ErrorScale scale = make_error_scale(camera_with(60, 1.5), 65'536, 65'536, 0.01);
  made.stage(scale).run();
  EXPECT_EQ(scale.steps_per_step, std::numeric_limits<float>::infinity());
  for (PatchId p = 0; p < made.lods.size(); ++p) {
    const int finest = made.errors().error(p, 3) > 0 ? 4 : 0;
    if (finest != 0) {
      EXPECT_EQ(level_at(made.lods[p], 1e10f), finest);
    }
  }
}

TEST(Morph, RefusesOneWrongFieldAtATime) {
  Made made(4, 10);
  const ErrorScale scale = make_error_scale(camera_with(60, 1.5), 1080, 720, 1.0);
  const std::vector<std::pair<const char*, std::function<void(SetThresholds&)>>> cases = {
      {"scale", [](SetThresholds& s) { s.scale = {}; }},
      {"scale", [](SetThresholds& s) { s.scale.least_cos2 = 0; }},
      {"scale", [](SetThresholds& s) { s.scale.steps_per_step = std::numeric_limits<float>::quiet_NaN(); }},
      {"max_level", [](SetThresholds& s) { s.max_level = 0; }},
      {"max_level", [](SetThresholds& s) { s.max_level = kMaxLevel + 1; }},
      {"bounds", [](SetThresholds& s) { s.bounds = s.bounds.first(3); }},
      {"errors", [](SetThresholds& s) { s.errors.level = 0; }},
      {"errors", [](SetThresholds& s) { s.errors.values = s.errors.values.first(3); }},
      {"lods", [](SetThresholds& s) { s.lods = s.lods.first(3); }},
  };
  for (const auto& [field, break_it] : cases) {
    SetThresholds set = made.stage(scale);
    ASSERT_TRUE(set.validate().ok());
    break_it(set);
    EXPECT_EQ(set.validate().code(), StatusCode::invalid_argument) << field;
    EXPECT_STREQ(set.validate().field(), field);
  }
}

}  // namespace
}  // namespace karst::core
