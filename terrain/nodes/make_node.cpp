// SPDX-License-Identifier: MIT
#include "terrain/nodes/make_node.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "terrain/base/check.h"
#include "terrain/ground/ground_box.h"
#include "terrain/patch/octahedral.h"

namespace karst::core {
namespace {

constexpr std::int64_t floor_voxel(std::int64_t steps) {
  return steps >> kLatticeBits;
}

// The grid of a node's size around it. Coordinates i, k are vertices of the node, from -kTileRim on.
class Grid {
 public:
  Grid(const GroundInfo& info, const Tile& tile, NodeKey node)
      : info_(info),
        tile_(tile),
        node_(node),
        i_((node.x & (kTileNodes - 1)) * kNodeQuads),
        k_((node.z & (kTileNodes - 1)) * kNodeQuads),
        places_(info, node) {}

  std::int32_t height(int i, int k) const { return tile_.height(i_ + i, k_ + k); }

  // kVertexStep of the lattice of `coarser` sizes more than the node's.
  glm::i64vec3 place_of(int i, int k, int coarser) const {
    const int size = info_.page_size(node_.size) + coarser;
    const glm::i64vec3 place = places_.at(i, k, height(i, k));
    return {place_at_size(place.x, size), place_at_size(place.y, size), place_at_size(place.z, size)};
  }

  // Not of unit length. reach: 1 for the node's grid, 2 for its parent's.
  glm::vec3 normal(int i, int k, int reach) const {
    if (info_.basis.is_curved()) return curved_normal(i, k, reach);
    const auto wide = static_cast<float>(places_.x(i + reach) - places_.x(i - reach));
    const auto deep = static_cast<float>(places_.z(k + reach) - places_.z(k - reach));
    const auto east = static_cast<float>(height(i + reach, k) - height(i - reach, k));
    const auto south = static_cast<float>(height(i, k + reach) - height(i, k - reach));
    const glm::vec3 n(-east * deep, wide * deep, -south * wide);
    const float length = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    return length > 0.0f ? glm::vec3(n.x / length, n.y / length, n.z / length) : glm::vec3(0.0f, 1.0f, 0.0f);
  }

  // From one vertex to another of the node, across its edge: horizontal, not of unit length.
  glm::vec3 way(int i, int k, int from_i, int from_k) const {
    const glm::dvec3 d(places_.at(i, k, 0) - places_.at(from_i, from_k, 0));
    const double length = glm::length(d);
    return length > 0 ? glm::vec3(d / length) : glm::vec3(0.0f);
  }

 private:
  glm::vec3 curved_normal(int i, int k, int reach) const {
    const auto place = [&](int at_i, int at_k) { return places_.at(at_i, at_k, height(at_i, at_k)); };
    const glm::dvec3 east(place(i + reach, k) - place(i - reach, k));
    const glm::dvec3 south(place(i, k + reach) - place(i, k - reach));
    const glm::dvec3 n(south.y * east.z - south.z * east.y, south.z * east.x - south.x * east.z,
                       south.x * east.y - south.y * east.x);
    const double length = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    // At a pole all of a row is one place.
    return glm::vec3(length > 0 ? n / length : places_.up(i, k));
  }

