// SPDX-License-Identifier: MIT
// One list of an owner's blocks drives both the budget and the taking of memory, so that no size is written
// twice. Whoever owns memory has a struct of spans with
//
//   template <class Visit> void each_block(const Config& config, Visit&& visit) {
//     visit(Consumer::volumes, config.max_volumes, volumes);  // consumer, objects, span
//     ...
//   }
//
// count_blocks() adds up what it lists, take_blocks() fills its spans from an arena. A struct of spans may
// list the blocks of another one: each_block hands visit on.
#pragma once

#include <cstddef>
#include <span>

#include "karst/status.h"
#include "terrain/base/arena.h"
#include "terrain/base/budget.h"
#include "terrain/base/config.h"

namespace karst::core {

class CountBlocks {
 public:
  explicit CountBlocks(Budget& budget) : budget_(budget) {}

  template <class T>
  void operator()(Consumer consumer, std::size_t count, std::span<T>& /*out*/) const {
    budget_.add(consumer, Arena::bytes_for<T>(count));
  }

 private:
  Budget& budget_;
};

class TakeBlocks {
 public:
  explicit TakeBlocks(Arena& arena) : arena_(arena) {}

  template <class T>
  void operator()(Consumer consumer, std::size_t count, std::span<T>& out) {
    out = arena_.allocate<T>(consumer, count);
    complete_ = complete_ && out.size() == count;
  }
  // Whether the arena had room for all of them.
  bool complete() const { return complete_; }

 private:
  Arena& arena_;
  bool complete_ = true;
};

// Adds the bytes of all blocks; equals what take_blocks() takes to the byte.
template <class Blocks>
void count_blocks(const Config& config, Budget& budget) {
  Blocks blocks;
  blocks.each_block(config, CountBlocks(budget));
}

// limit_reached ("memory") where the arena is too small or frozen; the spans that found no room are empty.
template <class Blocks>
Status take_blocks(const Config& config, Arena& arena, Blocks& blocks) {
  TakeBlocks take(arena);
  blocks.each_block(config, take);
  if (take.complete()) return {};
  return {StatusCode::limit_reached, "the memory given is smaller than the budget", "memory"};
}

}  // namespace karst::core
