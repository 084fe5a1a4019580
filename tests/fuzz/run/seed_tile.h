// SPDX-License-Identifier: MIT
// A small ground and its tiles that mutations start from.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>

#include "terrain/ground/tile.h"
#include "terrain/lod/morph.h"
#include "tiles/tile_bytes.h"

namespace karst {

inline constexpr std::uint64_t kSeedTileOffset = 5'000;
inline constexpr std::uint64_t kSeedImageOffset = 1 << 20;

inline core::GroundInfo seed_ground() {
  core::GroundInfo info;
  info.samples[0] = 150;
  info.samples[1] = 100;
  info.steps[0] = info.steps[1] = 2048;
  info.low = -500;
  info.high = 9'000;
  return info;
}

// That at the south-east corner, which nodes are missing from.
inline core::NodeKey seed_tile_key(int size) {
  return {size, 2 >> size, 1 >> size};
}

inline core::Tile seed_tile(int size) {
  const core::NodeKey key = seed_tile_key(size);
  core::Tile tile{};
  for (int n = 0; n < core::kTileSamples; ++n) tile.heights[n] = 7 * (n % 113) + 5 * (n / 69);
  for (int n = 0; n < core::kTileMeasures; ++n) {
    if (!core::node_exists(seed_ground(), tiles::node_of_tile(key, n))) continue;
    const tiles::Range own = tiles::range_of_node(tile.heights, n);
    core::NodeMeasure& measure = tile.nodes[n];
    measure.low = size > 0 ? own.low - n : own.low;
    measure.high = size > 0 ? own.high + n : own.high;
    for (int d = 0; d < core::kDemands && size > 0; ++d)
      measure.thresholds[d] = static_cast<std::uint16_t>(core::kLeastThreshold + 3 * n + 200 * d);
  }
  for (int quadrant = 0; quadrant < 4 && size > 0; ++quadrant) {
    if (tiles::tile_exists(seed_ground(), key.child(quadrant))) tile.children[quadrant] = {10, 900, 77};
  }
  return tile;
}

}  // namespace karst
