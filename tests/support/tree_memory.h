// SPDX-License-Identifier: MIT
// An octree with memory of its own, and random voxels, for tests.
#pragma once

#include "terrain/base/arena.h"
#include "terrain/field/octree.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>

namespace karst::core {

// splitmix64 (Steele, Lea and Flood, 2014): the same numbers on every compiler, unlike <random>'s
// distributions.
class TestRandom {
 public:
  explicit TestRandom(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state_;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
  }
  // 0..count-1.
  std::uint32_t below(std::uint32_t count) {
    return static_cast<std::uint32_t>((next() >> 32) * count >> 32);
  }
  int range(int low, int high) {
    return low + static_cast<int>(below(static_cast<std::uint32_t>(high - low + 1)));
  }
  bool chance(double p) { return static_cast<double>(next() >> 11) * 0x1p-53 < p; }

 private:
  std::uint64_t state_;
};

class TreeMemory {
 public:
  explicit TreeMemory(int depth, std::uint32_t max_octets = 50'000)
      : bytes_(Octree::bytes_for(max_octets)),
        memory_(static_cast<std::byte*>(::operator new(bytes_ + 1, kAlign))),
        arena_(std::span<std::byte>(memory_.get(), bytes_)) {
    const Status status = tree.create(arena_, depth, max_octets);
    EXPECT_TRUE(status.ok()) << status.what();
  }

  Arena& arena() { return arena_; }

 private:
  static constexpr std::align_val_t kAlign{Arena::kAlignment};
  struct Free {
    void operator()(std::byte* p) const { ::operator delete(p, kAlign); }
  };

  std::size_t bytes_;
  std::unique_ptr<std::byte, Free> memory_;
  Arena arena_;

 public:
  Octree tree;
};

// Internal nodes that can be reached, and whether none of them has eight equal leaves.
inline std::uint32_t reachable_octets(const Octree& tree, Octree::Node n, bool& collapsed) {
  if (Octree::is_leaf(n)) return 0;
  const Octree::Octet octet = tree.children(n);
  if (Octree::equal_leaves(octet)) collapsed = false;
  std::uint32_t count = 1;
  for (const Octree::Node c : octet.child) count += reachable_octets(tree, c, collapsed);
  return count;
}

// Every octet in use is reachable, and equal leaves are collapsed.
inline void expect_sound(const Octree& tree) {
  bool collapsed = true;
  EXPECT_EQ(reachable_octets(tree, tree.root(), collapsed), tree.octets_used());
  EXPECT_TRUE(collapsed);
}

}  // namespace karst::core
