// SPDX-License-Identifier: MIT
// A segment cut to the world, and its walk through the boxes of patches and tiles from near to far. All in
// lattice steps.
//
// Boxes are tested four at a time by slabs (Williams et al., "An Efficient and Robust Ray-Box Intersection
// Algorithm", 2005) in float, grown by kBoxMargin. Coordinates and distances in a world stay below 2^23
// steps, where the four roundings of a slab's distance are less than 4 steps together; so no box that the
// segment meets is missed.
#pragma once

#include <cstdint>

#include <glm/vec3.hpp>

#include "terrain/base/simd.h"
#include "terrain/query/patch_cache.h"

namespace karst::core {

inline constexpr double kBoxMargin = 8.0;  // lattice steps

struct Segment {
  glm::dvec3 from{0.0};  // where it enters the world
  glm::dvec3 way{0.0};   // from there to where it leaves it; a place on it is from + t way, t in 0..1
  double before = 0.0;   // way before it enters
  double length = 0.0;   // of way

  // Cuts a segment to a box grown by so much; false where nothing is left. A segment without length stays.
  bool cut(glm::dvec3 a, glm::dvec3 b, const LatticeBox& box, double grow);
};

// A segment made ready for boxes that count from `base`.
struct SlabTest {
  simd::Float4 inverse[3];
  simd::Float4 near_origin[3];  // grown boxes: the origin moves instead of their planes
  simd::Float4 far_origin[3];
  bool negative[3];

  SlabTest(const Segment& segment, double grow);
  // For boxes that count from another place.
  void move_to(const Segment& segment, glm::ivec3 base, double grow);

  // Bit c: the segment meets box c before t = limit; near: where.
  unsigned meets(const simd::Float4 (&low)[3], const simd::Float4 (&high)[3], float limit,
                 simd::Float4& near) const {
    using simd::Float4;
    Float4 first = simd::splat(0.0f);
    Float4 last = simd::splat(limit);
    for (int axis = 0; axis < 3; ++axis) {
      const Float4 a = negative[axis] ? high[axis] : low[axis];
      const Float4 b = negative[axis] ? low[axis] : high[axis];
      first = simd::max((a - near_origin[axis]) * inverse[axis], first);
      last = simd::min((b - far_origin[axis]) * inverse[axis], last);
    }
    near = first;
    return simd::lanes(first <= last);
  }
};

// A share of a segment as a limit for boxes: no less than t.
inline float box_limit(double t) {
  return static_cast<float>(t) * 1.000001f;
}

// Of four boxes, lane by lane; those from count on repeat the last.
struct FourBoxes {
  simd::Float4 low[3];
  simd::Float4 high[3];

  FourBoxes(const LatticeBox* boxes, std::uint32_t count) {
    simd::Int4 a[4];
    simd::Int4 b[4];
    for (std::uint32_t c = 0; c < 4; ++c) {
      const auto* bytes = reinterpret_cast<const std::byte*>(boxes + (c < count ? c : count - 1));
      a[c] = simd::load<simd::Int4>(bytes);                             // min.x, min.y, min.z, max.x
      b[c] = simd::load<simd::Int4>(bytes + 2 * sizeof(std::int32_t));  // min.z, max.x, max.y, max.z
    }
    simd::transpose(a[0], a[1], a[2], a[3]);
    simd::transpose(b[0], b[1], b[2], b[3]);
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = simd::to_float(a[axis]);
      high[axis] = simd::to_float(b[axis + 1]);
    }
  }
};
static_assert(sizeof(LatticeBox) == 6 * sizeof(std::int32_t));

// Box of a patch, and of it undisplaced where it may be met so.
inline LatticeBox query_box(const QueryWorld& world, PatchId id, bool undisplaced) {
  LatticeBox box = patch_box(world.surface, world.bounds, id);
  if (undisplaced) {
    const glm::ivec3 origin = patch_origin(world.surface.volume_of(id));
    box.min = glm::min(box.min, origin - kStepsPerHalfVoxel);
    box.max = glm::max(box.max, origin + kStepsPerHalfVoxel);
  }
  return box;
}

