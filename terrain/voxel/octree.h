// SPDX-License-Identifier: MIT
// A pooled voxel octree (K 3.3). A node is a leaf (filled or empty) or has exactly eight children, which lie
// together in one octet of the pool; equal leaf children collapse into their parent.
// Octant o of a node: bit 0 = upper half in x, bit 1 in y, bit 2 in z. All coordinates are voxels at the
// finest level, in [0, size()).
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "terrain/base/arena.h"
#include "terrain/base/status.h"

namespace karst {

class Octree {
 public:
  // A node's value: kLeaf | fill for a leaf, else the index of its octet. Values, not pointers: a Node read
  // before an edit is stale after it.
  using Node = std::uint32_t;
  static constexpr Node kLeaf = 0x80000000u;
  static constexpr Node kEmpty = kLeaf;
  static constexpr Node kFilled = kLeaf | 1u;

  struct Octet {
    Node child[8];
  };

  struct Leaf {
    glm::ivec3 origin;  // minimum corner, voxels
    std::int32_t size;  // edge, voxels
    bool filled;
  };

  static std::size_t bytes_for(std::uint32_t max_octets) { return Arena::bytes_for<Octet>(max_octets); }

  // An empty tree of 2^depth voxels a side, depth 1..kMaxDepth. Takes exactly bytes_for(max_octets).
  Status create(Arena& arena, int depth, std::uint32_t max_octets);

  // Empties the tree and gives all octets back to the pool; depth may change.
  Status reset(int depth);

  int depth() const { return depth_; }
  std::int32_t size() const { return std::int32_t{1} << depth_; }
  std::uint32_t max_octets() const { return static_cast<std::uint32_t>(pool_.size()); }
  std::uint32_t octets_used() const { return used_; }

  Node root() const { return root_; }
  static constexpr bool is_leaf(Node n) { return (n & kLeaf) != 0; }
  static constexpr bool is_filled(Node n) { return n == kFilled; }
  // A leaf stands for its own children: they are its virtual sub-voxels (K 3.4.2.1).
  Node child(Node n, int octant) const { return is_leaf(n) ? n : pool_[n].child[octant]; }

  // Precondition: v in [0, size()) on every axis.
  Leaf find_leaf(glm::ivec3 v) const;
  bool filled(glm::ivec3 v) const { return find_leaf(v).filled; }

  // Sets the cube of 2^(depth - level) voxels with minimum corner origin (a multiple of its size) to filled or
  // empty, splitting and collapsing as needed. On limit_reached ("max_octets") the tree is unchanged.
  Status set(glm::ivec3 origin, int level, bool filled);

  // Number of voxels at the finest level that are filled.
  std::uint64_t count_filled() const;

  // Building blocks for bottom-up construction: takes an octet whose children are given, collapsing equal
  // leaves; result receives the node. And the root they end in.
  Status make_node(const Octet& children, Node& result);
  void set_root(Node root) { root_ = root; }

 private:
  std::span<Octet> pool_;
  std::uint32_t used_ = 0;       // octets in use
  std::uint32_t free_head_ = 0;  // first octet of the free list, linked through child[0]
  Node root_ = kEmpty;
  int depth_ = 1;
};

}  // namespace karst
