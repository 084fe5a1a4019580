// SPDX-License-Identifier: MIT
// A signed field in blocks of 16^3 samples: below 0 is solid. Blocks that are all solid or all air take no
// samples. A stored value v stands for v + 0.5, so that no sample lies on the surface: every edge that the
// surface crosses has a point within, and no triangle shrinks to nothing (L 3.3 treats zeros apart).
// Coordinates are samples of the finest resolution; beyond its sides the field is as at its sides.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include "karst/status.h"

namespace karst::core {

// Sample: std::int8_t or std::int16_t.
template <class Sample>
class ScalarField {
 public:
  static constexpr int kBlockLog2 = 4;
  static constexpr int kBlock = 1 << kBlockLog2;  // samples a side
  static constexpr std::size_t kBlockSamples = std::size_t{kBlock} * kBlock * kBlock;
  static constexpr Sample kSolid = std::numeric_limits<Sample>::min();
  static constexpr Sample kAir = std::numeric_limits<Sample>::max();

  // All of it is air. table: blocks.x * blocks.y * blocks.z values or more; pool: a multiple of kBlockSamples
  // samples, for as many blocks. Both are borrowed. invalid_argument ("blocks": not 1..1024 each way;
  // "table").
  Status create(glm::ivec3 blocks, std::span<std::uint32_t> table, std::span<Sample> pool) {
    for (int axis = 0; axis < 3; ++axis) {
      if (blocks[axis] < 1 || blocks[axis] > 1024)
        return {StatusCode::invalid_argument, "not within 1..1024 each way", "blocks"};
    }
    const auto count = static_cast<std::size_t>(blocks.x) * static_cast<std::size_t>(blocks.y) *
                       static_cast<std::size_t>(blocks.z);
    if (table.size() < count) return {StatusCode::invalid_argument, "too short", "table", count};
    blocks_ = blocks;
    table_ = table.first(count);
    pool_ = pool;
    for (std::uint32_t& entry : table_) entry = kAllAir;
    const auto slots = static_cast<std::uint32_t>(pool.size() / kBlockSamples);
    free_ = kNone;
    free_count_ = slots;
    for (std::uint32_t slot = slots; slot-- > 0;) link(slot);
    return {};
  }

  glm::ivec3 blocks() const { return blocks_; }
  glm::ivec3 samples() const { return blocks_ * kBlock; }
  std::uint32_t free_blocks() const { return free_count_; }

  // Whether blocks low..high, of which those count that there are, take no samples and are filled alike.
  bool are_alike(glm::ivec3 low, glm::ivec3 high) const {
    low = glm::max(low, glm::ivec3(0));
    high = glm::min(high, blocks_ - 1);
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) {
          if (!block({x, y, z}).empty() || filling({x, y, z}) != filling(low)) return false;
        }
      }
    }
    return true;
  }

  int at(glm::ivec3 sample) const {
    const glm::ivec3 s = glm::clamp(sample, glm::ivec3(0), samples() - 1);
    const std::uint32_t entry = table_[index(s >> kBlockLog2)];
    if (entry >= kAllAir) return entry == kAllAir ? kAir : kSolid;
    return pool_[std::size_t{entry} * kBlockSamples + offset(s & (kBlock - 1))];
  }

  // The samples of a block, in x, then y, then z; empty where all are alike.
  std::span<const Sample> block(glm::ivec3 block) const {
    const std::uint32_t entry = table_[index(block)];
    return entry >= kAllAir ? std::span<const Sample>() : slot_samples(entry);
  }
  // What all samples of a block are, where it takes none.
  Sample filling(glm::ivec3 block) const { return table_[index(block)] == kAllAir ? kAir : kSolid; }

  // Samples of a block, to be written; they are what the block was. Empty: the pool is full.
  std::span<Sample> open(glm::ivec3 block) {
    std::uint32_t& entry = table_[index(block)];
    if (entry < kAllAir) return slot_samples(entry);
    if (free_ == kNone) return {};
    const Sample fill = entry == kAllAir ? kAir : kSolid;
    entry = free_;
    const std::span<Sample> out = slot_samples(entry);
    free_ = linked(entry);
    --free_count_;
    for (Sample& sample : out) sample = fill;
    return out;
  }
  // Gives a block's samples back where all of them are kAir, or all kSolid.
  void close(glm::ivec3 block) {
    std::uint32_t& entry = table_[index(block)];
    if (entry >= kAllAir) return;
    const std::span<const Sample> all = slot_samples(entry);
    if (all[0] != kAir && all[0] != kSolid) return;
    for (const Sample sample : all) {
      if (sample != all[0]) return;
    }
    const std::uint32_t slot = entry;
    entry = all[0] == kAir ? kAllAir : kAllSolid;
    link(slot);
    ++free_count_;
  }

  // Makes a block all kAir, or all kSolid; its samples are given back.
  void fill(glm::ivec3 block, Sample all) {
    std::uint32_t& entry = table_[index(block)];
    if (entry < kAllAir) {
      link(entry);
      ++free_count_;
    }
    entry = all == kAir ? kAllAir : kAllSolid;
  }

  static constexpr std::size_t offset(glm::ivec3 inside) {
    return static_cast<std::size_t>(inside.x + kBlock * (inside.y + kBlock * inside.z));
  }

 private:
  static constexpr std::uint32_t kAllAir = 0xfffffffeu;
  static constexpr std::uint32_t kAllSolid = 0xffffffffu;
  static constexpr std::uint32_t kNone = 0xffffffffu;

  std::size_t index(glm::ivec3 block) const {
    return static_cast<std::size_t>(block.x) +
           static_cast<std::size_t>(blocks_.x) *
               (static_cast<std::size_t>(block.y) +
                static_cast<std::size_t>(blocks_.y) * static_cast<std::size_t>(block.z));
  }
  std::span<Sample> slot_samples(std::uint32_t slot) const {
    return pool_.subspan(std::size_t{slot} * kBlockSamples, kBlockSamples);
  }
  // Free slots are a list through their own first bytes.
  void link(std::uint32_t slot) {
    std::memcpy(slot_samples(slot).data(), &free_, sizeof free_);
    free_ = slot;
  }
  std::uint32_t linked(std::uint32_t slot) const {
    std::uint32_t next = 0;
    std::memcpy(&next, slot_samples(slot).data(), sizeof next);
    return next;
  }

  glm::ivec3 blocks_{0};
  std::span<std::uint32_t> table_;
  std::span<Sample> pool_;
  std::uint32_t free_ = kNone;
  std::uint32_t free_count_ = 0;
};

}  // namespace karst::core
