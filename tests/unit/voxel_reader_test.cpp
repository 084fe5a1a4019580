// SPDX-License-Identifier: MIT
#include "terrain/field/voxel_reader.h"

#include "terrain/field/voxelize.h"
#include "tests/support/tree_memory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace karst::core {
namespace {

// The world side rule, from the octree's own look-up.
bool expected(const Octree& tree, glm::ivec3 extent, glm::ivec3 v) {
  if (v.y < 0) return true;
  if (v.y >= extent.y) return false;
  return tree.filled({std::clamp(v.x, 0, extent.x - 1), v.y, std::clamp(v.z, 0, extent.z - 1)});
}

TEST(VoxelReader, RowsAndSingleVoxelsFollowTheSideRule) {
  TestRandom random(11);
  for (int round = 0; round < 12; ++round) {
    const int depth = random.range(1, 6);
    const int size = 1 << depth;
    const glm::ivec3 extent(random.range(1, size), random.range(1, size), random.range(1, size));
    TreeMemory memory(depth);
    const double filled_share = random.chance(0.3) ? 0.5 : random.chance(0.5) ? 0.02 : 0.98;
    const auto noise = [&](glm::ivec3, bool) { return random.chance(filled_share); };
    ASSERT_TRUE((VoxelizePredicate{extent, VoxelFunction(noise)}.run(memory.tree).ok()));
    const VoxelReader reader(memory.tree, extent);
    for (int i = 0; i < 4000; ++i) {
      const glm::ivec3 v(random.range(-40, size + 40), random.range(-3, size + 3),
                         random.range(-3, size + 3));
      const int count = random.range(0, 32);
      std::uint32_t bits = 0;
      for (int k = 0; k < count; ++k) {
        const bool filled = expected(memory.tree, extent, {v.x + k, v.y, v.z});
        bits |= (filled ? 1u : 0u) << k;
      }
      ASSERT_EQ(reader.read_row(v.x, v.y, v.z, count), bits)
          << v.x << " " << v.y << " " << v.z << " count " << count << " extent " << extent.x;
      ASSERT_EQ(reader.filled(v), expected(memory.tree, extent, v));
    }
  }
}

TEST(VoxelReader, BeyondTheSidesLiesTheirMirror) {
  TestRandom random(12);
  for (int round = 0; round < 12; ++round) {
    const int depth = random.range(3, 6);
    const int size = 1 << depth;
    const glm::ivec3 extent(random.range(7, size), random.range(1, size), random.range(7, size));
    TreeMemory memory(depth);
    const auto noise = [&](glm::ivec3, bool) { return random.chance(0.5); };
    ASSERT_TRUE((VoxelizePredicate{extent, VoxelFunction(noise)}.run(memory.tree).ok()));
    const VoxelReader reader(memory.tree, extent, true);
    const auto mirrored = [](int v, int most) { return v < 0 ? -v : v > most ? 2 * most - v : v; };
    for (int i = 0; i < 4000; ++i) {
      const int count = random.range(0, 7);
      const glm::ivec3 v(random.range(-6, extent.x + 5 - count), random.range(-3, size + 3),
                         random.range(-6, extent.z + 5));
      std::uint32_t bits = 0;
      for (int k = 0; k < count; ++k) {
        const glm::ivec3 m(mirrored(v.x + k, extent.x - 1), v.y, mirrored(v.z, extent.z - 1));
        const bool filled = expected(memory.tree, extent, m);
        bits |= (filled ? 1u : 0u) << k;
        ASSERT_EQ(reader.filled({v.x + k, v.y, v.z}), filled);
      }
      ASSERT_EQ(reader.read_row(v.x, v.y, v.z, count), bits)
          << v.x << " " << v.y << " " << v.z << " count " << count << " extent " << extent.x;
    }
  }
}

TEST(VoxelReader, ExtremePositions) {
  TreeMemory memory(3);
  ASSERT_TRUE(memory.tree.set({7, 0, 0}, 3, true).ok());
  const VoxelReader reader(memory.tree, {8, 7, 8});
  const int low = std::numeric_limits<int>::min();
  const int high = std::numeric_limits<int>::max();
  EXPECT_EQ(reader.read_row(high, 0, 0, 32), 0xffffffffu);
  EXPECT_EQ(reader.read_row(low, 0, 0, 32), 0u);
  EXPECT_EQ(reader.read_row(high, 0, high, 32), 0u);
  EXPECT_EQ(reader.read_row(0, low, 0, 32), 0xffffffffu);
  EXPECT_EQ(reader.read_row(0, high, 0, 32), 0u);
  EXPECT_EQ(reader.read_row(0, low, 0, 0), 0u);
  const VoxelReader mirror(memory.tree, {8, 7, 8}, true);
  for (const int x : {low, high, -100, 100}) {
    EXPECT_EQ(mirror.read_row(x, low, x, 32), 0xffffffffu);
    EXPECT_EQ(mirror.read_row(x, high, x, 32), 0u);
    EXPECT_EQ(mirror.read_row(x, 5, x, 32), 0u);
    EXPECT_FALSE(mirror.filled({x, 5, x}));
  }
  EXPECT_EQ(reader.read_row(4, 0, 0, 99), 0xfffffff8u) << "more than a row holds is cut";
  EXPECT_TRUE(reader.filled({high, 0, low}));
  EXPECT_FALSE(reader.filled({low, 0, low}));
}

}  // namespace
}  // namespace karst::core
