// SPDX-License-Identifier: MIT
// Quick bounds hold what is measured: boxes, errors and reaches, of patches of all cases with any heights.
#include "terrain/measure/bounds/quick_bounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "terrain/measure/level_error.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

void expect_held(const Surface& surface, const Heights& heights) {
  std::vector<std::byte> memory(patch_scratch_bytes() + 64);
  void* place = memory.data();
  std::size_t room = memory.size();
  std::align(64, patch_scratch_bytes(), place, room);
  GenerateVertices generate;
  generate.surface = surface;
  generate.heights = heights;
  generate.level = heights.level;
  generate.scratch = make_patch_scratch({static_cast<std::byte*>(place), patch_scratch_bytes()});
  const std::size_t values = level_error_values(heights.level);
  for (PatchId patch = 0; patch < surface.patches.size(); ++patch) {
    const PatchBounds exact = generate.bounds(patch);
    const QuickBounds quick = quick_bounds(surface, heights, patch);
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_LE(quick.box.min[axis], exact.min[axis]) << patch;
      ASSERT_GE(quick.box.max[axis], exact.max[axis]) << patch;
    }
    OwnErrors bound{}, measured{};
    bound_own_errors(heights.level, quick.ways, quick.box, bound, quick.apart);
    measure_own_errors(surface, heights, patch, measured.borders, std::span(measured.values).first(values));
    for (std::size_t n = 0; n < values; ++n) ASSERT_GE(bound.values[n], measured.values[n]) << patch;
    for (int e = 0; e < 4; ++e) {
      for (int m = 0; m < heights.level - 1; ++m) {
        ASSERT_GE(bound.borders.error[e][m], measured.borders.error[e][m]) << patch;
        ASSERT_GE(bound.borders.reach[e][m], measured.borders.reach[e][m]) << patch;
      }
    }
    // Of what has no heights the ways of the surface alone hold.
    MorphWays ways;
    static_cast<void>(generate.bounds(patch, ways));
    if (surface.patches[patch].height_block != kNoHeights) continue;
    for (int m = 2; m <= heights.level; ++m) ASSERT_GE(quick.ways.longest[m], ways.longest[m]) << patch;
  }
}

TEST(QuickBounds, HoldWhatIsMeasured) {
  test::Random random{7};
  for (const int level : {2, 3, 5}) {
    for (int round = 0; round < 3; ++round) {
      const double sparse = 0.2 + 0.3 * round;
      test::TestWorld world({9, 8, 10}, [&](glm::ivec3) { return random.unit() < sparse; });
      ASSERT_GT(world.surface().patches.size(), 300u);
      expect_held(world.surface(), {level, {}});
      for (const int most : {60, 1'500, kMaxHeight}) {
        world.roughen(level, static_cast<std::uint32_t>(round), most);
        expect_held(world.surface(), world.heights());
      }
    }
  }
}

}  // namespace
}  // namespace karst::core
