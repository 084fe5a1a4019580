// SPDX-License-Identifier: MIT
// Extraction: its invalid inputs one by one, its counts, large voxels against small ones, and work that
// follows the surface.
#include "terrain/surface/bezier/extract_surface.h"

#include <gtest/gtest.h>

#include <vector>

#include "terrain/field/voxel_reader.h"
#include "terrain/surface/bezier/case_tables.h"
#include "terrain/surface/bezier/gradient.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

class ExtractSurfaceTest : public testing::Test {
 protected:
  ExtractSurfaceTest()
      : world_({12, 10, 12}, [](glm::ivec3 v) { return v.y < 4 + (v.x > 5 ? 2 : 0); }),
        volumes_(1000),
        patches_(3000),
        scratch_(ExtractSurface::scratch_size(1000)) {
    extract_.octree = &world_.octree();
    extract_.extent = world_.extent();
    extract_.volumes = volumes_;
    extract_.patches = patches_;
    extract_.scratch = scratch_;
  }

  test::TestWorld world_;
  std::vector<Volume> volumes_;
  std::vector<Patch> patches_;
  std::vector<std::uint32_t> scratch_;
  ExtractSurface extract_;
  ExtractSurface::Result result_;
};

TEST_F(ExtractSurfaceTest, RefusesWhatIsMissingOrWrong) {
  ASSERT_TRUE(extract_.validate().ok());
  const auto field_of = [](const ExtractSurface& e) { return std::string(e.validate().field()); };
  ExtractSurface e = extract_;
  e.octree = nullptr;
  EXPECT_EQ(field_of(e), "octree");
  EXPECT_FALSE(e.count(result_).ok());
  for (const glm::ivec3 extent :
       {glm::ivec3(1, 4, 4), glm::ivec3(17, 4, 4), glm::ivec3(4, 0, 4), glm::ivec3(4, 16, 4),
        glm::ivec3(4, 4, 1), glm::ivec3(4, 4, 17), glm::ivec3(-1, 4, 4)}) {
    e = extract_;
    e.extent = extent;
    EXPECT_EQ(field_of(e), "extent") << extent.x << ' ' << extent.y << ' ' << extent.z;
  }
  e = extract_;
  e.scratch = extract_.scratch.first(extract_.scratch.size() / 2);
  EXPECT_EQ(field_of(e), "max_scratch");
  e.scratch = extract_.scratch.first(extract_.scratch.size() - 1);
  EXPECT_EQ(field_of(e), "max_scratch");
}

TEST_F(ExtractSurfaceTest, NamesThePoolThatIsTooSmall) {
  ASSERT_TRUE(extract_.run(result_).ok());
  const ExtractSurface::Result full = result_;
  ExtractSurface e = extract_;
  e.volumes = extract_.volumes.first(full.volumes - 1);
  EXPECT_STREQ(e.run(result_).field(), "max_volumes");
  EXPECT_EQ(result_.patches, 0u);
  e = extract_;
  e.patches = extract_.patches.first(full.patches - 1);
  EXPECT_STREQ(e.run(result_).field(), "max_patches");
  e = extract_;
  e.volumes = extract_.volumes.first(full.volumes);
  e.patches = extract_.patches.first(full.patches);
  EXPECT_TRUE(e.run(result_).ok());
}

// A step two voxels high across a flat field: one patch a column, and one more for each voxel of the wall.
TEST_F(ExtractSurfaceTest, CountsAStep) {
  ASSERT_TRUE(extract_.run(result_).ok());
  ExtractSurface::Result counted;
  ASSERT_TRUE(extract_.count(counted).ok());
  EXPECT_EQ(counted.volumes, result_.volumes);
  EXPECT_EQ(counted.patches, result_.patches);
  // Corners 1..11 on both ground axes: each of the 11 rows has 11 columns; the wall at x = 6 has its foot
  // (4), one voxel of wall (5) and its brink (6).
  EXPECT_EQ(result_.volumes, 11u * (10 + 3));
  EXPECT_EQ(result_.patches, 11u * (10 + 3));
}

