// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <array>
#include <initializer_list>
#include <vector>

#include "terrain/ground/ground.h"
#include "terrain/regions/region_rim.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

using test::TestWorld;

GroundInfo ground_of(int lattice_size, std::int64_t wide = 161, std::int64_t deep = 121) {
  GroundInfo info;
  info.samples[0] = wide;
  info.samples[1] = deep;
  info.steps[0] = info.steps[1] = kMostSampleSteps * (1 << lattice_size);
  return info;
}

TEST(PlaceRegion, LiesOnEdgesOfNodesWithOutermostVoxelsCentresThere) {
  for (int g = 0; g <= 3; ++g) {
    GroundInfo info = ground_of(g);
    ASSERT_TRUE(place_region(info, (5 << g) + 1, (3 << g) + 1, 7, 9)) << g;
    EXPECT_EQ(info.lattice_size, g);
    EXPECT_EQ(info.regions()[0].nodes, (NodeRect{{7, 9}, {12, 12}}));
    for (int axis = 0; axis < 2; ++axis) {
      const std::int64_t low =
          sample_place(info, axis, std::int64_t{info.regions()[0].nodes.low[axis]} * kNodeQuads);
      const std::int64_t high =
          sample_place(info, axis, std::int64_t{info.regions()[0].nodes.high[axis]} * kNodeQuads);
      EXPECT_EQ(low * kVertexStep, kStepsPerHalfVoxel);
      const int extent = axis == 0 ? (5 << g) + 1 : (3 << g) + 1;
      EXPECT_EQ(high * kVertexStep, extent * kStepsPerVoxel - kStepsPerHalfVoxel);
    }
  }
}

TEST(PlaceRegion, RefusesWhatIsNone) {
  const auto placed = [](GroundInfo info, int extent_x, int extent_z, int x, int z) {
    const bool is = place_region(info, extent_x, extent_z, x, z);
    EXPECT_EQ(info.region_count, is ? 1 : 0);
    return is;
  };
  EXPECT_TRUE(placed(ground_of(2), 17, 9, 1, 1));
  EXPECT_FALSE(placed(ground_of(2), 17, 10, 1, 1));  // no whole nodes
  EXPECT_FALSE(placed(ground_of(2), 17, 1, 1, 1));
  EXPECT_FALSE(placed(ground_of(2), 17, 9, 0, 1));   // no ground in the west
  EXPECT_FALSE(placed(ground_of(2), 17, 9, 36, 1));  // nor in the east: 40 nodes
  EXPECT_TRUE(placed(ground_of(2), 17, 9, 35, 1));
  EXPECT_FALSE(placed(ground_of(2), 17, 9, 1, -5));
  EXPECT_FALSE(placed(ground_of(kMostLatticeSize + 1), (2 << 9) + 1, (2 << 9) + 1, 1, 1));
  GroundInfo uneven = ground_of(2);
  uneven.steps[1] -= 1;
  EXPECT_FALSE(placed(uneven, 17, 9, 1, 1));
  GroundInfo odd = ground_of(2);
  odd.steps[0] = odd.steps[1] = 3000;
  EXPECT_FALSE(placed(odd, 17, 9, 1, 1));
}

// Rectangles by their first node and how many.
GroundInfo with_regions(std::initializer_list<std::array<int, 4>> rectangles) {
  GroundInfo info = ground_of(1);
  for (const std::array<int, 4>& r : rectangles) {
    GroundRegion& region = info.region_list[static_cast<std::size_t>(info.region_count++)];
    region.nodes.low[0] = r[0];
    region.nodes.low[1] = r[1];
    region.extent = {2 * r[2] + 1, 9, 2 * r[3] + 1};
  }
  return info;
}

TEST(PlaceRegion, SeveralLieANodeApart) {
  const auto placed = [](std::initializer_list<std::array<int, 4>> rectangles) {
    GroundInfo info = with_regions(rectangles);
    const bool is = place_regions(info);
    EXPECT_EQ(info.region_count, is ? static_cast<int>(rectangles.size()) : 0);
    return is;
  };
  EXPECT_TRUE(placed({{5, 5, 3, 2}, {9, 5, 2, 2}}));   // a node between them
  EXPECT_FALSE(placed({{5, 5, 3, 2}, {8, 5, 2, 2}}));  // side by side
  EXPECT_FALSE(placed({{5, 5, 3, 2}, {7, 6, 2, 2}}));  // on each other
  EXPECT_FALSE(placed({{5, 5, 3, 2}, {8, 7, 2, 2}}));  // at a corner
  EXPECT_TRUE(placed({{5, 5, 3, 2}, {8, 8, 2, 2}}));   // a row between them
  EXPECT_FALSE(placed({{5, 5, 3, 2}, {20, 5, 2, 2}, {6, 6, 1, 1}}));
  EXPECT_FALSE(placed({{5, 5, 3, 2}, {38, 5, 2, 2}}));  // no ground in the east of one
  GroundInfo high = with_regions({{5, 5, 3, 2}, {9, 5, 2, 2}});
  high.region_list[1].corner.y = kMostRegionHeight + 1;
  EXPECT_FALSE(place_regions(high));
}

