// SPDX-License-Identifier: MIT
// A segment cut to the world, and its walk through the boxes of patches and tiles from near to far. All in
// lattice steps.
//
// Boxes are tested four at a time by slabs (Williams et al., "An Efficient and Robust Ray-Box Intersection
// Algorithm", 2005) in float, grown by kBoxMargin. Coordinates and distances in a world stay below 2^23
// steps, where the four roundings of a slab's distance are less than 4 steps together; so no box that the
// segment meets is missed.
#pragma once

#include <cmath>
#include <cstddef>
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

// A box as two vectors: min.x, min.y, min.z, max.x and min.z, max.x, max.y, max.z.
struct BoxLanes {
  simd::Int4 low, high;
};

inline BoxLanes node_lanes(const LatticeBox& box) {
  static_assert(sizeof(LatticeBox) == 6 * sizeof(std::int32_t));
  const auto* bytes = reinterpret_cast<const std::byte*>(&box);
  return {simd::load<simd::Int4>(bytes), simd::load<simd::Int4>(bytes + 2 * sizeof(std::int32_t))};
}

// Of a patch, and of it undisplaced where it may be met so.
template <bool kUndisplaced>
BoxLanes patch_lanes(const QueryPart& world, PatchId id) {
  static_assert(offsetof(Volume, corner) == 0 && sizeof(Volume) >= 8);
  static_assert(sizeof(PatchBounds) == 6 * sizeof(std::int16_t));
  using simd::Int4;
  using simd::Short4;
  const auto* volume = reinterpret_cast<const std::byte*>(&world.surface.volume_of(id));
  const auto* bounds = reinterpret_cast<const std::byte*>(&world.bounds[id]);
  const Int4 corner = simd::to_int(simd::load<Short4>(volume));  // below 2^15
  const Int4 low_origin = __builtin_shufflevector(corner, corner, 0, 1, 2, 0) * kStepsPerVoxel;
  const Int4 high_origin = __builtin_shufflevector(corner, corner, 2, 0, 1, 2) * kStepsPerVoxel;
  Int4 low = simd::to_int(simd::load<Short4>(bounds));
  Int4 high = simd::to_int(simd::load<Short4>(bounds + 2 * sizeof(std::int16_t)));
  if constexpr (kUndisplaced) {
    constexpr std::int32_t kHalf = kStepsPerHalfVoxel;
    const Int4 low_cube = {-kHalf, -kHalf, -kHalf, kHalf};
    const Int4 high_cube = {-kHalf, kHalf, kHalf, kHalf};
    const Int4 is_max = {0, 0, 0, -1};
    const Int4 is_high = {0, -1, -1, -1};
    low = simd::select((low < low_cube) ^ is_max, low, low_cube);
    high = simd::select((high < high_cube) ^ is_high, high, high_cube);
  }
  return {low + low_origin, high + high_origin};
}

// Four boxes, lane by lane.
struct WalkBoxes {
  simd::Float4 low[3];
  simd::Float4 high[3];

  // lanes(c): the BoxLanes of box c; the last of `count` is repeated.
  template <class Lanes>
  WalkBoxes(std::uint32_t count, Lanes&& lanes) {
    simd::Int4 a[4];
    simd::Int4 b[4];
    for (std::uint32_t c = 0; c < 4; ++c) {
      const BoxLanes box = lanes(c < count ? c : count - 1);
      a[c] = box.low;
      b[c] = box.high;
    }
    simd::transpose(a[0], a[1], a[2], a[3]);
    simd::transpose(b[0], b[1], b[2], b[3]);
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = simd::to_float(a[axis]);
      high[axis] = simd::to_float(b[axis + 1]);
    }
  }
};

// What a segment meets before t = limit() of a node's children, sorted from far to near on top of a stack.
struct WalkEntry {
  float near;
  std::uint32_t index;  // patch, or node of the row
  int row;              // -1: a patch
};

// Calls visit(patch) for all patches whose boxes the segment meets before t = limit(), which may fall:
// roughly from near to far. node_test is for the tree's nodes, patch_test for patches: they may be grown
// differently.
template <bool kUndisplaced, class Limit, class Visit>
void walk_patches(const QueryPart& world, const SlabTest& node_test, const SlabTest& patch_test,
                  Limit&& limit, Visit&& visit) {
  const BoundsTree& tree = *world.tree;
  if (tree.rows() == 0) return;
  WalkEntry stack[(BoundsTree::kFanOut - 1) * BoundsTree::kMaxRows + BoundsTree::kFanOut];
  int depth = 0;
  stack[depth++] = {0.0f, 0, tree.rows() - 1};
  while (depth > 0) {
    const WalkEntry at = stack[--depth];
    if (at.near > limit()) continue;
    if (at.row < 0) {
      if (!world.surface.is_free(at.index)) visit(at.index);
      continue;
    }
    const std::uint32_t first = at.index * BoundsTree::kFanOut;
    const std::uint32_t below = at.row == 0 ? tree.patches() : tree.nodes(at.row - 1);
    const std::uint32_t count = below - first < BoundsTree::kFanOut ? below - first : BoundsTree::kFanOut;
    const int bottom = depth;
    for (std::uint32_t c = 0; c < count; c += 4) {
      const std::uint32_t lanes = count - c < 4 ? count - c : 4;
      const WalkBoxes four(lanes, [&](std::uint32_t lane) {
        if (at.row > 0) return node_lanes(tree.node(at.row - 1, first + c + lane));
        return patch_lanes<kUndisplaced>(world, first + c + lane);
      });
      simd::Float4 near;
      unsigned met = (at.row == 0 ? patch_test : node_test).meets(four.low, four.high, limit(), near) &
                     ((1u << lanes) - 1);
      for (; met != 0; met &= met - 1) {
        const auto lane = static_cast<std::uint32_t>(__builtin_ctz(met));
        const float t = near[lane];
        int to = depth++;
        for (; to > bottom && stack[to - 1].near < t; --to) stack[to] = stack[to - 1];
        stack[to] = {t, first + c + lane, at.row - 1};
      }
    }
  }
}

