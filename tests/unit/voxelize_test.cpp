// SPDX-License-Identifier: MIT
#include "terrain/field/voxelize.h"

#include "tests/support/tree_memory.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace karst::core {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

template <class Expected>
int count_wrong(const Octree& tree, const Expected& expected) {
  int wrong = 0;
  for (int z = 0; z < tree.size(); ++z) {
    for (int y = 0; y < tree.size(); ++y) {
      for (int x = 0; x < tree.size(); ++x) wrong += tree.filled({x, y, z}) != expected(glm::ivec3(x, y, z));
    }
  }
  return wrong;
}

bool inside(glm::ivec3 v, glm::ivec3 extent) {
  return v.x < extent.x && v.y < extent.y && v.z < extent.z;
}

// The rule as it is stated, one voxel at a time.
auto rule(const VoxelizeHeights& job) {
  return [&job](glm::ivec3 v) {
    return inside(v, job.extent) &&
           static_cast<float>(v.y) + 0.5f < job.tops[static_cast<std::size_t>(v.z * job.extent.x + v.x)];
  };
}

void check_heights(int depth, glm::ivec3 extent, const std::vector<float>& tops) {
  const VoxelizeHeights job{extent, tops};
  TreeMemory memory(depth);
  ASSERT_TRUE(memory.tree.set({0, 0, 0}, 1, true).ok());  // something to replace
  const Status status = job.run(memory.tree);
  ASSERT_TRUE(status.ok()) << status.what();
  EXPECT_EQ(count_wrong(memory.tree, rule(job)), 0);
  expect_sound(memory.tree);
  EXPECT_EQ(job.count_octets(depth), memory.tree.octets_used());

  // One octet less, and it fails without leaving anything behind.
  const std::uint32_t needed = memory.tree.octets_used();
  if (needed == 0) return;
  TreeMemory small(depth, needed - 1);
  const Status full = job.run(small.tree);
  EXPECT_EQ(full.code(), StatusCode::limit_reached);
  EXPECT_STREQ(full.field(), "max_octets");
  EXPECT_EQ(full.value(), needed);
  EXPECT_EQ(small.tree.octets_used(), 0u);
  EXPECT_EQ(small.tree.root(), Octree::kEmpty);
}

TEST(VoxelizeHeights, ValidateNamesTheField) {
  const std::vector<float> tops(12, 1.0f);
  VoxelizeHeights job{{4, 2, 3}, tops};
  EXPECT_TRUE(job.validate().ok());
  for (int axis = 0; axis < 3; ++axis) {
    for (const int bad : {-1, 0, 513, std::numeric_limits<int>::max(), std::numeric_limits<int>::min()}) {
      VoxelizeHeights broken = job;
      broken.extent[axis] = bad;
      EXPECT_STREQ(broken.validate().field(), "extent");
    }
  }
  job.tops = std::span(tops).first(11);
  EXPECT_STREQ(job.validate().field(), "tops");
  EXPECT_EQ(job.validate().value(), 12u);
  job.tops = {};
  EXPECT_STREQ(job.validate().field(), "tops");
  EXPECT_EQ(job.count_octets(2), 0u);

  TreeMemory memory(1);
  EXPECT_STREQ((VoxelizeHeights{{4, 2, 3}, tops}.run(memory.tree).field()), "extent");
}

TEST(VoxelizeHeights, TheCentreDecides) {
  // One column each: just below, at and just above a centre; holes; far away.
  const std::vector<float> tops = {0.5f,       std::nextafter(0.5f, 1.0f),
                                   1.4999f,    1.5f,
                                   1.5001f,    7.5f,
                                   7.50001f,   100.0f,
                                   kInfinity,  3e38f,
                                   -0.0f,      -5.0f,
                                   -kInfinity, kNan,
                                   1e-30f,     8.0f};
  const VoxelizeHeights job{{4, 8, 4}, tops};
  TreeMemory memory(4);
  ASSERT_TRUE(job.run(memory.tree).ok());
  const int expected[16] = {0, 1, 1, 1, 2, 7, 8, 8, 8, 8, 0, 0, 0, 0, 0, 8};
  for (int i = 0; i < 16; ++i) {
    int filled = 0;
    for (int y = 0; y < 16; ++y) filled += memory.tree.filled({i % 4, y, i / 4});
    EXPECT_EQ(filled, expected[i]) << tops[static_cast<std::size_t>(i)];
  }
  check_heights(4, {4, 8, 4}, tops);
}