TEST(PlaceRegion, CornersLieOnOneLattice) {
  GroundInfo info = with_regions({{12, 5, 3, 2}, {5, 9, 2, 4}});
  info.region_list[0].corner.y = 40;
  ASSERT_TRUE(place_regions(info));
  EXPECT_EQ(info.regions()[0].corner, glm::ivec3(14, 40, 0));
  EXPECT_EQ(info.regions()[1].corner, glm::ivec3(0, 0, 8));
  for (const GroundRegion& region : info.regions()) {
    for (int axis = 0; axis < 2; ++axis) {
      const std::int64_t low = sample_place(info, axis, std::int64_t{region.nodes.low[axis]} * kNodeQuads);
      EXPECT_EQ(low * kVertexStep,
                std::int64_t{region.corner[2 * axis]} * kStepsPerVoxel + kStepsPerHalfVoxel);
    }
  }
}

TEST(PlaceRegion, NodesAreInItInPartOrNotAtAll) {
  GroundInfo info = ground_of(0);
  ASSERT_TRUE(place_region(info, 6, 4, 7, 9));
  for (int size = 0; size <= info.top_size(); ++size) {
    for (int z = 0; z < 40 >> size; ++z) {
      for (int x = 0; x < 40 >> size; ++x) {
        int in = 0, out = 0;
        bool touches = false;
        for (int k = z << size; k < (z + 1) << size; ++k) {
          for (int i = x << size; i < (x + 1) << size; ++i) {
            const bool inside = i >= 7 && i < 12 && k >= 9 && k < 12;
            (inside ? in : out) += 1;
            // One of those around it is on the other side.
            for (int d = 0; d < 9; ++d) {
              const int a = i + d % 3 - 1, b = k + d / 3 - 1;
              touches = touches || (a >= 7 && a < 12 && b >= 9 && b < 12) != inside;
            }
          }
        }
        const InRegion expected = in == 0 ? InRegion::none : out == 0 ? InRegion::all : InRegion::part;
        EXPECT_EQ(in_region(info, {size, x, z}), expected) << size << ' ' << x << ' ' << z;
        EXPECT_EQ(borders(info.regions()[0], {size, x, z}), touches) << size << ' ' << x << ' ' << z;
      }
    }
  }
}

struct Rim {
  explicit Rim(const Surface& surface, std::size_t room = 4096) : edges(room), marks(room) {
    rim.create({edges, marks});
    GroundInfo info = ground_of(1);
    EXPECT_TRUE(place_region(info, 17, 13, 5, 6));
    status = rim.build(info.regions()[0], info.lattice_size, surface);
  }
  std::vector<RegionRim::Edge> edges;
  std::vector<std::uint32_t> marks;
  RegionRim rim;
  Status status;
};

TestWorld slope(bool tunnel) {
  return TestWorld(
      {17, 12, 13},
      [=](glm::ivec3 v) {
        const bool hollow = tunnel && v.y >= 2 && v.y <= 4 && v.z >= 5 && v.z <= 7;
        return v.y < 6 + v.x / 4 && !hollow;
      },
      true);
}

TEST(RegionRim, IsOneLineThatCrossesUprightLinesOfNodesInCorners) {
  const TestWorld world = slope(false);
  const Rim made(world.surface());
  ASSERT_TRUE(made.status.ok()) << made.status.what();
  EXPECT_EQ(made.rim.edges().size(), RegionRim::count(world.surface()));
  EXPECT_EQ(made.rim.columns(), 6u + 8 + 6 + 8);
  // Each edge begins where the one before ends; marks rise, and lie at every fourth half voxel.
  std::size_t at = 0;
  for (int side = 0; side < 4; ++side) {
    for (std::uint32_t c = made.rim.first_column(side); c < made.rim.first_column(side + 1); ++c) {
      const RegionRim::Edge& edge = made.rim.edges()[made.rim.mark(c)];
      EXPECT_EQ(edge.from, static_cast<int>(c - made.rim.first_column(side)) * 4);
      EXPECT_GE(made.rim.mark(c), at);
      at = made.rim.mark(c);
    }
  }
  for (std::size_t n = 1; n < made.rim.edges().size(); ++n) {
    const bool turns = made.rim.edges()[n].from == 0;
    EXPECT_TRUE(turns || made.rim.edges()[n].from == made.rim.edges()[n - 1].to) << n;
  }
}

TEST(RegionRim, RefusesSidesThatAreCutAndTooLittleRoom) {
  const TestWorld cut = slope(true);
  const Rim made(cut.surface());
  EXPECT_EQ(made.status.code(), StatusCode::corrupt);
  EXPECT_STREQ(made.status.field(), "region");
  const TestWorld whole = slope(false);
  const Rim small(whole.surface(), 20);
  EXPECT_EQ(small.status.code(), StatusCode::limit_reached);
  EXPECT_STREQ(small.status.field(), "rim_edges");
}

}  // namespace
}  // namespace karst::core
