// SPDX-License-Identifier: MIT
// Tiles and families in memory that is too small for them.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "terrain/draw/wall_indices.h"
#include "terrain/nodes/family_pool.h"
#include "terrain/nodes/family_row.h"
#include "terrain/nodes/make_node.h"
#include "terrain/nodes/node_place.h"
#include "terrain/paging/tile_cache.h"
#include "terrain/patch/octahedral.h"
#include "tests/support/memory_ground.h"

namespace karst::core {
namespace {

using test::MemoryGround;

// Answers what was asked for in order, or with failure, as told.
struct Answers {
  std::vector<NodeKey> asked;
  std::size_t most = 100;
  bool fails = false;

  TileSource source() {
    return {this,
            [](void* context, NodeKey tile, const TilePlace&) {
              auto& own = *static_cast<Answers*>(context);
              if (own.asked.size() >= own.most) return false;
              own.asked.push_back(tile);
              return true;
            },
            [](void* context, NodeKey& tile, Tile& out) {
              auto& own = *static_cast<Answers*>(context);
              if (own.asked.empty()) return TileSource::Answer::none;
              tile = own.asked.front();
              own.asked.erase(own.asked.begin());
              out = {};
              out.heights[0] = tile.x;
              return own.fails ? TileSource::Answer::failed : TileSource::Answer::ready;
            }};
  }
};

struct Cache {
  explicit Cache(std::size_t count) : tiles(count), slots(count), chains(count) {
    cache.create({tiles, {slots, chains}});
    cache.reset(answers.source(), {9, 0, 0}, Tile{});
  }
  std::vector<Tile> tiles;
  std::vector<TileSlot> slots;
  std::vector<std::int32_t> chains;
  Answers answers;
  TileCache cache;