TEST(VoxelizeHeights, RandomTerrainsEqualTheRule) {
  TestRandom random(8);
  for (int round = 0; round < 60; ++round) {
    const int depth = random.range(1, 5);
    const int size = 1 << depth;
    const glm::ivec3 extent(random.range(1, size), random.range(1, size), random.range(1, size));
    std::vector<float> tops(static_cast<std::size_t>(extent.x) * static_cast<std::size_t>(extent.z));
    const int roughness = random.range(0, size);
    for (float& top : tops) {
      top = 0.3f * static_cast<float>(size) +
            static_cast<float>(random.range(-roughness * 4, roughness * 4)) * 0.25f;
      if (random.chance(0.05)) top = random.chance(0.5) ? kNan : random.chance(0.5) ? kInfinity : -kInfinity;
    }
    check_heights(depth, extent, tops);
    if (HasFailure()) return;
  }
}

TEST(VoxelizeHeights, FlatGroundTakesFewOctets) {
  const std::vector<float> tops(512u * 512u, 256.0f);
  TreeMemory memory(9);
  ASSERT_TRUE((VoxelizeHeights{{512, 511, 512}, tops}.run(memory.tree).ok()));
  EXPECT_EQ(memory.tree.octets_used(), 1u);
  EXPECT_EQ(memory.tree.count_filled(), 512u * 256u * 512u);
}

TEST(VoxelizePredicate, ValidateNamesTheField) {
  const auto all = [](glm::ivec3, bool) { return true; };
  EXPECT_STREQ((VoxelizePredicate{{0, 1, 1}, VoxelFunction(all)}.validate().field()), "extent");
  EXPECT_STREQ((VoxelizePredicate{{1, 1, 1}, {}}.validate().field()), "filled");
  TreeMemory memory(2);
  EXPECT_STREQ((VoxelizePredicate{{1, 5, 1}, VoxelFunction(all)}.run(memory.tree).field()), "extent");
}

TEST(VoxelizePredicate, AsksEveryVoxelOnceAndFillsWhatItSays) {
  TestRandom random(9);
  for (int round = 0; round < 30; ++round) {
    const int depth = random.range(1, 5);
    const int size = 1 << depth;
    const glm::ivec3 extent(random.range(1, size), random.range(1, size), random.range(1, size));
    std::vector<int> asked(static_cast<std::size_t>(size * size * size));
    const auto at = [size](glm::ivec3 v) {
      return static_cast<std::size_t>((v.z * size + v.y) * size + v.x);
    };
    const glm::ivec3 wave(random.range(1, 9), random.range(1, 9), random.range(1, 9));
    const auto shape = [wave](glm::ivec3 v) { return (v.x / wave.x + v.y / wave.y + v.z / wave.z) % 2 == 0; };
    const auto filled = [&](glm::ivec3 v, bool now) {
      EXPECT_FALSE(now);
      ++asked[at(v)];
      return shape(v);
    };
    TreeMemory memory(depth);
    ASSERT_TRUE(memory.tree.set({0, 0, 0}, 0, true).ok());
    const VoxelizePredicate job{extent, VoxelFunction(filled)};
    ASSERT_TRUE(job.run(memory.tree).ok());
    EXPECT_EQ(count_wrong(memory.tree, [&](glm::ivec3 v) { return inside(v, extent) && shape(v); }), 0);
    int wrong = 0;
    for (int i = 0; i < size * size * size; ++i) {
      const glm::ivec3 v(i % size, i / size % size, i / size / size);
      wrong += asked[at(v)] != (inside(v, extent) ? 1 : 0);
    }
    EXPECT_EQ(wrong, 0);
    expect_sound(memory.tree);

    if (memory.tree.octets_used() == 0) continue;
    TreeMemory small(depth, memory.tree.octets_used() - 1);
    EXPECT_EQ(job.run(small.tree).code(), StatusCode::limit_reached);
    EXPECT_EQ(small.tree.octets_used(), 0u);
    EXPECT_EQ(small.tree.root(), Octree::kEmpty);
  }
}

// A sphere, from the function's point of view as far as it goes.
auto sphere(glm::ivec3 centre, int radius, bool fill) {
  return [=](glm::ivec3 v, bool now) {
    const glm::ivec3 d = v - centre;
    return d.x * d.x + d.y * d.y + d.z * d.z <= radius * radius ? fill : now;
  };
}