// What a segment meets before t = limit() of a node's children, sorted from far to near on top of a stack.
struct WalkEntry {
  float near;
  std::uint32_t index;  // patch, or node of the row
  int row;              // -1: a patch
};

// Calls visit(patch) for all patches whose boxes the segment meets before t = limit(), which may fall:
// roughly from near to far. node_test is for the tree's nodes, patch_test for patches: they may be grown
// differently.
template <class Limit, class Visit>
void walk_patches(const QueryWorld& world, const SlabTest& node_test, const SlabTest& patch_test,
                  bool undisplaced, Limit&& limit, Visit&& visit) {
  const BoundsTree& tree = *world.tree;
  if (tree.rows() == 0) return;
  WalkEntry stack[(BoundsTree::kFanOut - 1) * BoundsTree::kMaxRows + BoundsTree::kFanOut];
  int depth = 0;
  stack[depth++] = {0.0f, 0, tree.rows() - 1};
  while (depth > 0) {
    const WalkEntry at = stack[--depth];
    if (at.near > limit()) continue;
    if (at.row < 0) {
      visit(at.index);
      continue;
    }
    const std::uint32_t first = at.index * BoundsTree::kFanOut;
    const std::uint32_t below = at.row == 0 ? tree.patches() : tree.nodes(at.row - 1);
    const std::uint32_t count = below - first < BoundsTree::kFanOut ? below - first : BoundsTree::kFanOut;
    LatticeBox room[BoundsTree::kFanOut];
    const LatticeBox* boxes = room;
    if (at.row == 0) {
      for (std::uint32_t c = 0; c < count; ++c) room[c] = query_box(world, first + c, undisplaced);
    } else {
      boxes = &tree.node(at.row - 1, first);
    }
    const int bottom = depth;
    for (std::uint32_t c = 0; c < count; c += 4) {
      const std::uint32_t lanes = count - c < 4 ? count - c : 4;
      const FourBoxes four(boxes + c, lanes);
      simd::Float4 near;
      unsigned met = (at.row == 0 ? patch_test : node_test).meets(four.low, four.high, limit(), near) &
                     ((1u << lanes) - 1);
      for (std::uint32_t lane = 0; met != 0; ++lane, met >>= 1) {
        if ((met & 1u) == 0) continue;
        const float t = near[lane];
        int to = depth++;
        for (; to > bottom && stack[to - 1].near < t; --to) stack[to] = stack[to - 1];
        stack[to] = {t, first + c + lane, at.row - 1};
      }
    }
  }
}

// Calls visit(a, b) for the tiles of a patch whose boxes the segment meets before t = limit().
template <class Limit, class Visit>
void walk_tiles(const QueryPatch& patch, const SlabTest& test, Limit&& limit, Visit&& visit) {
  const int depth_of_tiles = patch.level - 1;
  if (depth_of_tiles == 0) {
    visit(0, 0);
    return;
  }
  struct Entry {
    std::uint16_t node, a, b;
    std::uint8_t below;  // levels below the node
  };
  Entry stack[3 * kMaxLevel + 1];
  int depth = 0;
  stack[depth++] = {0, 0, 0, static_cast<std::uint8_t>(depth_of_tiles)};
  while (depth > 0) {
    const Entry at = stack[--depth];
    const TileNode& node = patch.nodes[at.node];
    simd::Float4 near;
    const unsigned met = test.meets(node.min, node.max, limit(), near);
    for (unsigned c = 0; c < 4; ++c) {
      if ((met >> c & 1u) == 0) continue;
      const unsigned a = 2u * at.a + (c & 1u);
      const unsigned b = 2u * at.b + (c >> 1);
      if (at.below == 1) {
        visit(static_cast<int>(a), static_cast<int>(b));
      } else {
        stack[depth++] = {static_cast<std::uint16_t>(4u * at.node + 1 + c), static_cast<std::uint16_t>(a),
                          static_cast<std::uint16_t>(b), static_cast<std::uint8_t>(at.below - 1)};
      }
    }
  }
}

}  // namespace karst::core