TEST_F(ExtractSurfaceTest, VolumesFollowTheOctreesOrder) {
  ASSERT_TRUE(extract_.run(result_).ok());
  const auto morton = [](const Volume& v) {
    std::uint64_t code = 0;
    for (int bit = 0; bit < 10; ++bit) {
      for (int axis = 0; axis < 3; ++axis)
        code |= static_cast<std::uint64_t>(v.corner[axis] >> bit & 1) << (3 * bit + axis);
    }
    return code;
  };
  PatchId next = 0;
  for (std::uint32_t v = 0; v < result_.volumes; ++v) {
    if (v > 0) {
      EXPECT_LT(morton(volumes_[v - 1]), morton(volumes_[v]));
    }
    for (std::uint8_t p = 0; p < volumes_[v].patch_count; ++p) {
      EXPECT_EQ(patches_[next + p].volume, v);
      EXPECT_EQ(patches_[next + p].case_patch, p);
    }
    next += volumes_[v].patch_count;
  }
  EXPECT_EQ(next, result_.patches);
}

// Every corner of the world looked at one by one gives the same volumes: nothing is skipped inside large
// voxels.
TEST(ExtractSurface, SkipsNothing) {
  test::Random random{31};
  for (int round = 0; round < 40; ++round) {
    const glm::ivec3 extent(3 + random.below(20), 3 + random.below(20), 3 + random.below(20));
    const test::TestWorld world =
        test::TestWorld::noise(random.next(), extent, 0.5, round % 2 == 0 ? 0.0 : 6.0, false);
    const VoxelReader reader(world.octree(), extent);
    std::size_t found = 0;
    for (int z = 1; z < extent.z; ++z) {
      for (int y = 1; y <= extent.y; ++y) {
        for (int x = 1; x < extent.x; ++x) {
          int configuration = 0;
          for (int o = 0; o < 8; ++o) {
            configuration |=
                (reader.filled({x - 1 + (o & 1), y - 1 + (o >> 1 & 1), z - 1 + (o >> 2)}) ? 1 : 0) << o;
          }
          found += configuration != 0 && configuration != 255;
        }
      }
    }
    ASSERT_EQ(world.surface().volumes.size(), found);
  }
}

// The integer kernel against its definition.
TEST(Gradient, MatchesItsDefinition) {
  test::Random random{32};
  const glm::ivec3 extent(12, 12, 12);
  const test::TestWorld world = test::TestWorld::noise(5, extent, 0.5, 0.0, false);
  const VoxelReader reader(world.octree(), extent);
  const auto smoothed = [&](glm::ivec3 at) {
    int sum = 0;
    for (int k = 0; k < 27; ++k) {
      const glm::ivec3 d(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      const int weight = (2 - std::abs(d.x)) * (2 - std::abs(d.y)) * (2 - std::abs(d.z));
      sum += weight * (reader.filled(at + d) ? 1 : 0);
    }
    return sum;
  };
  NeighbourhoodReader neighbourhoods(reader);
  for (int round = 0; round < 300; ++round) {
    const glm::ivec3 corner(1 + random.below(11), 1 + random.below(12), 1 + random.below(11));
    std::int8_t gradient[8][3];
    corner_gradients(neighbourhoods.read(corner), gradient);
    for (int o = 0; o < 8; ++o) {
      const glm::ivec3 voxel = corner - 1 + glm::ivec3(o & 1, o >> 1 & 1, o >> 2);
      for (int axis = 0; axis < 3; ++axis) {
        glm::ivec3 step(0);
        step[axis] = 1;
        EXPECT_EQ(gradient[o][axis], smoothed(voxel - step) - smoothed(voxel + step));
      }
    }
  }
}

}  // namespace
}  // namespace karst::core
