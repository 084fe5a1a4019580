// SPDX-License-Identifier: MIT
// Which families have pages on the GPU. A family is the four children of a node, its key that node; it has
// four pages, one a child, and a row of thresholds. Pages are filled when a child is first drawn. What was
// not seen for longest gives way, but nothing that the last kFramesInFlight frames saw: the GPU may still
// draw it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "terrain/base/arena.h"
#include "terrain/base/config.h"
#include "terrain/ground/ground.h"
#include "terrain/resident/page_table.h"

namespace karst::core {

class FamilyPool {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  struct Family {
    NodeKey key;  // of the parent; size -1: retired
    std::uint32_t last_seen = 0;
    std::uint32_t next = kNone;  // of its chain in the table
    std::uint8_t filled = 0;     // bit q: the page of quadrant q holds its node
    bool used = false;
    std::uint32_t tries = 0;  // begin_tries() before it was made
  };

  struct Storage {
    std::span<Family> families;
    std::span<std::uint32_t> chains;   // as many
    std::span<PageTexel> texels;       // by page, for the renderer
    std::span<PageTexel> places = {};  // the same, where there is imagery

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      visit(Consumer::ground, config.ground_families, families);
      visit(Consumer::ground, config.ground_families, chains);
      const std::size_t pages = 4 * std::size_t{config.ground_families};
      visit(Consumer::ground, pages, texels);
      visit(Consumer::imagery, config.image_layers == 0 ? 0 : pages, places);
    }
  };
  void create(const Storage& storage) { storage_ = storage; }
  // Forgets all.
  void reset();

  void begin_frame() {
    ++frame_;
    has_room_ = true;
    seen_ = 0;
    most_ = count();
    in_flight_ = kFramesInFlight;
  }
  // The GPU has drawn all of the frames before: what this one has not seen may give way.
  void rest() {
    in_flight_ = 0;
    has_room_ = true;
  }
  // From now on the frame sees no more families than leave so many; 0: all there are.
  void leave(std::uint32_t families) { most_ = count() - std::min(families, count()); }
  // Families that the frame has seen, and may see.
  std::uint32_t seen() const { return seen_; }
  std::uint32_t most() const { return most_; }
  // What see() makes until the next undo_tries() can be taken back by it, as long as no page of it is filled.
  void begin_tries() { ++tries_; }
  void undo_tries();
  // The family of a node, which the frame sees; a new one where there is none. kNone: there is no room.
  std::uint32_t see(NodeKey parent);

  // Lent to the renderer, which alone writes and reads them.
  std::span<PageTexel> texels() const { return storage_.texels; }
  std::span<PageTexel> places() const { return storage_.places; }
  std::uint32_t count() const { return static_cast<std::uint32_t>(storage_.families.size()); }
  bool is_filled(std::uint32_t family, int quadrant) const {
    return (storage_.families[family].filled >> quadrant & 1) != 0;
  }
  void set_filled(std::uint32_t family, int quadrant) {
    storage_.families[family].filled |= static_cast<std::uint8_t>(1 << quadrant);
  }
  // That its nodes have to be made again: in other pages, since the GPU may still draw these. Returns how
  // many pages were filled.
  std::uint32_t retire(NodeKey parent);
  NodeKey key(std::uint32_t family) const { return storage_.families[family].key; }

 private:
  std::uint32_t& chain_of(NodeKey key);
  void unlink(std::uint32_t family);
  std::uint32_t make_room();

  Storage storage_;
  std::uint32_t frame_ = 0;
  std::uint32_t hand_ = 0;  // where looking for room goes on
  bool has_room_ = true;    // as far as the frame knows
  std::uint32_t seen_ = 0;  // by the frame
  std::uint32_t most_ = 0;  // that it may see
  std::uint32_t tries_ = 0;
  std::uint32_t in_flight_ = kFramesInFlight;  // frames before this one that the GPU may still draw
};

}  // namespace karst::core
