// SPDX-License-Identifier: MIT
// A tile as bytes, between encode_tile.cpp and decode_tile.cpp; docs/formats.md has it byte by byte.
//
// Heights are counts of a quantum, so that a DEM of whole metres does not cost the bits of its lattice. A
// count is predicted from its neighbours to the west and north by the median of the two and of the plane
// through them (M. Weinberger, G. Seroussi, G. Sapiro, "The LOCO-I lossless image compression algorithm",
// 2000); what is left goes into byte planes, and those through zstd.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "terrain/ground/tile.h"

namespace karst::tiles {

using namespace core;

// Offsets of what zstd holds. A plane of n values is n bytes.
inline constexpr std::size_t kQuantum = 0;   // f64
inline constexpr std::size_t kChildren = 8;  // 4 TilePlaces
inline constexpr std::size_t kHeights = 72;  // 4 planes of kTileSamples
inline constexpr std::size_t kMeasures = kHeights + 4 * std::size_t{kTileSamples};
inline constexpr std::size_t kLows = kMeasures;  // of size 1 and more: 4 planes of kTileMeasures each
inline constexpr std::size_t kHighs = kLows + 4 * std::size_t{kTileMeasures};
// 2 planes of kTileMeasures for each demand.
inline constexpr std::size_t kThresholds = kHighs + 4 * std::size_t{kTileMeasures};
inline constexpr std::size_t kMostContents = kThresholds + 2 * kDemands * std::size_t{kTileMeasures};

constexpr std::size_t contents_bytes(int size) {
  return size == 0 ? kMeasures : kMostContents;
}

// kVertexStep; 1: heights are counted as they are.
inline constexpr double kMostQuantum = kMostHeight;

// Of a count; exact, since a double holds the product's rounding alone.
inline double height_of(std::int64_t count, double quantum) {
  return std::floor(static_cast<double>(count) * quantum + 0.5);
}

constexpr std::uint32_t zigzag(std::int32_t value) {
  return static_cast<std::uint32_t>(value) << 1 ^ static_cast<std::uint32_t>(value >> 31);
}
constexpr std::int32_t from_zigzag(std::uint32_t value) {
  return static_cast<std::int32_t>(value >> 1 ^ (0u - (value & 1)));
}

// Without overflow for counts within +-2^29.
inline std::int32_t predict(std::int32_t west, std::int32_t north, std::int32_t north_west) {
  const std::int32_t least = std::min(west, north);
  const std::int32_t most = std::max(west, north);
  return std::clamp(west + north - north_west, least, most);
}

// Sample n of a tile from those before it, row by row.
inline std::int32_t predict_sample(const std::int32_t* counts, int n) {
  const int i = n % kTileSide;
  if (i > 0 && n >= kTileSide)
    return predict(counts[n - 1], counts[n - kTileSide], counts[n - kTileSide - 1]);
  return n == 0 ? 0 : counts[i > 0 ? n - 1 : n - kTileSide];
}

template <std::size_t kPlanes = 4>
void put_planes(std::byte* planes, std::size_t count, std::size_t at, std::uint32_t value) {
  for (std::size_t k = 0; k < kPlanes; ++k) planes[k * count + at] = static_cast<std::byte>(value >> (8 * k));
}
template <std::size_t kPlanes = 4>
std::uint32_t take_planes(const std::byte* planes, std::size_t count, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t k = 0; k < kPlanes; ++k)
    value |= std::to_integer<std::uint32_t>(planes[k * count + at]) << (8 * k);
  return value;
}

// The planes of a demand's rises of thresholds, predicted from nodes to the west and north as counts are.
constexpr std::size_t thresholds_at(int demand) {
  return kThresholds + 2 * static_cast<std::size_t>(demand) * std::size_t{kTileMeasures};
}
// By how much a node's threshold at a demand is above that at the one before.
inline std::int32_t rise_of(const NodeMeasure& measure, int demand) {
  return measure.thresholds[demand] - (demand > 0 ? measure.thresholds[demand - 1] : 0);
}
// From the rises of nodes before it.
inline std::int32_t predict_rise(const NodeMeasure* nodes, int node, int demand) {
  const bool has_west = node % kTileNodes > 0;
  const bool has_north = node >= kTileNodes;
  const auto rise = [&](int before) { return rise_of(nodes[node - before], demand); };
  if (has_west && has_north) return predict(rise(1), rise(kTileNodes), rise(kTileNodes + 1));
  return has_west ? rise(1) : has_north ? rise(kTileNodes) : 0;
}

struct Range {
  std::int32_t low = 0;
  std::int32_t high = 0;
};
// Least and greatest of the 25 samples of a node in a tile's samples, or in as many counts.
inline Range range_of_node(const std::int32_t* samples, int node) {
  const int first_i = node % kTileNodes * kNodeQuads + kTileRim;
  const int first_k = node / kTileNodes * kNodeQuads + kTileRim;
  const std::int32_t* row = samples + first_k * kTileSide + first_i;
  Range range{row[0], row[0]};
  for (int k = 0; k < kNodeSide; ++k, row += kTileSide) {
    for (int i = 0; i < kNodeSide; ++i) {
      range.low = std::min(range.low, row[i]);
      range.high = std::max(range.high, row[i]);
    }
  }
  return range;
}

inline NodeKey node_of_tile(NodeKey tile, int node) {
  return {tile.size, tile.x * kTileNodes + node % kTileNodes, tile.z * kTileNodes + node / kTileNodes};
}
// Whether a tile has any node.
inline bool tile_exists(const GroundInfo& info, NodeKey tile) {
  if (info.is_cube()) {
    // Where faces are smaller than tiles, the first node may lie beside them.
    const int face_nodes = 1 << std::max(0, info.top_size() - tile.size);
    if (face_nodes < kTileNodes) {
      for (int node = 0; node < kTileMeasures; ++node) {
        if (node_exists(info, node_of_tile(tile, node))) return true;
      }
      return false;
    }
  }
  return node_exists(info, {tile.size, tile.x * kTileNodes, tile.z * kTileNodes});
}

}  // namespace karst::tiles
