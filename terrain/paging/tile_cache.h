// SPDX-License-Identifier: MIT
// Tiles of the ground in memory of fixed size (tile_slots.h). Nothing here waits for the source but wait().
#pragma once

#include <cstdint>
#include <span>

#include "terrain/paging/tile_slots.h"

namespace karst::core {

class TileCache {
 public:
  struct Storage {
    std::span<Tile> tiles;
    TileSlots::Storage slots;  // as many

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      visit(Consumer::ground, config.ground_tiles, tiles);
      slots.each_block(Consumer::ground, config.ground_tiles, visit);
    }
  };
  void create(const Storage& storage) {
    tiles_ = storage.tiles;
    slots_.create(storage.slots, TileSlots::kMostUnderWay);
  }

  // Empties the cache but for the root's tile, which stays. source: borrowed. Precondition: room for a tile.
  void reset(const TileSource& source, NodeKey root, const Tile& root_tile);

  void begin_frame() { slots_.begin_frame(); }
  // It stays where it is.
  const Tile& root() const { return tiles_[0]; }
  // Null where it is not there. Valid until poll().
  const Tile* find(NodeKey tile) {
    const std::int32_t at = slots_.find(tile);
    return at < 0 ? nullptr : &tiles_[static_cast<std::size_t>(at)];
  }
  // The same for what will be looked at: what is looked at goes before it.
  const Tile* find_ahead(NodeKey tile) {
    const std::int32_t at = slots_.find_ahead(tile);
    return at < 0 ? nullptr : &tiles_[static_cast<std::size_t>(at)];
  }
  // Other contents of a tile, where it is there: the root's too.
  void replace(NodeKey tile, const Tile& contents) {
    const std::int32_t at = slots_.peek(tile);
    if (at >= 0) tiles_[static_cast<std::size_t>(at)] = contents;
  }
  // That this one is lacking; urgency: the greater the sooner. It is not there.
  void want(NodeKey tile, const TilePlace& place, float urgency) { slots_.want(tile, place, urgency); }
  // As TileSlots.
  void ask(bool all = true) { slots_.ask(source_.ask, source_.context, all); }
  std::uint32_t ask_ahead(std::uint32_t most) { return slots_.ask_ahead(source_.ask, source_.context, most); }
  double frames_to_come() const { return slots_.frames_to_come(); }
  std::uint32_t room_ahead() const { return slots_.room_ahead(); }
  // Takes what came, one at most or all. Returns how many tiles.
  std::uint32_t poll(bool one = false);
  // Waits for the source. False: nothing is under way.
  bool wait();

  using Counts = TileSlots::Counts;
  const Counts& counts() const { return slots_.counts(); }

  static constexpr std::size_t kMostWants = TileSlots::kMostWants;  // a frame
  static constexpr std::size_t kMostUnderWay = TileSlots::kMostUnderWay;

 private:
  std::span<Tile> tiles_;  // by slot
  TileSlots slots_;
  TileSource source_;
  Tile came_;  // what a poll brought, before it is known to have room
};

}  // namespace karst::core
