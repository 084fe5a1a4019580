// SPDX-License-Identifier: MIT
// Heights of patches that an edit of voxels made: inside they are what their borders blend to.
#include "terrain/edit/shape/new_heights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "terrain/surface/patch_key.h"
#include "tests/support/edited_world.h"

namespace karst::core {
namespace {

// n^2 times the Coons patch of its borders (NewHeights).
std::int64_t blend(std::span<const std::int16_t> heights, int level, std::int64_t i, std::int64_t j) {
  const std::int64_t n = patch_cells(level);
  const auto at = [&](std::int64_t x, std::int64_t y) {
    return std::int64_t{heights[static_cast<std::size_t>(y * (n + 1) + x)]};
  };
  const std::int64_t across = n * (at(0, j) * (n - i) + at(n, j) * i);
  const std::int64_t along = n * (at(i, 0) * (n - j) + at(i, n) * j);
  return across + along -
         (at(0, 0) * (n - i) * (n - j) + at(n, 0) * i * (n - j) + at(0, n) * (n - i) * j + at(n, n) * i * j);
}

TEST(NewHeights, AreBlendedFromTheirBorders) {
  test::Random random{6};
  std::size_t looked = 0, up = 0, down = 0;
  for (int level = 1; level <= kMaxLevel; ++level) {
    test::TestWorld shape =
        test::TestWorld::noise(40 + static_cast<std::uint64_t>(level), {12, 9, 11}, 0.45, 5.0, false);
    shape.roughen(level, 9, 3'000);
    test::LoadedWorld live(shape.file(), 2'000);
    const World& world = live.world;
    const auto keys = [&] {
      std::set<std::uint64_t> all;
      for (PatchId p = 0; p < world.surface().patches.size(); ++p) {
        if (!world.is_free(p)) all.insert(key_of(world.surface(), p).bits());
      }
      return all;
    };
    for (int edit = 0; edit < 6; ++edit) {
      const std::set<std::uint64_t> before = keys();
      EditChange change;
      const Edit made = test::random_voxel_edit(random, world.info().extent, world.octree().depth());
      ASSERT_TRUE(edit_shape(live.world, made, change).ok());
      for (PatchId p = 0; p < world.surface().patches.size(); ++p) {
        if (world.is_free(p) || before.contains(key_of(world.surface(), p).bits())) continue;
        const std::uint32_t block = world.surface().patches[p].height_block;
        if (block == kNoHeights) continue;
        const std::span<const std::int16_t> own(world.heights().block(block),
                                                static_cast<std::size_t>(patch_vertices(level)));
        ++looked;
        const std::int64_t n = patch_cells(level);
        for (std::int64_t j = 1; j < n; ++j) {
          for (std::int64_t i = 1; i < n; ++i) {
            const std::int64_t sum = blend(own, level, i, j);
            const std::int64_t size = (std::abs(sum) + n * n / 2) / (n * n);
            const std::int64_t height = sum < 0 ? -size : size;
            up += height > 0;
            down += height < 0;
            ASSERT_EQ(own[static_cast<std::size_t>(j * (n + 1) + i)],
                      std::clamp<std::int64_t>(height, -kMaxHeight, kMaxHeight))
                << "level " << level << " patch " << p << " at " << i << ", " << j;
          }
        }
      }
    }
  }
  EXPECT_GT(looked, 100u);
  EXPECT_GT(up, 1'000u);
  EXPECT_GT(down, 1'000u);
}

}  // namespace
}  // namespace karst::core
