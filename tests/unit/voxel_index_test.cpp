// SPDX-License-Identifier: MIT
#include "terrain/field/voxel_index.h"

#include "tests/support/tree_memory.h"

#include <gtest/gtest.h>

#include <set>

namespace karst::core {
namespace {

// All of it works at compile time.
static_assert(VoxelIndex().bits() == 0);
static_assert(VoxelIndex(15, 0, 0, 0, false).bits() == 0xf0000000u);
static_assert(VoxelIndex(9, 0x1ff, 0, 0, false).bits() == (9u << 28 | 0x1ffu << 19));
static_assert(VoxelIndex(9, 0, 0x1ff, 0, false).bits() == (9u << 28 | 0x1ffu << 10));
static_assert(VoxelIndex(9, 0, 0, 0x1ff, false).bits() == (9u << 28 | 0x1ffu << 1));
static_assert(VoxelIndex(0, 0x1ff, 0x1ff, 0x1ff, true).bits() == 1);
static_assert(VoxelIndex().child(7).parent() == VoxelIndex());

// K figure 3.2: at level 1 the first bit of each field says which half, the other eight mean nothing.
TEST(VoxelIndex, LevelOneAsInFigure32) {
  for (int octant = 0; octant < 8; ++octant) {
    const VoxelIndex child = VoxelIndex().child(octant);
    EXPECT_EQ(child.level(), 1);
    EXPECT_EQ(child.x(), octant & 1 ? 0b100000000u : 0u);
    EXPECT_EQ(child.y(), octant & 2 ? 0b100000000u : 0u);
    EXPECT_EQ(child.z(), octant & 4 ? 0b100000000u : 0u);
    EXPECT_EQ(child.octant(), octant);
    EXPECT_EQ(child.size(9), 256);
    EXPECT_EQ(child.min_corner(9), glm::ivec3(octant & 1, octant >> 1 & 1, octant >> 2) * 256);
  }
}

// K figure 3.3: level 2 uses two bits; four voxels a side.
TEST(VoxelIndex, LevelTwoAsInFigure33) {
  std::set<std::uint32_t> seen;
  for (int parent = 0; parent < 8; ++parent) {
    for (int octant = 0; octant < 8; ++octant) {
      const VoxelIndex v = VoxelIndex().child(parent).child(octant);
      EXPECT_EQ(v.level(), 2);
      EXPECT_EQ(v.x() & 0b001111111u, 0u);
      EXPECT_EQ(v.x() >> 7, static_cast<std::uint32_t>((parent & 1) * 2 + (octant & 1)));
      EXPECT_EQ(v.y() >> 7, static_cast<std::uint32_t>((parent >> 1 & 1) * 2 + (octant >> 1 & 1)));
      EXPECT_EQ(v.z() >> 7, static_cast<std::uint32_t>((parent >> 2) * 2 + (octant >> 2)));
      EXPECT_EQ(v.parent(), VoxelIndex().child(parent));
      seen.insert(v.bits());
    }
  }
  EXPECT_EQ(seen.size(), 64u);
}

// K figure 3.4 and equation 3.5: from the root's centre, half a voxel of each level to one side or the other.
TEST(VoxelIndex, PositionAsInFigure34) {
  TestRandom random(4);
  for (int round = 0; round < 2000; ++round) {
    const int depth = random.range(1, 9);
    const int level = random.range(0, depth);
    VoxelIndex v;
    glm::ivec3 twice_centre(1 << depth);  // the root's centre, in half voxels
    for (int l = 1; l <= level; ++l) {
      const int octant = random.range(0, 7);
      v = v.child(octant);
      const glm::ivec3 f(octant & 1, octant >> 1 & 1, octant >> 2);
      twice_centre += (2 * f - 1) * (1 << (depth - l));  // (f * 2 - 1) * s(l + 1), doubled
    }
    EXPECT_EQ(v.centre_half_voxels(depth), twice_centre);
    EXPECT_EQ(v.size(depth), 1 << (depth - level));
    EXPECT_EQ(2 * v.min_corner(depth) + v.size(depth), twice_centre);
  }
  // Level 3 of the figure's kind: x-index 011, y-index 101 of an octree of 8 voxels a side.
  const VoxelIndex v(3, 0b011000000, 0b101000000, 0, true);
  EXPECT_EQ(v.min_corner(3), glm::ivec3(3, 5, 0));
  EXPECT_EQ(v.centre_half_voxels(3), glm::ivec3(7, 11, 1));
}

TEST(VoxelIndex, OfFindsTheVoxelThatHoldsAPosition) {
  TestRandom random(5);
  for (int round = 0; round < 2000; ++round) {
    const int depth = random.range(1, 9);
    const int level = random.range(0, depth);
    const int last = (1 << depth) - 1;
    const glm::ivec3 p(random.range(0, last), random.range(0, last), random.range(0, last));
    const VoxelIndex v = VoxelIndex::of(level, p, depth, true);
    EXPECT_EQ(v.level(), level);
    EXPECT_TRUE(v.filled());
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LE(v.min_corner(depth)[axis], p[axis]);
      EXPECT_GT(v.min_corner(depth)[axis] + v.size(depth), p[axis]);
    }
    if (level > 0) {
      EXPECT_EQ(v.parent(), VoxelIndex::of(level - 1, p, depth, true));
    }
  }
}

TEST(VoxelIndex, TwentySixNeighboursAndTheOctreesSides) {
  TestRandom random(6);
  for (int round = 0; round < 300; ++round) {
    const int level = random.range(0, 9);
    const int last = (1 << level) - 1;
    // Corners of the octree often, so that all kinds of missing neighbours come up.
    const auto coordinate = [&] {
      return random.chance(0.3) ? random.range(0, 1) * last : random.range(0, last);
    };
    const glm::ivec3 p(coordinate(), coordinate(), coordinate());
    const VoxelIndex v = VoxelIndex::of(level, p, level, true);
    for (int code = 0; code < 27; ++code) {
      const glm::ivec3 step(code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1);
      const glm::ivec3 q = p + step;
      bool inside = true;
      for (int axis = 0; axis < 3; ++axis) inside = inside && q[axis] >= 0 && q[axis] <= last;
      VoxelIndex result(1, 0x100, 0, 0, true);
      const VoxelIndex before = result;
      EXPECT_EQ(v.neighbour(step, result), inside);
      EXPECT_EQ(result, inside ? VoxelIndex::of(level, q, level) : before);
    }
  }
}

TEST(VoxelIndex, FillIsTheLastBit) {
  const VoxelIndex v(4, 0b101100000, 0b000100000, 0b111100000, false);
  EXPECT_EQ(v.with_fill(true).bits(), v.bits() | 1u);
  EXPECT_EQ(v.with_fill(true).with_fill(false), v);
  EXPECT_TRUE(v.with_fill(true).child(3).filled());
}

}  // namespace
}  // namespace karst::core
