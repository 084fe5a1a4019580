// SPDX-License-Identifier: MIT
// The octree of an isosurface's blocks: which of them may hold surface, and which are drawn for some eyes.
// All that is chosen fills the field once; blocks that meet, at a corner even, are one level apart at most,
// and of four around an edge never just two that are diagonal are divided: what ExtractBlock needs to close.
//
// A block is taken to stray from the finest surface by kBlockError of its cells, which is more than
// tests/property/blocks_test.cpp finds of any shape, smooth or with things thinner than cells, which are
// lost. Eyes take the coarsest blocks whose error is within theirs.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "terrain/base/storage_plan.h"
#include "terrain/blocks/block_key.h"
#include "terrain/isosurface/field_blocks.h"
#include "terrain/lod/morph.h"
#include "terrain/view/frustum.h"

namespace karst::core {

// Of the width of a block's cells.
inline constexpr double kBlockError = 2.5;

struct BlockEye {
  LodEye eye;
  float steps_per_step = 1;  // ErrorScale's
};

struct ChosenBlock {
  BlockKey block;
  BlockAround around = 0;

  friend bool operator==(const ChosenBlock&, const ChosenBlock&) = default;
};

class BlockTree {
 public:
  struct Storage {
    std::span<std::uint8_t> nodes;     // of all levels
    std::span<std::uint32_t> divided;  // nodes of the level at hand

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      // A row of blocks has as many again at coarser levels, and one a level more.
      const std::size_t all = config.field_blocks == 0 ? 0 : 2 * std::size_t{config.field_blocks} + 16;
      visit(Consumer::fields, all, nodes);
      visit(Consumer::fields, config.field_blocks, divided);
    }
  };
  void create(const Storage& storage) { storage_ = storage; }

  // Begins anew with a field. Precondition: it has no more blocks than there is memory for.
  void reset(const FieldBlocks& field);
  // Samples low..high (both included) have changed.
  void refresh(const FieldBlocks& field, glm::ivec3 low, glm::ivec3 high);

  int levels() const { return levels_; }
  glm::ivec3 blocks(int level) const { return size_[static_cast<std::size_t>(level)]; }
  // What a block of a level is taken to be off by, lattice steps.
  float level_error(int level) const;
  // A block's box, with what its vertices may reach beyond it; lattice steps from the world's corner.
  LatticeBox box(BlockKey block) const;
  // The least apparent distance of a block from an eye.
  float least_apparent(BlockKey block, const LodEye& eye) const;
  bool may_hold_surface(BlockKey block) const { return (node(block.place(), block.level) & kSurface) != 0; }

  // Chooses for all eyes together; finest: no block of a level below. Returns how many blocks that may hold
  // surface there are, of which the first fill out, from high levels to low ones, in z, y and x.
  std::size_t choose(std::span<const BlockEye> eyes, int finest, std::span<ChosenBlock> out);
  // Calls visit(key) for each block of the last choice, with surface or not.
  template <class Visit>
  void each_chosen(const Visit& visit) const;

 private:
  static constexpr std::uint8_t kSurface = 1, kDivided = 2, kExists = 4;

  std::size_t index(glm::ivec3 place, int level) const {
    const auto n = static_cast<std::size_t>(level);
    return first_[n] + static_cast<std::size_t>(place.x) +
           static_cast<std::size_t>(size_[n].x) *
               (static_cast<std::size_t>(place.y) +
                static_cast<std::size_t>(size_[n].y) * static_cast<std::size_t>(place.z));
  }
  bool inside(glm::ivec3 place, int level) const {
    const glm::ivec3 size = size_[static_cast<std::size_t>(level)];
    return place.x >= 0 && place.y >= 0 && place.z >= 0 && place.x < size.x && place.y < size.y &&
           place.z < size.z;
  }
  std::uint8_t node(glm::ivec3 place, int level) const { return storage_.nodes[index(place, level)]; }
  std::uint8_t& node(glm::ivec3 place, int level) { return storage_.nodes[index(place, level)]; }
  bool is_divided(glm::ivec3 place, int level) const { return (node(place, level) & kDivided) != 0; }
  glm::ivec3 place_of(std::size_t in_level, int level) const;
  void descend(glm::ivec3 place, int level, std::span<const BlockEye> eyes, int finest);
  void divide(glm::ivec3 place, int level);
  void settle(int level);
  BlockAround around(glm::ivec3 place, int level) const;

  Storage storage_;
  FieldInfo info_;
  int levels_ = 0;
  std::array<glm::ivec3, kIsoMaxLevel + 1> size_{};
  std::array<std::size_t, kIsoMaxLevel + 2> first_{};
};

template <class Visit>
void BlockTree::each_chosen(const Visit& visit) const {
  for (int level = levels_ - 1; level >= 0; --level) {
    const auto n = static_cast<std::size_t>(level);
    for (std::size_t at = first_[n]; at < first_[n + 1]; ++at) {
      if ((storage_.nodes[at] & (kExists | kDivided)) == kExists)
        visit(block_key(place_of(at - first_[n], level), level));
    }
  }
}

}  // namespace karst::core
