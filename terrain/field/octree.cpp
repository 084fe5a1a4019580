// SPDX-License-Identifier: MIT
#include "terrain/field/octree.h"

#include "terrain/base/check.h"
#include "terrain/base/config.h"
#include "terrain/base/lattice.h"

namespace karst::core {
namespace {

static_assert(kFullTreeOctets < Octree::kLeaf, "an octet's index must not look like a leaf");

// The octant of v at the step that leads to nodes of 2^bit voxels.
int octant_of(glm::ivec3 v, int bit) {
  return (v.x >> bit & 1) | (v.y >> bit & 1) << 1 | (v.z >> bit & 1) << 2;
}

// Recursion is bounded by the tree's depth.
std::uint64_t count_filled_in(const Octree& tree, Octree::Node n, int bit) {
  if (Octree::is_leaf(n)) return Octree::is_filled(n) ? std::uint64_t{1} << (3 * bit) : 0;
  std::uint64_t count = 0;
  for (int octant = 0; octant < 8; ++octant) count += count_filled_in(tree, tree.child(n, octant), bit - 1);
  return count;
}

}  // namespace

Status Octree::create(Arena& arena, int depth, std::uint32_t max_octets) {
  if (depth < 1 || depth > kMaxDepth) {
    return {StatusCode::invalid_argument, "octree depth is outside 1..9", "depth"};
  }
  if (max_octets > kFullTreeOctets) {
    return {StatusCode::invalid_argument, "more octets than the deepest full octree has", "max_octets",
            kFullTreeOctets};
  }
  const std::span<Octet> pool = arena.allocate<Octet>(Consumer::octets, max_octets);
  if (pool.size() != max_octets) {
    return {StatusCode::limit_reached, "no room for the octets", "arena", bytes_for(max_octets)};
  }
  return create(pool, depth);
}

Status Octree::create(std::span<Octet> pool, int depth) {
  pool_ = pool;
  return reset(depth);
}

Status Octree::reset(int depth) {
  if (depth < 1 || depth > kMaxDepth) {
    return {StatusCode::invalid_argument, "octree depth is outside 1..9", "depth"};
  }
  depth_ = depth;
  root_ = kEmpty;
  used_ = 0;
  fresh_ = 0;
  free_head_ = kNoOctet;
  return {};
}

Octree::Leaf Octree::find_leaf(glm::ivec3 v) const {
  KARST_ASSERT(v.x >= 0 && v.y >= 0 && v.z >= 0 && v.x < size() && v.y < size() && v.z < size());
  Node n = root_;
  int bit = depth_;
  while (!is_leaf(n)) {
    --bit;
    n = pool_[n].child[octant_of(v, bit)];
  }
  const std::int32_t leaf_size = std::int32_t{1} << bit;
  return {glm::ivec3(v.x & -leaf_size, v.y & -leaf_size, v.z & -leaf_size), leaf_size, is_filled(n)};
}

Status Octree::set(glm::ivec3 origin, int level, bool fill) {
  if (level < 0 || level > depth_) {
    return {StatusCode::invalid_argument, "voxel level is outside 0..depth", "level"};
  }
  const std::int32_t cube = size() >> level;
  for (int axis = 0; axis < 3; ++axis) {
    if (origin[axis] < 0 || origin[axis] >= size() || origin[axis] % cube != 0) {
      return {StatusCode::invalid_argument, "voxel is outside the octree or not at a multiple of its size",
              "origin"};
    }
  }
  const Node value = fill ? kFilled : kEmpty;

  // path[l] is the octet at level l on the way down.
  std::uint32_t path[kMaxDepth];
  Node n = root_;
  int at = 0;
  while (at < level && !is_leaf(n)) {
    path[at] = n;
    n = pool_[n].child[octant_of(origin, depth_ - 1 - at)];
    ++at;
  }
  if (n == value) return {};

  if (at < level) {
    // n is a leaf of the other value: split it down to level. Nothing can collapse then, for its other parts
    // keep their value.
    const auto needed = static_cast<std::uint32_t>(level - at);
    if (needed > max_octets() - used_) {
      return {StatusCode::limit_reached, "the octree's octets are used up", "max_octets", used_ + needed};
    }
    const Node old = n;
    n = value;
    for (int l = level - 1; l >= at; --l) {
      const std::uint32_t octet = take_octet();
      for (Node& c : pool_[octet].child) c = old;
      pool_[octet].child[octant_of(origin, depth_ - 1 - l)] = n;
      n = octet;
    }
  } else {
    release(n);
    n = value;
  }
  // Link n, then collapse upwards as far as children have become equal.
  while (at > 0) {
    --at;
    Octet& octet = pool_[path[at]];
    octet.child[octant_of(origin, depth_ - 1 - at)] = n;
    if (!equal_leaves(octet)) return {};
    give_octet(path[at]);
    n = value;
  }
  root_ = n;
  return {};
}

std::uint64_t Octree::count_filled() const {
  return count_filled_in(*this, root_, depth_);
}

Status Octree::make_node(const Octet& children, Node& result) {
  if (equal_leaves(children)) {
    result = children.child[0];
    return {};
  }
  if (used_ == max_octets()) {
    return {StatusCode::limit_reached, "the octree's octets are used up", "max_octets"};
  }
  const std::uint32_t octet = take_octet();
  pool_[octet] = children;
  result = octet;
  return {};
}

Octree::Node Octree::update_node(Node n, const Octet& children) {
  KARST_ASSERT(!is_leaf(n));
  if (equal_leaves(children)) {
    const Node leaf = children.child[0];
    give_octet(n);
    return leaf;
  }
  pool_[n] = children;
  return n;
}

Octree::Octet Octree::children(Node n) const {
  return is_leaf(n) ? Octet{{n, n, n, n, n, n, n, n}} : pool_[n];
}

void Octree::release(Node n) {
  if (is_leaf(n)) return;
  for (const Node c : pool_[n].child) release(c);
  give_octet(n);
}

std::uint32_t Octree::take_octet() {
  KARST_ASSERT(used_ < max_octets());
  ++used_;
  if (free_head_ == kNoOctet) return fresh_++;
  const std::uint32_t octet = free_head_;
  free_head_ = pool_[octet].child[0];
  return octet;
}

void Octree::give_octet(std::uint32_t octet) {
  --used_;
  pool_[octet].child[0] = free_head_;
  free_head_ = octet;
}

}  // namespace karst::core
