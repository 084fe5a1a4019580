// SPDX-License-Identifier: MIT
// Which image tile lies in which layer of the GPU's array. What a frame asks for and lacks is asked of the
// source, most urgent first, and then what it will lack soon; what it does not look at for longest gives way.
// Nothing here waits for the source but wait().
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "terrain/base/arena.h"
#include "terrain/base/config.h"
#include "terrain/imagery/image_source.h"
#include "terrain/motion/read_pace.h"

namespace karst::core {

class ImageCache {
 public:
  struct Entry {
    NodeKey key;
    ImageChildren children;
    std::uint32_t last_used = 0;   // frame
    std::uint32_t last_ahead = 0;  // in which it was found to be needed soon
    std::int32_t next = -1;        // of its chain in the table
    bool used = false;
    bool ahead = false;  // asked for ahead, and not looked at since
  };

  struct Storage {
    std::span<Entry> entries;        // by layer
    std::span<std::int32_t> chains;  // as many

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      visit(Consumer::imagery, config.image_layers, entries);
      visit(Consumer::imagery, config.image_layers, chains);
    }
  };
  void create(const Storage& storage) { storage_ = storage; }

  // Empties the cache. source: borrowed. root: where the root's tile lies. Precondition: room for a tile.
  void reset(const ImageSource& source, NodeKey root, const TilePlace& root_place);
  // Forgets what is in layers, which are lost; what is under way stays so.
  void forget();

  void begin_frame();
  std::span<const Entry> entries() const { return storage_.entries; }
  NodeKey root() const { return root_; }
  const TilePlace& root_place() const { return root_place_; }
  // The layer that a tile is in, which the frame looks at; -1: none. Valid until poll().
  std::int32_t find(NodeKey key);
  // The same for what will be looked at: what is looked at goes before it.
  std::int32_t find_ahead(NodeKey key);
  // That this one is lacking; urgency: the greater the sooner. It is not there.
  void want(NodeKey key, const TilePlace& place, float urgency);
  // As TileCache's.
  void ask(bool all = true);
  std::uint32_t ask_ahead(std::uint32_t most);
  double frames_to_come() const { return pace_.frames_to_come(counts_.under_way); }
  std::uint32_t room_ahead() const {
    const std::uint32_t depth = pace_.depth(kMostUnderWay);
    return counts_.under_way < depth ? depth - counts_.under_way : 0;
  }
  // Takes one that came: true, and the layer that its texels are to be copied to before the next poll().
  bool poll(std::int32_t& layer, ImageArrival& out);
  // Waits for the source. False: nothing is under way.
  bool wait();

  struct Counts {
    std::uint32_t under_way = 0;
    std::uint64_t came = 0, failed = 0, dropped = 0;  // since reset(); dropped: no room when they came
    bool failing = false;                             // the last one that was answered
    bool full = false;                                // the last one that came found no room
    AheadCounts ahead;                                // since reset()
  };
  const Counts& counts() const { return counts_; }
  // Changes whenever entries do.
  std::uint64_t version() const { return version_; }

  static constexpr std::size_t kMostWants = 32;  // a frame
  static constexpr std::size_t kMostUnderWay = 8;

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

  UnderWay* find_under_way(NodeKey key);
  std::uint32_t ask_for_wants(std::uint32_t most, bool ahead);
  std::int32_t& chain_of(NodeKey key);
  std::int32_t find_entry(NodeKey key);
  std::int32_t make_room(bool ahead);
  void unlink(std::int32_t entry);

  Storage storage_;
  ImageSource source_;
  NodeKey root_;
  TilePlace root_place_;
  std::uint32_t frame_ = 0;
  std::uint64_t version_ = 0;
  std::array<Want, kMostWants> wants_{};
  std::size_t want_count_ = 0;
  std::array<UnderWay, kMostUnderWay> under_way_{};
  ReadPace pace_;
  Counts counts_;
};

}  // namespace karst::core
