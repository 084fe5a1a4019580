// SPDX-License-Identifier: MIT
// Tiles of the ground that edits have changed, in a pool of fixed size over the file's: a source of tiles,
// for frames and for queries, that answers with the edited tile where there is one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "terrain/base/arena.h"
#include "terrain/base/config.h"
#include "terrain/ground/measure_ground.h"
#include "terrain/ground/tile.h"
#include "terrain/paging/tile_slots.h"
#include "terrain/paging/tile_source.h"
#include "terrain/query/query_ground.h"

namespace karst::core {

// Of a node, what its own samples give of its threshold and its neighbours' (NodeRow).
struct NodeParts {
  float most[kBands] = {};
  float border[4] = {};
  float tall = 0;
};

// How far heights of a node's samples are from the file's: least, 0 or less, and greatest; kVertexStep.
struct HeightChange {
  std::int32_t low = 0;
  std::int32_t high = 0;

  bool exists() const { return low != 0 || high != 0; }
};

struct EditedTile {
  Tile tile;
  NodeParts parts[kTileMeasures];
  HeightChange changes[kTileMeasures];
  std::uint64_t known[kTileMeasures / 64] = {};  // bit n: parts of node n are there
  NodeKey key;
  std::int32_t next = -1;   // of its chain in the table
  std::uint64_t stamp = 0;  // the update that changed it last
  // Blocks of its samples that the part of the undo log of that number has (EditGround::kBlock); bit 5 z + x.
  std::uint64_t part = 0;
  std::uint32_t kept = 0;

  bool knows(int node) const { return (known[node >> 6] >> (node & 63) & 1u) != 0; }
  void know(int node) { known[node >> 6] |= std::uint64_t{1} << (node & 63); }
  void forget(int node) { known[node >> 6] &= ~(std::uint64_t{1} << (node & 63)); }
};

class GroundOverlay {
 public:
  struct Storage {
    std::span<EditedTile> tiles;
    std::span<std::int32_t> chains;  // as many

    template <class Visit>
    void each_block(std::size_t count, Visit&& visit) {
      visit(Consumer::ground, count, tiles);
      visit(Consumer::ground, count, chains);
    }
  };
  GroundOverlay() = default;
  GroundOverlay(const GroundOverlay&) = delete;
  GroundOverlay& operator=(const GroundOverlay&) = delete;

  // Storage may be empty: then all tiles are the file's.
  void create(const Storage& storage) { storage_ = storage; }
  // Nothing is edited. Both are borrowed until the next reset().
  void reset(const TileSource& file, const TileReading& reading);

  // Both borrow this.
  TileSource source();
  TileReading reading() const;

  // Null: it is as in the file.
  const EditedTile* find(NodeKey key) const;
  EditedTile* find(NodeKey key) {
    return const_cast<EditedTile*>(static_cast<const GroundOverlay*>(this)->find(key));
  }
  // It stays until reset(). Preconditions: it is not there, and room() > 0.
  EditedTile& add(NodeKey key, const Tile& file);

  // In the order in which they were added.
  std::span<const EditedTile> tiles() const { return storage_.tiles.first(count_); }
  std::size_t room() const { return storage_.tiles.size() - count_; }
  std::size_t capacity() const { return storage_.tiles.size(); }

 private:
  std::int32_t& chain_of(NodeKey key) const;
  bool ask(NodeKey tile, const TilePlace& place);
  TileSource::Answer poll(NodeKey& tile, Tile& out);
  void wait();

  Storage storage_;
  std::size_t count_ = 0;
  TileSource file_;
  TileReading file_reading_;
  // Edited ones that were asked for and not answered yet.
  std::array<NodeKey, TileSlots::kMostUnderWay> asked_{};
  std::size_t asked_count_ = 0;
};

}  // namespace karst::core
