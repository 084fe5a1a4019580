// SPDX-License-Identifier: MIT
// Tiles in memory of fixed size. What a frame asks for and lacks is asked of the source, most urgent first,
// and then what it will lack soon; what it does not look at for longest gives way. Nothing here waits for the
// source.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "terrain/base/arena.h"
#include "terrain/base/config.h"
#include "terrain/ground/tile_source.h"
#include "terrain/motion/read_pace.h"

namespace karst::core {

class TileCache {
 public:
  struct Entry {
    NodeKey key;
    std::uint32_t last_used = 0;   // frame
    std::uint32_t last_ahead = 0;  // in which it was found to be needed soon
    std::int32_t next = -1;        // of its chain in the table, or of the free ones
    bool used = false;
    bool ahead = false;  // asked for ahead, and not looked at since
  };

  struct Storage {
    std::span<Tile> tiles;
    std::span<Entry> entries;        // as many
    std::span<std::int32_t> chains;  // as many, a power of two or not

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      visit(Consumer::ground, config.ground_tiles, tiles);
      visit(Consumer::ground, config.ground_tiles, entries);
      visit(Consumer::ground, config.ground_tiles, chains);
    }
  };
  void create(const Storage& storage) { storage_ = storage; }

  // Empties the cache but for the root's tile, which stays. source: borrowed. Precondition: room for a tile.
  void reset(const TileSource& source, NodeKey root, const Tile& root_tile);

  void begin_frame();
  // It stays where it is.
  const Tile& root() const { return storage_.tiles[0]; }
  // Null where it is not there. Valid until poll().
  const Tile* find(NodeKey tile);
  // The same for what will be looked at: what is looked at goes before it.
  const Tile* find_ahead(NodeKey tile);
  // That this one is lacking; urgency: the greater the sooner. It is not there.
  void want(NodeKey tile, const TilePlace& place, float urgency);
  // Asks the source for what was wanted since the last time. all: for as much as it takes, to be waited for;
  // else for what comes in the next frames.
  void ask(bool all = true);
  // The same as for what will be lacking. most: how many more may be under way. Returns how many were asked
  // for.
  std::uint32_t ask_ahead(std::uint32_t most);
  // Frames until what is asked for now will come.
  double frames_to_come() const { return pace_.frames_to_come(counts_.under_way); }
  // How many more may be asked for ahead.
  std::uint32_t room_ahead() const {
    const std::uint32_t depth = pace_.depth(kMostUnderWay);
    return counts_.under_way < depth ? depth - counts_.under_way : 0;
  }
  // Takes what came, one at most or all. Returns how many tiles.
  std::uint32_t poll(bool one = false);
  // Waits for the source. False: nothing is under way.
  bool wait();

  struct Counts {
    std::uint32_t wanted = 0;  // in the last frame, as far as they were counted (kMostWants)
    std::uint32_t under_way = 0;
    std::uint64_t came = 0, failed = 0, dropped = 0;  // since reset(); dropped: no room when they came
    bool failing = false;                             // the last one that was answered
    bool full = false;                                // the last one that came found no room
    AheadCounts ahead;                                // since reset()
  };
  const Counts& counts() const { return counts_; }

  static constexpr std::size_t kMostWants = 64;  // a frame
  static constexpr std::size_t kMostUnderWay = 32;

 private:
  struct Want {
    NodeKey key;
    TilePlace place;
    float urgency = 0;
  };

  struct UnderWay {
    NodeKey key;
    bool ahead = false;  // and not wanted since
  };

  std::int32_t& chain_of(NodeKey key);
  std::int32_t find_entry(NodeKey key);
  std::int32_t make_room(bool ahead);
  void unlink(std::int32_t entry);
  UnderWay* find_under_way(NodeKey key);
  std::uint32_t ask_for_wants(std::uint32_t most, bool ahead);

  Storage storage_;
  TileSource source_;
  std::uint32_t frame_ = 0;
  std::array<Want, kMostWants> wants_{};
  std::size_t want_count_ = 0;
  std::array<UnderWay, kMostUnderWay> under_way_{};
  ReadPace pace_;
  Tile came_;  // what a poll brought, before it is known to have room
  Counts counts_;
};

}  // namespace karst::core
