// SPDX-License-Identifier: MIT
// Which image tile lies in which layer of the GPU's array. What a frame asks for and lacks is asked of the
// source, most urgent first; what it does not look at for longest gives way. Nothing here waits for the
// source but wait().
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "terrain/base/arena.h"
#include "terrain/base/config.h"
#include "terrain/imagery/image_source.h"

namespace karst::core {

class ImageCache {
 public:
  struct Entry {
    NodeKey key;
    ImageChildren children;
    std::uint32_t last_used = 0;  // frame
    std::int32_t next = -1;       // of its chain in the table
    bool used = false;
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
  // That this one is lacking; urgency: the greater the sooner. It is not there.
  void want(NodeKey key, const TilePlace& place, float urgency);
  // Asks the source for what was wanted since the last time.
  void ask();
  // Takes one that came: true, and the layer that its texels are to be copied to before the next poll().
  bool poll(std::int32_t& layer, ImageArrival& out);
  // Waits for the source. False: nothing is under way.
  bool wait();

  struct Counts {
    std::uint32_t under_way = 0;
    std::uint64_t came = 0, failed = 0, dropped = 0;  // since reset(); dropped: no room when they came
    bool failing = false;                             // the last one that was answered
    bool full = false;                                // the last one that came found no room
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

  std::int32_t& chain_of(NodeKey key);
  std::int32_t find_entry(NodeKey key);
  std::int32_t make_room();
  void unlink(std::int32_t entry);

  Storage storage_;
  ImageSource source_;
  NodeKey root_;
  TilePlace root_place_;
  std::uint32_t frame_ = 0;
  std::uint64_t version_ = 0;
  std::array<Want, kMostWants> wants_{};
  std::size_t want_count_ = 0;
  std::array<NodeKey, kMostUnderWay> under_way_{};
  Counts counts_;
};

}  // namespace karst::core
