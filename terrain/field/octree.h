// SPDX-License-Identifier: MIT
// A pooled voxel octree (K 3.3). A node is a leaf (filled or empty) or has exactly eight children, which lie
// together in one octet of the pool; equal leaf children collapse into their parent.
// Octant o of a node: bit 0 = upper half in x, bit 1 in y, bit 2 in z. All coordinates are voxels at the
// finest level, in [0, size()).
#pragma once

#include "karst/status.h"
#include "terrain/base/arena.h"

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <span>

namespace karst::core {

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

  // An empty tree of 2^depth voxels a side, depth 1..kMaxDepth. Takes exactly bytes_for(max_octets) bytes
  // from the arena; limit_reached ("arena") where they are not there.
  Status create(Arena& arena, int depth, std::uint32_t max_octets);
  // The same in a pool that is borrowed for the tree's life.
  Status create(std::span<Octet> pool, int depth);

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

  // Sets the cube of 2^(depth - level) voxels with minimum corner origin (a multiple of its size) to filled
  // or empty, splitting and collapsing as needed. level in 0..depth. On limit_reached ("max_octets", value:
  // octets the pool would need) and on invalid_argument the tree is unchanged.
  Status set(glm::ivec3 origin, int level, bool filled);

  // Number of voxels at the finest level that are filled.
  std::uint64_t count_filled() const;

  static constexpr bool equal_leaves(const Octet& octet) {
    for (const Node c : octet.child) {
      if (c != octet.child[0]) return false;
    }
    return is_leaf(octet.child[0]);
  }

  // Building blocks for bottom-up construction. The tree itself is what set_root was last given; nodes made
  // and never linked to it keep their octets until release or reset.
  //
  // A node over the given children: a leaf where they are equal leaves, else a new octet. On limit_reached
  // ("max_octets") result and children are untouched; the children still own their octets.
  Status make_node(const Octet& children, Node& result);
  // The same for a node that has an octet already: stores the children in it, or gives it back where they are
  // equal leaves. Never fails. Precondition: !is_leaf(n).
  Node update_node(Node n, const Octet& children);
  // The eight children of n, virtual ones for a leaf.
  Octet children(Node n) const;
  // Gives back every octet of the subtree n, which must not be linked any more. A leaf has none.
  void release(Node n);
  // Replaces the whole tree; the old root's octets are the caller's to release.
  void set_root(Node root) { root_ = root; }

 private:
  static constexpr std::uint32_t kNoOctet = 0xffffffffu;

  std::uint32_t take_octet();  // precondition: used_ < max_octets()
  void give_octet(std::uint32_t octet);

  std::span<Octet> pool_;
  std::uint32_t used_ = 0;   // octets in use
  std::uint32_t fresh_ = 0;  // octets from here on were never taken: the free list needs no set-up pass
  std::uint32_t free_head_ = kNoOctet;  // first octet of the free list, linked through child[0]
  Node root_ = kEmpty;
  int depth_ = 1;
};

}  // namespace karst::core
