// SPDX-License-Identifier: MIT
// A tile: the unit in which a ground is stored and read. It holds the nodes of one size that lie in a square
// of kTileNodes x kTileNodes of them, with what drawing them takes: their samples, a rim of kTileRim samples
// around for normals, and what was measured of them.
//
// Tile (s, x, z) has nodes (s, kTileNodes x .., kTileNodes z ..). All of the children of a node lie in one
// tile of the next smaller size, and a tile's children in up to four.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "terrain/ground/demand.h"
#include "terrain/ground/ground.h"

namespace karst::core {

inline constexpr int kTileNodes = 16;
inline constexpr int kTileQuads = kTileNodes * kNodeQuads;       // 64
inline constexpr int kTileRim = 2;                               // samples
inline constexpr int kTileSide = kTileQuads + 1 + 2 * kTileRim;  // 69
inline constexpr int kTileSamples = kTileSide * kTileSide;       // 4,761
inline constexpr int kTileMeasures = kTileNodes * kTileNodes;    // 256

// What is measured of a node. 32 bytes.
struct NodeMeasure {
  // D of ground_view.h, over 2^size, at the demands of demand.h, as halves in the unit of morph.h, rounded
  // up; rising. 0 of size 0.
  std::uint16_t thresholds[kDemands] = {};
  // Least and greatest height of the samples in the node, its border included; kVertexStep.
  std::int32_t low = 0;
  std::int32_t high = 0;

  friend bool operator==(const NodeMeasure&, const NodeMeasure&) = default;
};
static_assert(sizeof(NodeMeasure) == 32);

// Where a tile lies in its source. bytes 0: there is none.
struct TilePlace {
  std::uint64_t offset = 0;
  std::uint32_t bytes = 0;
  std::uint32_t crc = 0;

  bool exists() const { return bytes != 0; }
  friend bool operator==(const TilePlace&, const TilePlace&) = default;
};
static_assert(sizeof(TilePlace) == 16);

// A tile in memory; 27,304 bytes.
struct Tile {
  // Heights in kVertexStep, row by row from the north, west first: that of the grid vertex (i, k) of the size
  // at (k - first_k + kTileRim) * kTileSide + (i - first_i + kTileRim), first being kTileQuads x (or z).
  // Samples beyond the ground's are those at its edge.
  std::int32_t heights[kTileSamples];
  NodeMeasure nodes[kTileMeasures];  // row by row; zeros where there is no node
  TilePlace children[4];             // by quadrant: bit 0 east, bit 1 south; of size 0 none exists

  std::int32_t height(int i, int k) const {  // from -kTileRim to kTileQuads + kTileRim
    return heights[(k + kTileRim) * kTileSide + i + kTileRim];
  }
};

// The tile that a node lies in, as a key of tiles, and the node's place in it.
inline NodeKey tile_of(NodeKey node) {
  return {node.size, node.x >> 4, node.z >> 4};
}
inline int node_in_tile(NodeKey node) {
  return (node.z & (kTileNodes - 1)) * kTileNodes + (node.x & (kTileNodes - 1));
}
static_assert(kTileNodes == 1 << 4);

}  // namespace karst::core
