// SPDX-License-Identifier: MIT
// What a tile's frame holds, made of the tile: for all that encode.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "tiles/tile_bytes.h"

namespace karst::tiles {

class TileContents {
 public:
  // tile: as decode_tile() takes it, but for its children, which lie at `children`. quantum: kVertexStep;
  // heights are probably round(count * quantum) of whole counts; 1 or less: nothing is known of them.
  // contents_bytes() of the tile's size, until the next call.
  std::span<const std::byte> make(NodeKey key, const GroundInfo& info, const Tile& tile,
                                  std::span<const TilePlace, 4> children, double quantum);

 private:
  bool count(const Tile& tile, double quantum);
  void store_heights();
  void store_measures(NodeKey key, const GroundInfo& info, const Tile& tile);

  std::int32_t counts_[kTileSamples];
  std::int32_t lows_[kTileMeasures], highs_[kTileMeasures];
  std::byte bytes_[kMostContents];
};

}  // namespace karst::tiles
