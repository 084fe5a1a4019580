// SPDX-License-Identifier: MIT
// Which tile is in which of a fixed number of slots, and which are to be asked for: what a cache of tiles
// has, whatever it keeps in its slots. What a frame wants and lacks is asked for most urgent first, and then
// what it will lack soon; what it does not look at for longest gives way.
//
//   slots.begin_frame();
//   while (a source answers with key) if (slot = slots.take(key, answer); slot >= 0) fill the slot
//   if (slots.find(key) < 0) slots.want(key, place, urgency);
//   slots.ask(source.ask, source.context);
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "terrain/base/arena.h"
#include "terrain/base/config.h"
#include "terrain/motion/read_pace.h"
#include "terrain/paging/tile_source.h"

namespace karst::core {

struct TileSlot {
  NodeKey key;
  std::uint32_t last_used = 0;   // frame
  std::uint32_t last_ahead = 0;  // in which it was found to be needed soon
  std::int32_t next = -1;        // of its chain in the table
  bool used = false;
  bool ahead = false;  // asked for ahead, and not looked at since
};

class TileSlots {
 public:
  struct Storage {
    std::span<TileSlot> slots;
    std::span<std::int32_t> chains;  // as many, a power of two or not

    template <class Visit>
    void each_block(Consumer consumer, std::size_t count, Visit&& visit) {
      visit(consumer, count, slots);
      visit(consumer, count, chains);
    }
  };
  struct Counts {
    std::uint32_t wanted = 0;  // in the last frame, as far as they were counted (most wants)
    std::uint32_t under_way = 0;
    std::uint64_t came = 0, failed = 0, dropped = 0;  // since reset(); dropped: no room when they came
    bool failing = false;                             // the last one that was answered
    bool full = false;                                // the last one that came found no room
    AheadCounts ahead;                                // since reset()
  };
  static constexpr std::size_t kMostWants = 64;  // a frame
  static constexpr std::size_t kMostUnderWay = 32;

  // most_under_way: at most kMostUnderWay.
  void create(const Storage& storage, std::size_t most_under_way) {
    storage_ = storage;
    most_under_way_ = most_under_way;
  }

  // Begins anew, without anything. Precondition: there is a slot.
  void reset();
  // Empties all slots; what is under way stays so.
  void forget();
  // Puts a tile into slot 0, where it stays. Precondition: nothing is there.
  void pin(NodeKey key);

  void begin_frame();
  std::span<const TileSlot> slots() const { return storage_.slots; }
  // The slot that a tile is in, which the frame looks at; -1: none. Valid until take().
  std::int32_t find(NodeKey key);
  // The same for what will be looked at: what is looked at goes before it.
  std::int32_t find_ahead(NodeKey key);
  // The same without looking at it.
  std::int32_t peek(NodeKey key) { return slot_of(key); }
  // That this one is lacking; urgency: the greater the sooner. It is not there.
  void want(NodeKey key, const TilePlace& place, float urgency);
  // Asks for what was wanted since the last time. asks: as a source has it, with its context; null: for
  // nothing. all: for as much as it takes, to be waited for; else for what comes in the next frames.
  using Asks = bool (*)(void* context, NodeKey key, const TilePlace& place);
  void ask(Asks asks, void* context, bool all = true);
  // The same as for what will be lacking. most: how many more may be under way. Returns how many were asked
  // for.
  std::uint32_t ask_ahead(Asks asks, void* context, std::uint32_t most);
  // Frames until what is asked for now will come.
  double frames_to_come() const { return pace_.frames_to_come(counts_.under_way); }
  // How many more may be asked for ahead.
  std::uint32_t room_ahead() const;
  // What a source answered. The slot that the tile is to be put into; -1: none: it failed, nobody asked for
  // it, it is there already or there is no room.
  std::int32_t take(NodeKey key, TileSource::Answer answer);

  const Counts& counts() const { return counts_; }

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
  std::int32_t slot_of(NodeKey key);
  void put(NodeKey key, std::int32_t slot);
  std::int32_t make_room(bool ahead);
  void unlink(std::int32_t slot);
  UnderWay* find_under_way(NodeKey key);
  std::uint32_t ask_for_wants(Asks asks, void* context, std::size_t most, bool ahead);

  Storage storage_;
  std::size_t most_under_way_ = 0;
  std::size_t pinned_ = 0;  // slots, from the first
  std::uint32_t frame_ = 0;
  std::array<Want, kMostWants> wants_{};
  std::size_t want_count_ = 0;
  std::array<UnderWay, kMostUnderWay> under_way_{};
  ReadPace pace_;
  Counts counts_;
};

}  // namespace karst::core
