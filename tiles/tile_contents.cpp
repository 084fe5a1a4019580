// SPDX-License-Identifier: MIT
#include "tiles/tile_contents.h"

#include <cstring>

#include "terrain/base/check.h"

namespace karst::tiles {
namespace {

// The count that stands for a height, where there is one.
bool count_of(std::int32_t height, double quantum, std::int32_t& count) {
  count = static_cast<std::int32_t>(std::floor(height / quantum + 0.5));
  return height_of(count, quantum) == static_cast<double>(height);
}

}  // namespace

// False where some height is no count of the quantum.
bool TileContents::count(const Tile& tile, double quantum) {
  for (int n = 0; n < kTileSamples; ++n) {
    if (!count_of(tile.heights[n], quantum, counts_[n])) return false;
  }
  for (int n = 0; n < kTileMeasures; ++n) {
    if (!count_of(tile.nodes[n].low, quantum, lows_[n])) return false;
    if (!count_of(tile.nodes[n].high, quantum, highs_[n])) return false;
  }
  return true;
}

void TileContents::store_heights() {
  for (int n = 0; n < kTileSamples; ++n) {
    put_planes(bytes_ + kHeights, kTileSamples, static_cast<std::size_t>(n),
               zigzag(counts_[n] - predict_sample(counts_, n)));
  }
}

void TileContents::store_measures(NodeKey key, const GroundInfo& info, const Tile& tile) {
  for (int node = 0; node < kTileMeasures; ++node) {
    const auto at = static_cast<std::size_t>(node);
    const bool exists = node_exists(info, node_of_tile(key, node));
    const NodeMeasure& measure = tile.nodes[node];
    const Range own = range_of_node(counts_, node);
    KARST_ASSERT(exists || measure == NodeMeasure());
    KARST_ASSERT(!exists || (lows_[node] <= own.low && highs_[node] >= own.high));
    const auto put = [&](std::size_t planes, std::uint32_t value) {
      put_planes(bytes_ + planes, kTileMeasures, at, value);
    };
    put(kLows, exists ? static_cast<std::uint32_t>(own.low - lows_[node]) : 0);
    put(kHighs, exists ? static_cast<std::uint32_t>(highs_[node] - own.high) : 0);
    for (int n = 0; n < kDemands; ++n) {
      const std::int32_t rest = rise_of(measure, n) - predict_rise(tile.nodes, node, n);
      put_planes<2>(bytes_ + thresholds_at(n), kTileMeasures, at, exists ? zigzag(rest) : 0);
    }
  }
}

std::span<const std::byte> TileContents::make(NodeKey key, const GroundInfo& info, const Tile& tile,
                                              std::span<const TilePlace, 4> children, double quantum) {
  if (!(quantum > 1 && quantum <= kMostQuantum) || !count(tile, quantum)) {
    quantum = 1;
    const bool counted = count(tile, quantum);
    KARST_ASSERT(counted);
  }
  std::memcpy(bytes_ + kQuantum, &quantum, sizeof quantum);
  std::memcpy(bytes_ + kChildren, children.data(), children.size_bytes());
  store_heights();
  if (key.size > 0) store_measures(key, info, tile);
  return std::span<const std::byte>(bytes_).first(contents_bytes(key.size));
}

}  // namespace karst::tiles
