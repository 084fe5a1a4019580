// SPDX-License-Identifier: MIT
// The ground that benchmarks make: its tiles agree, and what it says of its nodes is true.
#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "bench/ground/synthetic_ground.h"
#include "terrain/file/world_reader.h"
#include "terrain/ground/ground_box.h"
#include "terrain/lod/morph.h"
#include "tests/support/memory_ground.h"

namespace karst::bench {
namespace {

using namespace core;

std::unique_ptr<Tile> tile_at(const SyntheticGround& ground, NodeKey key) {
  auto tile = std::make_unique<Tile>();
  ground.make_tile(key, *tile);
  return tile;
}

TEST(SyntheticGround, TilesAgreeOnWhatTheyShare) {
  const SyntheticGround ground(20);
  const int top = ground.root().size;
  for (const int size : {0, 3, 9, 12}) {
    const int middle = 1 << (top - size - 5);
    for (const int at : {0, middle, middle + 1}) {
      const auto own = tile_at(ground, {size, at, at});
      const auto east = tile_at(ground, {size, at + 1, at});
      const auto above = tile_at(ground, NodeKey{size, at, at}.parent());
      for (int k = 0; k <= kTileQuads; ++k) {
        for (int i = -kTileRim; i <= kTileRim; ++i)
          ASSERT_EQ(own->height(kTileQuads + i, k), east->height(i, k)) << size << ' ' << at;
        for (int i = 0; i <= kTileQuads; ++i) {
          if (i % 2 != 0 || k % 2 != 0) continue;
          const int half = kTileQuads / 2;
          ASSERT_EQ(own->height(i, k), above->height((at & 1) * half + i / 2, (at & 1) * half + k / 2));
        }
      }
    }
  }
}

TEST(SyntheticGround, TheMiddleIsTheSameAtEverySize) {
  const SyntheticGround least(10), most(20);
  const auto first = tile_at(least, {0, 8, 8});
  const auto second = tile_at(most, {0, 8192, 8192});
  for (int n = 0; n < kTileSamples; ++n) ASSERT_EQ(first->heights[n], second->heights[n]);
  for (int n = 0; n < kTileMeasures; ++n) EXPECT_EQ(first->nodes[n], second->nodes[n]);
}

// Beside what the least ground is measured at.
TEST(SyntheticGround, BoundsHold) {
  const SyntheticGround ground(10);
  const GroundInfo& info = ground.info();
  const auto side = static_cast<std::size_t>(info.samples[0]);
  std::vector<std::int32_t> heights(side * side);
  for (std::size_t k = 0; k < side; ++k) {
    for (std::size_t i = 0; i < side; ++i)
      heights[k * side + i] = ground.height(std::int64_t(i) - 512, std::int64_t(k) - 512);
  }
  const test::MemoryGround measured(
      info.samples[0], info.samples[1], info.steps[0], info.steps[1], [&](std::int64_t i, std::int64_t k) {
        return heights[static_cast<std::size_t>(k) * side + static_cast<std::size_t>(i)];
      });
  EXPECT_LE(info.low, measured.info().low);
  EXPECT_GE(info.high, measured.info().high);
  int compared = 0;
  for (int size = 0; size <= info.top_size(); ++size) {
    for (int z = 0; node_exists(info, {size, 0, z * kTileNodes}); ++z) {
      for (int x = 0; node_exists(info, {size, x * kTileNodes, 0}); ++x) {
        const auto tile = tile_at(ground, {size, x, z});
        const Tile& other = measured.tile({size, x, z});
        for (int n = 0; n < kTileSamples; ++n) ASSERT_EQ(tile->heights[n], other.heights[n]);
        for (int n = 0; n < kTileMeasures; ++n) {
          if (!node_exists(info, {size, x * kTileNodes + n % kTileNodes, z * kTileNodes + n / kTileNodes}))
            continue;
          ++compared;
          ASSERT_LE(tile->nodes[n].low, other.nodes[n].low) << size;
          ASSERT_GE(tile->nodes[n].high, other.nodes[n].high) << size;
          for (int d = 0; d < kDemands; ++d)
            ASSERT_GE(tile->nodes[n].thresholds[d], other.nodes[n].thresholds[d]) << size << ' ' << d;
        }
      }
    }
  }
  EXPECT_GT(compared, 80'000);
}

// (2) of terrain/nodes/ground_view.h, with the boxes that views look at.
TEST(SyntheticGround, ThresholdsKeepNeighboursOneSizeApart) {
  const SyntheticGround ground(20);
  const GroundInfo& info = ground.info();
  for (int size = 2; size <= info.top_size(); ++size) {
    const NodeKey middle{size - 1, 1 << (info.top_size() - size), 1 << (info.top_size() - size)};
    const NodeKey above = tile_of(middle.parent());
    const auto own = tile_at(ground, above);
    const auto below = tile_at(ground, tile_of(middle));
    const NodeMeasure& p = own->nodes[node_in_tile(middle.parent())];
    for (int n = 0; n < kTileMeasures; ++n) {
      const NodeKey q{size - 1, tile_of(middle).x * kTileNodes + n % kTileNodes,
                      tile_of(middle).z * kTileNodes + n / kTileNodes};
      if (!node_exists(info, q)) continue;
      const NodeBox box = node_box(info, below->nodes[n], q);
      const glm::dvec3 across = box.high - box.low;
      const double rise = 1.1547005383792517 * std::sqrt(glm::dot(across, across));
      for (int d = 0; d < kDemands; ++d) {
        const double of_p = std::ldexp(threshold_steps(p.thresholds[d]), size);
        const double of_q = std::ldexp(threshold_steps(below->nodes[n].thresholds[d]), size - 1);
        ASSERT_GE((1 - double{kNodeMorphShare}) * of_p, of_q + rise) << size << ' ' << d;
      }
    }
  }
}

TEST(SyntheticGround, ItsFileIsAWorld) {
  const SyntheticGround ground(17);
  const std::vector<std::byte> file = ground.file();
  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
  EXPECT_TRUE(reader.verify().ok());
  EXPECT_EQ(reader.ground().samples[1], 131'073);
}

}  // namespace
}  // namespace karst::bench