  void frame(std::initializer_list<NodeKey> looks) {
    cache.begin_frame();
    cache.poll();
    for (const NodeKey key : looks) {
      if (cache.find(key) == nullptr) cache.want(key, {1, 1, 0}, static_cast<float>(key.x));
    }
    cache.ask();
  }
};

TEST(TileCache, TakesWhatWasAskedForMostUrgentFirst) {
  Cache c(8);
  c.answers.most = 2;
  c.frame({{0, 1, 0}, {0, 5, 0}, {0, 3, 0}, {0, 5, 0}});
  EXPECT_EQ(c.cache.counts().wanted, 3u);
  EXPECT_EQ(c.answers.asked, (std::vector<NodeKey>{{0, 5, 0}, {0, 3, 0}}));
  c.frame({{0, 1, 0}});
  ASSERT_NE(c.cache.find({0, 5, 0}), nullptr);
  EXPECT_EQ(c.cache.find({0, 5, 0})->heights[0], 5);
  EXPECT_NE(c.cache.find({0, 3, 0}), nullptr);
  EXPECT_EQ(c.cache.find({0, 1, 0}), nullptr);
  EXPECT_EQ(c.cache.counts().came, 2u);
}

TEST(TileCache, GivesUpWhatWasNotLookedAtForLongestAndNeverTheRoot) {
  Cache c(4);
  for (int x = 1; x <= 3; ++x) {
    c.frame({{0, x, 0}});
    c.frame({{0, x, 0}});
  }
  for (int frame = 0; frame < 4; ++frame) c.frame({{0, 1, 0}, {0, 3, 0}});
  c.frame({{0, 1, 0}, {0, 3, 0}, {0, 7, 0}});
  c.frame({{0, 1, 0}, {0, 3, 0}, {0, 7, 0}});
  EXPECT_NE(c.cache.find({0, 7, 0}), nullptr);
  EXPECT_EQ(c.cache.find({0, 2, 0}), nullptr);
  EXPECT_NE(c.cache.find({0, 1, 0}), nullptr);
  EXPECT_NE(c.cache.find({9, 0, 0}), nullptr);
  // All are looked at: what comes finds no room.
  c.frame({{0, 1, 0}, {0, 3, 0}, {0, 7, 0}, {0, 8, 0}});
  c.frame({{0, 1, 0}, {0, 3, 0}, {0, 7, 0}, {0, 8, 0}});
  EXPECT_EQ(c.cache.find({0, 8, 0}), nullptr);
  EXPECT_EQ(c.cache.counts().dropped, 1u);
  EXPECT_NE(c.cache.find({0, 7, 0}), nullptr);
}

TEST(TileCache, WhatFailedIsAskedForAgain) {
  Cache c(4);
  c.answers.fails = true;
  c.frame({{0, 1, 0}});
  c.frame({{0, 1, 0}});
  EXPECT_EQ(c.cache.counts().failed, 1u);
  EXPECT_EQ(c.answers.asked.size(), 1u);
  c.answers.fails = false;
  c.frame({{0, 1, 0}});
  EXPECT_NE(c.cache.find({0, 1, 0}), nullptr);
}

TEST(FamilyPool, KeepsWhatTheLastFramesSaw) {
  std::vector<FamilyPool::Family> families(3);
  std::vector<std::uint32_t> chains(3);
  std::vector<PageTexel> texels(12);
  FamilyPool pool;
  pool.create({families, chains, texels, {}});
  pool.reset();
  pool.begin_frame();
  const std::uint32_t a = pool.see({1, 0, 0});
  const std::uint32_t b = pool.see({1, 1, 0});
  const std::uint32_t c = pool.see({2, 0, 0});
  EXPECT_EQ(std::set({a, b, c}).size(), 3u);
  EXPECT_EQ(pool.see({1, 0, 0}), a);
  pool.set_filled(a, 2);
  EXPECT_TRUE(pool.is_filled(a, 2));
  EXPECT_FALSE(pool.is_filled(a, 1));
  EXPECT_EQ(pool.see({1, 5, 5}), FamilyPool::kNone);
  for (std::uint32_t frame = 0; frame < kFramesInFlight; ++frame) {
    pool.begin_frame();
    EXPECT_EQ(pool.see({1, 1, 0}), b);
    EXPECT_EQ(pool.see({2, 0, 0}), c);
    EXPECT_EQ(pool.see({1, 5, 5}), FamilyPool::kNone) << "the GPU may draw what gave way";
  }
  pool.begin_frame();
  EXPECT_EQ(pool.see({1, 1, 0}), b);
  EXPECT_EQ(pool.see({1, 5, 5}), a);
  EXPECT_FALSE(pool.is_filled(a, 2));
  EXPECT_EQ(pool.key(a), (NodeKey{1, 5, 5}));
}

TEST(FamilyRow, EachVertexHasTheClassOfItsPlaceInTheParent) {
  std::vector<std::uint8_t> entries(kMorphEntries, 99);
  build_family_entries(entries);
  const auto at = [&](int quadrant, int south, int east) {
    return entries[(kFirstGroundPlace + static_cast<std::size_t>(quadrant)) * kPageVertices +
                   static_cast<std::size_t>(vertex_order(kNodeLevel, south, east))];
  };
  // Quadrants: 0 north-west, 1 north-east, 2 south-west, 3 south-east.
  EXPECT_EQ(at(0, 0, 0), family_corner(0));
  EXPECT_EQ(at(2, 4, 0), family_corner(1));
  EXPECT_EQ(at(3, 4, 4), family_corner(2));
  EXPECT_EQ(at(1, 0, 4), family_corner(3));
  EXPECT_EQ(at(0, 2, 0), family_edge(0));
  EXPECT_EQ(at(2, 4, 4), family_edge(1));
  EXPECT_EQ(at(3, 1, 4), family_edge(2));
  EXPECT_EQ(at(1, 0, 0), family_edge(3));
  EXPECT_EQ(at(0, 4, 4), kFamilyInside);
  EXPECT_EQ(at(3, 0, 0), kFamilyInside);
  EXPECT_EQ(at(1, 2, 2), kFamilyInside);
  EXPECT_EQ(entries[0], 99);
}

TEST(WallIndices, RunAlongTheEdgesOfTheSlot) {
  constexpr int n = kNodeQuads;
  for (int edge = 0; edge < 4; ++edge) {
    for (int s = 0; s <= n; ++s) {
      const int along[4][2] = {{s, 0}, {n, s}, {n - s, n}, {0, n - s}};
      const auto vertex =
          static_cast<std::uint16_t>(vertex_order(kNodeLevel, along[edge][0], along[edge][1]));
      constexpr std::size_t kAt[kNodeSide] = {0, 2, 5, 11, 14};
      EXPECT_EQ(kWallIndices[static_cast<std::size_t>(edge)][kAt[s]], vertex);
    }
    EXPECT_EQ(kWallIndices[static_cast<std::size_t>(edge)][1], kNodeVertices + edge);
    EXPECT_EQ(kWallIndices[static_cast<std::size_t>(edge)][8], kNodeVertices + (edge + 1) % 4);
  }
  EXPECT_EQ(wall_index_count(0b1011), 3 * kIndicesPerWall);
}

TEST(MakeNode, PlacesAreThoseOfTheSamplesAndNormalsOfTheSize) {
  // A plane that rises a step for each two to the east, and four for each to the south.
  const auto height = [](std::int64_t i, std::int64_t k) {
    return static_cast<std::int32_t>(512 * i + 4096 * k);
  };
  const MemoryGround ground(70, 70, 2048, 2048, height, [](NodeKey) { return 1.0f; });
  for (const NodeKey node : {NodeKey{0, 3, 5}, NodeKey{2, 1, 2}}) {
    const Tile& tile = ground.tile(tile_of(node));
    std::array<GpuVertex, kNodePageVertices> vertices;
    MakeNode{&ground.info(), &tile, node, true, vertices}.run();
    const glm::ivec3 origin = node_origin(ground.info(), tile.nodes[node_in_tile(node)], node);
    const std::uint16_t normal = encode_octahedral({-1024.0f, 2048.0f, -8192.0f});
    for (int south = 0; south < kNodeSide; ++south) {
      for (int east = 0; east < kNodeSide; ++east) {
        const GpuVertex& v = vertices[static_cast<std::size_t>(vertex_order(kNodeLevel, south, east))];
        const std::int64_t i = (node.x * 4 + east) << node.size;
        const std::int64_t k = (node.z * 4 + south) << node.size;
        const glm::vec3 at =
            node_place({0, 0, 0}, node.size, origin, {v.position[0], v.position[1], v.position[2]});
        EXPECT_EQ(at, glm::vec3(2048.0f * static_cast<float>(i), 2.0f * static_cast<float>(height(i, k)),
                                2048.0f * static_cast<float>(k)));
        const glm::vec3 to = node_place({0, 0, 0}, node.size, origin, {v.morph[0], v.morph[1], v.morph[2]});
        EXPECT_EQ(at, to) << "a plane stays where it is";
        EXPECT_EQ(v.normal, normal);
        EXPECT_EQ(v.morph_normal, normal);
      }
    }
  }
}

}  // namespace
}  // namespace karst::core