TEST(EditVoxels, ChangesTheBoxOnly) {
  TestRandom random(10);
  const glm::ivec3 extent(30, 20, 32);
  TreeMemory memory(5);
  std::vector<bool> expected(32u * 32u * 32u);
  const auto at = [](glm::ivec3 v) { return static_cast<std::size_t>((v.z * 32 + v.y) * 32 + v.x); };
  for (int round = 0; round < 120; ++round) {
    EditVoxels job;
    job.extent = extent;
    for (int axis = 0; axis < 3; ++axis) {
      const int a = random.range(-10, 40);
      const int b = random.range(-10, 40);
      job.box_min[axis] = std::min(a, b);
      job.box_max[axis] = std::max(a, b);
    }
    const glm::ivec3 centre(random.range(0, 31), random.range(0, 31), random.range(0, 31));
    const auto edit = sphere(centre, random.range(1, 14), random.chance(0.6));
    job.filled = VoxelFunction(edit);
    ASSERT_TRUE(job.run(memory.tree).ok());
    for (int i = 0; i < 32 * 32 * 32; ++i) {
      const glm::ivec3 v(i % 32, i / 32 % 32, i / 1024);
      bool in_box = inside(v, extent);
      for (int axis = 0; axis < 3; ++axis)
        in_box = in_box && v[axis] >= job.box_min[axis] && v[axis] < job.box_max[axis];
      if (in_box) expected[at(v)] = edit(v, expected[at(v)]);
    }
    ASSERT_EQ(count_wrong(memory.tree, [&](glm::ivec3 v) { return expected[at(v)]; }), 0);
    expect_sound(memory.tree);
  }
  EXPECT_GT(memory.tree.count_filled(), 0u);
}

TEST(EditVoxels, ExtremeBoxesAreClipped) {
  TreeMemory memory(3);
  const auto all = [](glm::ivec3, bool) { return true; };
  const int low = std::numeric_limits<int>::min();
  const int high = std::numeric_limits<int>::max();
  EditVoxels job{glm::ivec3(high), glm::ivec3(low), glm::ivec3(8, 7, 8), VoxelFunction(all)};
  ASSERT_TRUE(job.run(memory.tree).ok());
  EXPECT_EQ(memory.tree.count_filled(), 0u);
  job.box_min = glm::ivec3(low);
  job.box_max = glm::ivec3(high);
  ASSERT_TRUE(job.run(memory.tree).ok());
  EXPECT_EQ(memory.tree.count_filled(), 8u * 7u * 8u);
}

TEST(EditVoxels, ExhaustionLeavesAValidTree) {
  for (std::uint32_t max_octets = 1; max_octets < 80; max_octets += 9) {
    TreeMemory memory(5, max_octets);
    TestRandom random(max_octets);
    int refused = 0;
    for (int round = 0; round < 30; ++round) {
      const glm::ivec3 centre(random.range(0, 31), random.range(0, 31), random.range(0, 31));
      const auto edit = sphere(centre, random.range(1, 14), random.chance(0.6));
      const EditVoxels job{glm::ivec3(0), glm::ivec3(32), glm::ivec3(32), VoxelFunction(edit)};
      std::vector<bool> before(32u * 32u * 32u);
      const auto at = [](glm::ivec3 v) { return static_cast<std::size_t>((v.z * 32 + v.y) * 32 + v.x); };
      for (int i = 0; i < 32 * 32 * 32; ++i) {
        const glm::ivec3 v(i % 32, i / 32 % 32, i / 1024);
        before[at(v)] = memory.tree.filled(v);
      }
      const Status status = job.run(memory.tree);
      expect_sound(memory.tree);
      EXPECT_LE(memory.tree.octets_used(), max_octets);
      refused += !status.ok();
      // Each voxel has its old or its new value, and the new one where the edit went through.
      const int odd = count_wrong(memory.tree, [&](glm::ivec3 v) {
        const bool old = before[at(v)];
        const bool wanted = edit(v, old);
        return status.ok() || memory.tree.filled(v) != old ? wanted : old;
      });
      EXPECT_EQ(odd, 0);
      EXPECT_STREQ(status.field(), status.ok() ? "" : "max_octets");
      if (HasFailure()) return;
    }
    EXPECT_GT(refused, 0);
  }
}

}  // namespace
}  // namespace karst::core
