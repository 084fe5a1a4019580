// SPDX-License-Identifier: MIT
// What a node's page has on the GPU besides vertices: its texel, and its vertices' entries in a family's row.
#include "terrain/ground/family_row.h"

#include <map>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "terrain/patch/gpu_vertex.h"

namespace karst::core {
namespace {

TEST(PageTexel, HoldsWhatItIsMadeOfAtEveryEnd) {
  constexpr int kMost = 0x7fffffff;
  for (const glm::ivec3 origin :
       {glm::ivec3(0), glm::ivec3(kMost, kMostPageHeight - 1, -kMost - 1), glm::ivec3(-1, -1, 1),
        glm::ivec3(-kMost - 1, -kMostPageHeight, kMost), glm::ivec3(511, 512, 1)}) {
    for (const int size : {0, 1, kMostPageSize}) {
      for (const std::uint32_t place : {0u, kMostSlotPages - 1, kFirstGroundPlace, kMostPlaces - 1}) {
        for (const std::uint32_t row : {0u, 1u, kMostMorphRows - 1}) {
          for (const std::uint32_t material : {0u, 1u, 15u}) {
            for (const bool cave : {false, true}) {
              const PageTexel texel = make_page_texel(origin, size, place, row, material, cave);
              // As the vertex shader takes it apart.
              ASSERT_EQ(static_cast<int>(texel.x), origin.x);
              ASSERT_EQ(static_cast<int>(texel.z), origin.z);
              ASSERT_EQ(static_cast<int>(texel.y_size << 6) >> 6, origin.y);
              ASSERT_EQ(static_cast<int>(texel.y_size >> 26 & 31u), size);
              ASSERT_EQ(texel.y_size >> 31 != 0, cave);
              ASSERT_EQ(texel.place & 255u, place);
              ASSERT_EQ(texel.place >> 8 & (kMostMorphRows - 1), row);
              ASSERT_EQ(texel.place >> 28, material);
            }
          }
        }
      }
    }
  }
}

// Entries of patches stay as they are; a vertex that two children of a family share has one entry, and a
// family's border has the classes that its neighbours' rows have.
TEST(FamilyRow, EntriesOfSharedVerticesAgree) {
  std::vector<std::uint8_t> entries(kMorphEntries, 77);
  ASSERT_TRUE(build_morph_entries(kMaxLevel, entries).ok());
  const std::vector<std::uint8_t> before = entries;
  build_family_entries(entries);
  for (std::size_t n = 0; n < kFirstGroundPlace * kPageVertices; ++n) ASSERT_EQ(entries[n], before[n]);

  std::map<std::pair<int, int>, int> classes;  // by (south, east) in the family
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    for (int i = 0; i < kNodeSide; ++i) {
      for (int j = 0; j < kNodeSide; ++j) {
        const std::size_t vertex = (kFirstGroundPlace + static_cast<std::size_t>(quadrant)) * kPageVertices +
                                   static_cast<std::size_t>(vertex_order(kNodeLevel, i, j));
        const std::pair<int, int> at(i + 4 * (quadrant >> 1), j + 4 * (quadrant & 1));
        const auto [known, is_new] = classes.emplace(at, entries[vertex]);
        EXPECT_EQ(known->second, entries[vertex]) << at.first << ' ' << at.second;
      }
    }
  }
  ASSERT_EQ(classes.size(), 81u);
  std::map<int, int> count;
  for (const auto& [at, entry] : classes) ++count[entry];
  EXPECT_EQ(count[kFamilyInside], 49);
  for (int n = 0; n < 4; ++n) {
    EXPECT_EQ(count[family_edge(n)], 7);
    EXPECT_EQ(count[family_corner(n)], 1);
  }
  // West, south, east, north; corners from the north-west on, where edge 0 begins.
  EXPECT_EQ((classes[{3, 0}]), family_edge(0));
  EXPECT_EQ((classes[{8, 3}]), family_edge(1));
  EXPECT_EQ((classes[{3, 8}]), family_edge(2));
  EXPECT_EQ((classes[{0, 3}]), family_edge(3));
  EXPECT_EQ((classes[{0, 0}]), family_corner(0));
  EXPECT_EQ((classes[{8, 0}]), family_corner(1));
  EXPECT_EQ((classes[{8, 8}]), family_corner(2));
  EXPECT_EQ((classes[{0, 8}]), family_corner(3));
}

}  // namespace
}  // namespace karst::core
