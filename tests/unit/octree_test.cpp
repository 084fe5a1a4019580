// SPDX-License-Identifier: MIT
#include "terrain/field/octree.h"

#include "tests/support/tree_memory.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace karst::core {
namespace {

// The plain array that an octree stands for.
struct Dense {
  explicit Dense(int depth) : size(1 << depth), voxels(std::size_t{1} << (3 * depth)) {}

  std::size_t index(glm::ivec3 v) const {
    return (static_cast<std::size_t>(v.z) * static_cast<std::size_t>(size) + static_cast<std::size_t>(v.y)) *
               static_cast<std::size_t>(size) +
           static_cast<std::size_t>(v.x);
  }
  void set(glm::ivec3 origin, int edge, bool filled) {
    for (int z = 0; z < edge; ++z) {
      for (int y = 0; y < edge; ++y) {
        for (int x = 0; x < edge; ++x) voxels[index(origin + glm::ivec3(x, y, z))] = filled;
      }
    }
  }
  std::uint64_t count() const {
    std::uint64_t n = 0;
    for (const bool v : voxels) n += v;
    return n;
  }

  int size;
  std::vector<bool> voxels;
};

// Every voxel agrees, and every leaf is a cube at a multiple of its size that holds the voxel it was asked
// for.
void expect_same(const Octree& tree, const Dense& dense) {
  ASSERT_EQ(tree.size(), dense.size);
  int wrong = 0;
  for (int z = 0; z < dense.size; ++z) {
    for (int y = 0; y < dense.size; ++y) {
      for (int x = 0; x < dense.size; ++x) {
        const glm::ivec3 v(x, y, z);
        const Octree::Leaf leaf = tree.find_leaf(v);
        wrong += leaf.filled != dense.voxels[dense.index(v)];
        for (int axis = 0; axis < 3; ++axis) {
          wrong += leaf.origin[axis] % leaf.size != 0 || v[axis] < leaf.origin[axis] ||
                   v[axis] >= leaf.origin[axis] + leaf.size;
        }
      }
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(tree.count_filled(), dense.count());
  expect_sound(tree);
}

void fill_all(TreeMemory& memory) {
  ASSERT_TRUE(memory.tree.set({0, 0, 0}, 0, true).ok());
}

TEST(Octree, CreateRefusesImpossibleLimits) {
  alignas(Arena::kAlignment) std::byte memory[320];
  Arena arena(memory);
  Octree tree;
  for (const int depth : {-1, 0, 10, 1 << 30}) {
    EXPECT_EQ(tree.create(arena, depth, 1).code(), StatusCode::invalid_argument);
    EXPECT_STREQ(tree.create(arena, depth, 1).field(), "depth");
  }
  EXPECT_STREQ(tree.create(arena, 3, 0x80000000u).field(), "max_octets");
  EXPECT_EQ(arena.used(), 0u);
  const Status full = tree.create(arena, 3, 11);
  EXPECT_EQ(full.code(), StatusCode::limit_reached);
  EXPECT_STREQ(full.field(), "arena");
  EXPECT_TRUE(tree.create(arena, 3, 10).ok());
  EXPECT_EQ(arena.used(), Octree::bytes_for(10));
  EXPECT_EQ(arena.used(Consumer::octets), 320u);
}

TEST(Octree, StartsEmpty) {
  TreeMemory memory(9, 4);
  EXPECT_EQ(memory.tree.root(), Octree::kEmpty);
  EXPECT_EQ(memory.tree.octets_used(), 0u);
  EXPECT_EQ(memory.tree.count_filled(), 0u);
  EXPECT_EQ(memory.tree.find_leaf({511, 0, 77}).size, 512);
}

TEST(Octree, SetRefusesWhatIsNotAVoxel) {
  TreeMemory memory(3);
  EXPECT_STREQ(memory.tree.set({0, 0, 0}, -1, true).field(), "level");
  EXPECT_STREQ(memory.tree.set({0, 0, 0}, 4, true).field(), "level");
  for (const glm::ivec3 bad : {glm::ivec3(-4, 0, 0), glm::ivec3(0, 8, 0), glm::ivec3(0, 0, 2)}) {
    EXPECT_STREQ(memory.tree.set(bad, 1, true).field(), "origin");
  }
  EXPECT_EQ(memory.tree.octets_used(), 0u);
}

TEST(Octree, SplitsToOneVoxelAndCollapsesAgain) {
  TreeMemory memory(9, 9);
  const glm::ivec3 v(300, 17, 511);
  ASSERT_TRUE(memory.tree.set(v, 9, true).ok());
  EXPECT_EQ(memory.tree.octets_used(), 9u);
  EXPECT_EQ(memory.tree.count_filled(), 1u);
  EXPECT_EQ(memory.tree.find_leaf(v).size, 1);
  EXPECT_EQ(memory.tree.find_leaf({0, 0, 0}).size, 256);
  ASSERT_TRUE(memory.tree.set(v, 9, true).ok());
  EXPECT_EQ(memory.tree.octets_used(), 9u);
  ASSERT_TRUE(memory.tree.set(v, 9, false).ok());
  EXPECT_EQ(memory.tree.root(), Octree::kEmpty);
  EXPECT_EQ(memory.tree.octets_used(), 0u);
}

TEST(Octree, ACoarseVoxelGivesBackWhatLiesInside) {
  TreeMemory memory(6);
  TestRandom random(1);
  for (int i = 0; i < 500; ++i) {
    ASSERT_TRUE(
        memory.tree.set({random.range(0, 31), random.range(0, 31), random.range(32, 63)}, 6, true).ok());
  }
  EXPECT_GT(memory.tree.octets_used(), 100u);
  ASSERT_TRUE(memory.tree.set({0, 0, 32}, 1, true).ok());
  EXPECT_EQ(memory.tree.octets_used(), 1u);
  EXPECT_EQ(memory.tree.count_filled(), 32u * 32u * 32u);
  fill_all(memory);
  EXPECT_EQ(memory.tree.root(), Octree::kFilled);
  EXPECT_EQ(memory.tree.octets_used(), 0u);
}

TEST(Octree, RandomSetsOfAllLevelsEqualADenseArray) {
  for (int depth = 1; depth <= 5; ++depth) {
    TreeMemory memory(depth);
    Dense dense(depth);
    TestRandom random(static_cast<std::uint64_t>(depth));
    for (int step = 0; step < 600; ++step) {
      // Coarse voxels seldom, or they would wipe out all detail.
      const int level =
          random.chance(0.05) ? random.range(0, depth) : depth - random.range(0, depth > 1 ? 1 : 0);
      const int edge = dense.size >> level;
      const auto cells = static_cast<std::uint32_t>(1 << level);
      const glm::ivec3 cell(random.below(cells), random.below(cells), random.below(cells));
      const bool filled = random.chance(0.6);
      ASSERT_TRUE(memory.tree.set(cell * edge, level, filled).ok());
      dense.set(cell * edge, edge, filled);
      if (step % 50 == 0) expect_same(memory.tree, dense);
    }
    expect_same(memory.tree, dense);
  }
}

TEST(Octree, ExhaustionLeavesTheTreeUnchanged) {
  for (const std::uint32_t max_octets : {0u, 1u, 2u, 3u, 4u, 5u, 7u, 11u, 16u, 23u}) {
    TreeMemory memory(5, max_octets);
    Dense dense(5);
    TestRandom random(max_octets);
    int refused = 0;
    for (int step = 0; step < 200; ++step) {
      const int level = random.chance(0.1) ? random.range(1, 3) : 5;
      const int edge = 32 >> level;
      const auto cells = static_cast<std::uint32_t>(1 << level);
      const glm::ivec3 origin =
          glm::ivec3(random.below(cells), random.below(cells), random.below(cells)) * edge;
      const bool filled = random.chance(0.5);
      const std::uint32_t before = memory.tree.octets_used();
      const Status status = memory.tree.set(origin, level, filled);
      if (status.ok()) {
        dense.set(origin, edge, filled);
      } else {
        ++refused;
        ASSERT_EQ(status.code(), StatusCode::limit_reached);
        ASSERT_STREQ(status.field(), "max_octets");
        EXPECT_GT(status.value(), max_octets);
        EXPECT_EQ(memory.tree.octets_used(), before);
      }
      EXPECT_LE(memory.tree.octets_used(), max_octets);
      if (step % 10 == 0) expect_same(memory.tree, dense);
      if (HasFailure()) return;
    }
    EXPECT_GT(refused, 0);
  }
}

TEST(Octree, ResetGivesEverythingBackAndMayChangeTheDepth) {
  TreeMemory memory(4, 20);
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(memory.tree.set({15, 3, 9}, 4, true).ok());
    ASSERT_TRUE(memory.tree.set({1, 3, 9}, 4, true).ok());
    EXPECT_FALSE(memory.tree.reset(0).ok());
    EXPECT_EQ(memory.tree.count_filled(), 2u);
    ASSERT_TRUE(memory.tree.reset(9).ok());
    EXPECT_EQ(memory.tree.size(), 512);
    EXPECT_EQ(memory.tree.count_filled(), 0u);
    ASSERT_TRUE(memory.tree.set({511, 511, 511}, 9, true).ok());
    ASSERT_TRUE(memory.tree.reset(4).ok());
  }
  EXPECT_EQ(memory.tree.octets_used(), 0u);
}

TEST(Octree, MakeNodeCollapsesEqualLeavesOnly) {
  TreeMemory memory(2, 2);
  Octree& tree = memory.tree;
  Octree::Octet octet;
  for (Octree::Node& c : octet.child) c = Octree::kFilled;
  Octree::Node node = 0;
  ASSERT_TRUE(tree.make_node(octet, node).ok());
  EXPECT_EQ(node, Octree::kFilled);
  EXPECT_EQ(tree.octets_used(), 0u);

  octet.child[5] = Octree::kEmpty;
  ASSERT_TRUE(tree.make_node(octet, node).ok());
  ASSERT_FALSE(Octree::is_leaf(node));
  for (Octree::Node& c : octet.child) c = node;
  Octree::Node top = 0;
  ASSERT_TRUE(tree.make_node(octet, top).ok()) << "eight internal nodes never collapse";
  ASSERT_FALSE(Octree::is_leaf(top));
  Octree::Node untouched = Octree::kFilled;
  EXPECT_EQ(tree.make_node(octet, untouched).code(), StatusCode::limit_reached);
  EXPECT_EQ(untouched, Octree::kFilled);
  tree.set_root(top);
  EXPECT_EQ(tree.count_filled(), 56u);
}

TEST(Octree, UpdateNodeReusesItsOctet) {
  TreeMemory memory(1, 1);
  Octree& tree = memory.tree;
  ASSERT_TRUE(tree.set({1, 0, 0}, 1, true).ok());
  Octree::Octet octet = tree.children(tree.root());
  octet.child[6] = Octree::kFilled;
  tree.set_root(tree.update_node(tree.root(), octet));
  EXPECT_EQ(tree.count_filled(), 2u);
  EXPECT_TRUE(tree.filled({0, 1, 1}));
  EXPECT_EQ(tree.octets_used(), 1u);
  for (Octree::Node& c : octet.child) c = Octree::kFilled;
  tree.set_root(tree.update_node(tree.root(), octet));
  EXPECT_EQ(tree.root(), Octree::kFilled);
  EXPECT_EQ(tree.octets_used(), 0u);
}

}  // namespace
}  // namespace karst::core
