// SPDX-License-Identifier: MIT
// A tile of the ground to bytes of a world file; decode_tile() makes the same tile of them again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "terrain/ground/tile.h"

namespace karst::tiles {

using namespace core;

// Keeps memory from tile to tile; one for each thread.
class TileEncoder {
 public:
  TileEncoder();
  TileEncoder(const TileEncoder&) = delete;
  TileEncoder& operator=(const TileEncoder&) = delete;
  ~TileEncoder();

  // tile: as decode_tile() takes it. quantum: kVertexStep; heights are probably round(count * quantum) of
  // whole counts; 1 or less: nothing is known of them. out: replaced, kMostTileBytes at most.
  void run(NodeKey key, const GroundInfo& info, const Tile& tile, double quantum,
           std::vector<std::byte>& out);

 private:
  struct Room;
  std::unique_ptr<Room> room_;
};

}  // namespace karst::tiles