template <class Limit, class Visit>
void walk_patches(const QueryPart& world, const SlabTest& node_test, const SlabTest& patch_test,
                  bool undisplaced, Limit&& limit, Visit&& visit) {
  if (undisplaced) {
    walk_patches<true>(world, node_test, patch_test, limit, visit);
  } else {
    walk_patches<false>(world, node_test, patch_test, limit, visit);
  }
}

// A part of a vertical line, against boxes by whole lattice steps: what it meets is never missed.
struct ColumnTest {
  simd::Int4 most;   // of low.x, low.y, low.z
  simd::Int4 least;  // of high.x, high.y, high.z, in the lanes of BoxLanes::high
  double x, z;       // lattice steps
  int top;

  // bottom is what limits are then.
  ColumnTest(double x_steps, double z_steps, double top_steps, int grow)
      : x(x_steps), z(z_steps), top(whole(top_steps)) {
    most = simd::Int4{whole(x) + grow, top + grow, whole(z) + grow, kMost};
    least = simd::Int4{-kMost, whole(x) - grow, -kMost, whole(z) - grow};
  }

  // high.y of a box that is met, else -kMost.
  int meets(const BoxLanes& box) const {
    return simd::any((box.low > most) | (box.high < least)) ? -kMost : box.high[2];
  }

  // Below anything that a lattice has, whatever is added.
  static constexpr int kMost = 1 << 30;
  static int whole(double steps) {
    const double most_steps = kMost - (1 << 20);
    const double at = steps < -most_steps ? -most_steps : steps > most_steps ? most_steps : steps;
    return static_cast<int>(std::floor(at));
  }
};

// Calls visit(patch) for all patches whose boxes meet a vertical line above limit(), which may rise: roughly
// from the top.
template <bool kUndisplaced, class Limit, class Visit>
void walk_column(const QueryPart& world, const ColumnTest& node_test, const ColumnTest& patch_test, int grow,
                 Limit&& limit, Visit&& visit) {
  const BoundsTree& tree = *world.tree;
  if (tree.rows() == 0) return;
  struct Entry {
    int high;
    std::uint32_t index;  // patch, or node of the row
    int row;              // -1: a patch
  };
  Entry stack[(BoundsTree::kFanOut - 1) * BoundsTree::kMaxRows + BoundsTree::kFanOut];
  int depth = 0;
  stack[depth++] = {ColumnTest::kMost - (1 << 20), 0, tree.rows() - 1};
  while (depth > 0) {
    const Entry at = stack[--depth];
    if (at.high + grow < limit()) continue;
    if (at.row < 0) {
      if (!world.surface.is_free(at.index)) visit(at.index);
      continue;
    }
    const std::uint32_t first = at.index * BoundsTree::kFanOut;
    const std::uint32_t below = at.row == 0 ? tree.patches() : tree.nodes(at.row - 1);
    const std::uint32_t count = below - first < BoundsTree::kFanOut ? below - first : BoundsTree::kFanOut;
    const int bottom = depth;
    for (std::uint32_t c = 0; c < count; ++c) {
      const int high = at.row > 0 ? node_test.meets(node_lanes(tree.node(at.row - 1, first + c)))
                                  : patch_test.meets(patch_lanes<kUndisplaced>(world, first + c));
      if (high == -ColumnTest::kMost) continue;
      int to = depth++;
      for (; to > bottom && stack[to - 1].high > high; --to) stack[to] = stack[to - 1];
      stack[to] = {high, first + c, at.row - 1};
    }
  }
}

// Calls visit(a, b) for the tiles of a patch that are left of its tree of boxes where meets(node) says which
// of a node's four children are, a bit each.
template <class Meets, class Visit>
void walk_tile_nodes(const QueryPatch& patch, const Meets& meets, Visit&& visit) {
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
    for (unsigned met = meets(patch.nodes[at.node]); met != 0; met &= met - 1) {
      const auto c = static_cast<unsigned>(__builtin_ctz(met));
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

// Those whose boxes a vertical line meets above limit(), in lattice steps from the patch's origin. x, top, z:
// the same.
template <class Limit, class Visit>
void walk_tile_column(const QueryPatch& patch, float x, float top, float z, float grow, Limit&& limit,
                      Visit&& visit) {
  using simd::Float4;
  const Float4 most_x = simd::splat(x + grow), least_x = simd::splat(x - grow);
  const Float4 most_z = simd::splat(z + grow), least_z = simd::splat(z - grow);
  const Float4 most_y = simd::splat(top + grow);
  const auto meets = [&](const TileNode& node) {
    const Float4 least_y = simd::splat(limit() - grow);
    return simd::lanes((node.min[0] <= most_x) & (node.max[0] >= least_x) & (node.min[2] <= most_z) &
                       (node.max[2] >= least_z) & (node.min[1] <= most_y) & (node.max[1] >= least_y));
  };
  walk_tile_nodes(patch, meets, visit);
}

// Those whose boxes the segment meets before t = limit().
template <class Limit, class Visit>
void walk_tiles(const QueryPatch& patch, const SlabTest& test, Limit&& limit, Visit&& visit) {
  const auto meets = [&](const TileNode& node) {
    simd::Float4 near;
    return test.meets(node.min, node.max, limit(), near);
  };
  walk_tile_nodes(patch, meets, visit);
}

}  // namespace karst::core
