// SPDX-License-Identifier: MIT
// Heights in a bounded piece of memory: groups of blocks that are read when they are needed, the ones not
// needed for longest giving way. Where all of a world fits, it is read once.
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/arena.h"
#include "terrain/base/config.h"
#include "terrain/patch/heights.h"

namespace karst::core {

// Reads one group of blocks; out has room for whole groups, the world's last one may fill less of it.
struct HeightSource {
  const void* context = nullptr;  // borrowed
  Status (*read)(const void* context, std::uint32_t group, std::span<std::int16_t> out) = nullptr;
};

class HeightCache {
 public:
  // Groups that one patch may need at once: its own and those around its four corners, where at most 11
  // patches meet (tests/property prints the most that it saw).
  static constexpr std::uint32_t kLeastGroups = 48;
  static constexpr std::uint32_t kNowhere = 0xffffffffu;

  // Borrowed for the cache's life. samples: whole groups of the largest level; slot_of_group: one a group of
  // the largest world; group_of_slot, used: one a slot, which are samples.size() over a group's samples of
  // the level in use, but at most so many.
  struct Storage {
    std::span<std::int16_t> samples;
    std::span<std::uint32_t> slot_of_group;
    std::span<std::uint32_t> group_of_slot;
    std::span<std::uint32_t> used;

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      const std::size_t held = groups_of(config.max_height_blocks);
      const auto block = static_cast<std::size_t>(patch_vertices(static_cast<int>(config.max_level)));
      visit(Consumer::heights, held * kHeightGroup * block, samples);
      visit(Consumer::heights, groups_of(config.max_patches), slot_of_group);
      visit(Consumer::heights, held, group_of_slot);
      visit(Consumer::heights, held, used);
    }
  };
  static constexpr std::uint32_t groups_of(std::uint32_t blocks) {
    return (blocks + kHeightGroup - 1) / kHeightGroup;
  }
  void create(const Storage& storage);

  // Empties the cache for a world of so many blocks at a level. limit_reached ("max_height_blocks", value:
  // blocks) where neither all groups nor kLeastGroups fit.
  Status reset(int level, std::uint32_t blocks);

  bool has_room_for_all() const { return groups_ <= slots_; }

  // One need: hold(block) for each block, all of which stay until the next begin(). Errors of the source;
  // limit_reached ("max_height_blocks") where one need is larger than the cache.
  void begin() { ++now_; }
  Status hold(std::uint32_t block, const HeightSource& source);

  Heights heights() const;

  // Makes room for the groups that were never held, where there is room for all; none is read.
  // Precondition: has_room_for_all().
  void hold_rest();
  // To be written. Precondition: its group is held.
  std::span<std::int16_t> block(std::uint32_t index) {
    const auto count = static_cast<std::size_t>(patch_vertices(level_));
    const std::size_t place = storage_.slot_of_group[index / kHeightGroup];
    return storage_.samples.subspan((place * kHeightGroup + index % kHeightGroup) * count, count);
  }

  std::uint64_t groups_read() const { return groups_read_; }  // since create()

 private:
  std::span<std::int16_t> slot(std::uint32_t index, std::uint32_t group) const;
  std::uint32_t oldest() const;

  Storage storage_;
  int level_ = 0;
  std::uint32_t blocks_ = 0;
  std::uint32_t groups_ = 0;
  std::uint32_t slots_ = 0;
  std::uint32_t filled_ = 0;
  std::uint32_t now_ = 0;
  std::uint64_t groups_read_ = 0;
};

}  // namespace karst::core
