// SPDX-License-Identifier: MIT
// Tiles as the file has them, read at once and kept in a few slots: what edits compare with, and where they
// look at samples that nobody edited.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/arena.h"
#include "terrain/ground/tile.h"
#include "terrain/query/query_ground.h"

namespace karst::core {

class FileTiles {
 public:
  static constexpr std::size_t kTiles = 48;

  struct Slot {
    NodeKey key;
    std::uint64_t last_used = 0;  // 0: empty
  };
  struct Storage {
    std::span<Tile> tiles;
    std::span<Slot> slots;
    std::span<std::byte> workspace;

    template <class Visit>
    void each_block(bool any, std::size_t workspace_bytes, Visit&& visit) {
      visit(Consumer::ground, any ? kTiles : 0, tiles);
      visit(Consumer::ground, any ? kTiles : 0, slots);
      visit(Consumer::ground, any ? workspace_bytes : 0, workspace);
    }
  };
  void create(const Storage& storage) { storage_ = storage; }
  // root: of the tile that all nodes hang from, with its contents.
  void reset(NodeKey root, const Tile& tile, const TileReading& reading);

  // A tile that exists, valid until the next call. Errors of reading.
  Status get(NodeKey key, const Tile*& tile);
  std::uint64_t reads() const { return reads_; }

 private:
  Storage storage_;  // the root's is the first
  NodeKey root_;
  TileReading reading_;
  std::uint64_t clock_ = 0;
  std::uint64_t reads_ = 0;
};

}  // namespace karst::core
