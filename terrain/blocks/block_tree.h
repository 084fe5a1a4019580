// SPDX-License-Identifier: MIT
// The octree of an isosurface's blocks: which of them may hold surface, and which are drawn for some eyes.
// All that is chosen fills the field once; blocks that meet, at a corner even, are one level apart at most,
// and of four around an edge never just two that are diagonal are divided: what ExtractBlock needs to close.
//
// How far a block's surface is from the finest one, and that from it, is bounded when the field is loaded,
// and again where it changes: for each level what MeasureCells says of the step from the next finer one, and
// the most of the eight finer blocks. Where something was lost and counts as far off as other cells' surface,
// the next step is the most of the blocks around. Eyes take the coarsest blocks whose error is within theirs.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>

#include <glm/vec3.hpp>

#include "terrain/base/storage_plan.h"
#include "terrain/blocks/block_key.h"
#include "terrain/isosurface/field_blocks.h"
#include "terrain/lod/morph.h"
#include "terrain/view/frustum.h"

namespace karst::core {

// Lengths as bytes: 0, or 8 an octave from 2^-9 cells on; rounded up. 255 is more than any distance.
constexpr std::uint8_t cells_code(float cells) {
  constexpr std::uint32_t kBefore = ((127u - 9) << 3) - 1;
  if (!(cells > 0)) return 0;
  const std::uint32_t eighths = (std::bit_cast<std::uint32_t>(cells) + (1u << 20) - 1) >> 20;
  return static_cast<std::uint8_t>(eighths <= kBefore ? 1 : std::min(eighths - kBefore, 255u));
}
constexpr float code_cells(std::uint8_t code) {
  if (code == 0) return 0;
  if (code == 255) return std::numeric_limits<float>::infinity();
  return std::bit_cast<float>((((127u - 9) << 3) - 1 + code) << 20);
}
// What rounding to places of vertices adds: half of 16 steps of a cell, and of one half as wide.
inline constexpr float kRoundedCells = 12.5f / 1024;

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
    std::span<std::uint8_t> steps;     // by node, codes: how far from the next finer level
    std::span<std::uint8_t> errors;    // and how far from the finest
    std::span<std::uint32_t> divided;  // nodes of the level at hand

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      // A row of blocks has as many again at coarser levels, and one a level more.
      const std::size_t all = config.field_blocks == 0 ? 0 : 2 * std::size_t{config.field_blocks} + 16;
      visit(Consumer::fields, all, nodes);
      visit(Consumer::fields, all, steps);
      visit(Consumer::fields, all, errors);
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
  // What a block is off by at most, lattice steps. An edit never makes it less, until the field is loaded.
  float block_error(BlockKey block) const;
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
  // kNear, kFar: CellDistance's reach; kAway: some has one, of the block or of blocks within.
  static constexpr std::uint8_t kSurface = 1, kDivided = 2, kExists = 4, kNear = 8, kFar = 16, kAway = 32;

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
  void measure(const FieldBlocks& field, int level, glm::ivec3 low, glm::ivec3 high);
  void sum_errors(int level, glm::ivec3 first, glm::ivec3 last);

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