  const GroundInfo& info_;
  const Tile& tile_;
  NodeKey node_;
  int i_, k_;
  NodePlaces places_;
};
static_assert(NodePlaces::kMostRim == kTileRim);

// The two vertices of the parent's grid that a vertex goes to the middle of; the same one twice where it is
// one of them.
struct Parents {
  int i[2], k[2];
};
Parents parents_of(int i, int k) {
  Parents p{{i & ~1, (i + 1) & ~1}, {k & ~1, (k + 1) & ~1}};
  // The diagonal of the parent's quad; a node has an even number of quads, so that its own count.
  if ((i & k & 1) != 0 && ((i >> 1) + (k >> 1)) % 2 != 0) std::swap(p.i[0], p.i[1]);
  return p;
}

constexpr std::int64_t kMostReach = 32'766;  // steps, of an int16; even

// The vertices below the corners: the corners' own places, which whoever draws them lowers. So they move as
// the corners do, and walls of neighbours meet.
void add_feet(const GroundInfo& info, NodeKey node, const Grid& grid, std::span<GpuVertex> out) {
  const unsigned walls = node_walls(info, node);
  // Outwards, by edge.
  constexpr float kOut[4][2] = {{-1, 0}, {0, 1}, {1, 0}, {0, -1}};
  for (int corner = 0; corner < 4; ++corner) {
    const int south = corner == 1 || corner == 2 ? kNodeQuads : 0;
    const int east = corner == 2 || corner == 3 ? kNodeQuads : 0;
    GpuVertex& foot = out[static_cast<std::size_t>(kNodeVertices + corner)];
    foot = out[static_cast<std::size_t>(vertex_order(kNodeLevel, south, east))];
    glm::vec3 normal(0.0f);
    for (const int edge : {corner, (corner + 3) % 4}) {
      if ((walls >> edge & 1u) == 0) continue;
      if (info.basis.is_curved()) {
        const bool along_x = kOut[edge][0] != 0.0f;
        normal +=
            grid.way(east, south, along_x ? kNodeQuads - east : east, along_x ? south : kNodeQuads - south);
      } else {
        normal += glm::vec3(kOut[edge][0], 0.0f, kOut[edge][1]);
      }
    }
    if (normal == glm::vec3(0.0f)) continue;
    foot.normal = foot.morph_normal = encode_octahedral(normal);
  }
}

}  // namespace

glm::ivec3 node_origin(const GroundInfo& info, const NodeMeasure& measure, NodeKey node) {
  if (info.basis.is_curved()) {
    const glm::dvec3 centre = node_ball(info, measure, node).centre;
    const double voxel = std::ldexp(double{kStepsPerVoxel}, node.size);
    return {static_cast<int>(std::floor(centre.x / voxel + 0.5)),
            static_cast<int>(std::floor(centre.y / voxel + 0.5)),
            static_cast<int>(std::floor(centre.z / voxel + 0.5))};
  }
  const int size = info.page_size(node.size);
  const auto at = [&](int axis, int index) {
    const std::int64_t sample = sample_of(info.samples[axis], node.size, std::int64_t{index} * kNodeQuads);
    return place_at_size(sample_place(info, axis, sample), size) * kVertexStep;
  };
  const std::int64_t middle = (std::int64_t{measure.low} + measure.high) >> 1;
  const std::int64_t y = place_at_size(middle, size) * kVertexStep;
  return {static_cast<int>(floor_voxel(at(0, node.x))), static_cast<int>(floor_voxel(y + kStepsPerHalfVoxel)),
          static_cast<int>(floor_voxel(at(1, node.z)))};
}

void MakeNode::run() const {
  KARST_ASSERT(info != nullptr && tile != nullptr && out.size() == kNodePageVertices);
  KARST_ASSERT(node_exists(*info, node));
  // A quad of the parent's has its diagonal by the parity of its place in the grid: that of its place in the
  // parent, and so of its place in the node.
  static_assert(kNodeQuads % 4 == 0);
  const Grid grid(*info, *tile, node);
  const NodeMeasure& measure = tile->nodes[node_in_tile(node)];
  const glm::i64vec3 origin = glm::i64vec3(node_origin(*info, measure, node)) * std::int64_t{kStepsPerVoxel};
  const auto store = [&](glm::i64vec3 steps, std::int16_t(&to)[3]) {
    for (int axis = 0; axis < 3; ++axis) {
      to[axis] = static_cast<std::int16_t>(std::clamp(steps[axis] - origin[axis], -kMostReach, kMostReach));
    }
  };
  for (int k = 0; k < kNodeSide; ++k) {
    for (int i = 0; i < kNodeSide; ++i) {
      GpuVertex& vertex = out[static_cast<std::size_t>(vertex_order(kNodeLevel, k, i))];
      store(grid.place_of(i, k, 0) * std::int64_t{kVertexStep}, vertex.position);
      vertex.normal = encode_octahedral(grid.normal(i, k, 1));
      if (!morphs) {
        std::copy(std::begin(vertex.position), std::end(vertex.position), std::begin(vertex.morph));
        vertex.morph_normal = vertex.normal;
        continue;
      }
      const Parents p = parents_of(i, k);
      // In steps of the node's size one of the parent's lattice is two, so the mean is their sum.
      const glm::i64vec3 sum = grid.place_of(p.i[0], p.k[0], 1) + grid.place_of(p.i[1], p.k[1], 1);
      store(sum * std::int64_t{kVertexStep}, vertex.morph);
      vertex.morph_normal =
          encode_octahedral(grid.normal(p.i[0], p.k[0], 2) + grid.normal(p.i[1], p.k[1], 2));
    }
  }
  add_feet(*info, node, grid, out);
}

}  // namespace karst::core
