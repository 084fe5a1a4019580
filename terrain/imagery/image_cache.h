// SPDX-License-Identifier: MIT
// Which image tile lies in which layer of the GPU's array (tile_slots.h). Nothing here waits for the source
// but wait().
#pragma once

#include <cstdint>
#include <span>

#include "terrain/imagery/image_source.h"
#include "terrain/paging/tile_slots.h"

namespace karst::core {

class ImageCache {
 public:
  struct Storage {
    std::span<ImageChildren> children;
    TileSlots::Storage slots;  // as many; a slot is a layer

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      visit(Consumer::imagery, config.image_layers, children);
      slots.each_block(Consumer::imagery, config.image_layers, visit);
    }
  };
  void create(const Storage& storage) {
    children_ = storage.children;
    slots_.create(storage.slots, kMostUnderWay);
  }

  // Empties the cache. source: borrowed. root: where the root's tile lies. Precondition: room for a tile.
  void reset(const ImageSource& source, NodeKey root, const TilePlace& root_place);
  // Forgets what is in layers, which are lost; what is under way stays so.
  void forget();

  void begin_frame() { slots_.begin_frame(); }
  std::span<const TileSlot> layers() const { return slots_.slots(); }
  NodeKey root() const { return root_; }
  const TilePlace& root_place() const { return root_place_; }
  // The layer that a tile is in, which the frame looks at; -1: none. Valid until poll().
  std::int32_t find(NodeKey key) { return slots_.find(key); }
  // The same for what will be looked at: what is looked at goes before it.
  std::int32_t find_ahead(NodeKey key) { return slots_.find_ahead(key); }
  // Where the children of the tile in a layer lie.
  const ImageChildren& children(std::int32_t layer) const {
    return children_[static_cast<std::size_t>(layer)];
  }
  // That this one is lacking; urgency: the greater the sooner. It is not there.
  void want(NodeKey key, const TilePlace& place, float urgency) { slots_.want(key, place, urgency); }
  // As TileSlots.
  void ask(bool all = true) { slots_.ask(source_.ask, source_.context, all); }
  std::uint32_t ask_ahead(std::uint32_t most) { return slots_.ask_ahead(source_.ask, source_.context, most); }
  double frames_to_come() const { return slots_.frames_to_come(); }
  std::uint32_t room_ahead() const { return slots_.room_ahead(); }
  // Takes one that came: true, and the layer that its texels are to be copied to before the next poll().
  bool poll(std::int32_t& layer, ImageArrival& out);
  // Waits for the source. False: nothing is under way.
  bool wait();

  const TileSlots::Counts& counts() const { return slots_.counts(); }
  // Changes whenever layers do.
  std::uint64_t version() const { return version_; }

  static constexpr std::size_t kMostUnderWay = 8;

 private:
  std::span<ImageChildren> children_;  // by layer
  TileSlots slots_;
  ImageSource source_;
  NodeKey root_;
  TilePlace root_place_;
  std::uint64_t version_ = 0;
};

}  // namespace karst::core
