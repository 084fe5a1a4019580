// SPDX-License-Identifier: MIT
#include "terrain/nodes/make_node.h"

#include <algorithm>
#include <array>

#include "terrain/base/check.h"
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
        k_((node.z & (kTileNodes - 1)) * kNodeQuads) {
    for (int n = -kTileRim; n <= kNodeQuads + kTileRim; ++n) {
      x_[static_cast<std::size_t>(n + kTileRim)] = place(0, std::int64_t{node.x} * kNodeQuads + n);
      z_[static_cast<std::size_t>(n + kTileRim)] = place(1, std::int64_t{node.z} * kNodeQuads + n);
    }
  }

  std::int32_t height(int i, int k) const { return tile_.height(i_ + i, k_ + k); }

  // kVertexStep of the lattice of `coarser` sizes more than the node's.
  glm::i64vec3 place_of(int i, int k, int coarser) const {
    const int size = info_.page_size(node_.size) + coarser;
    return {place_at_size(x(i), size), place_at_size(height(i, k), size), place_at_size(z(k), size)};
  }

  // Not of unit length. reach: 1 for the node's grid, 2 for its parent's.
  glm::vec3 normal(int i, int k, int reach) const {
    const auto wide = static_cast<float>(x(i + reach) - x(i - reach));
    const auto deep = static_cast<float>(z(k + reach) - z(k - reach));
    const auto east = static_cast<float>(height(i + reach, k) - height(i - reach, k));
    const auto south = static_cast<float>(height(i, k + reach) - height(i, k - reach));
    const glm::vec3 n(-east * deep, wide * deep, -south * wide);
    const float length = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    return length > 0.0f ? glm::vec3(n.x / length, n.y / length, n.z / length) : glm::vec3(0.0f, 1.0f, 0.0f);
  }

 private:
  std::int64_t place(int axis, std::int64_t index) const {
    return sample_place(info_, axis, sample_of(info_.samples[axis], node_.size, index));
  }
  std::int64_t x(int i) const { return x_[static_cast<std::size_t>(i + kTileRim)]; }
  std::int64_t z(int k) const { return z_[static_cast<std::size_t>(k + kTileRim)]; }

  const GroundInfo& info_;
  const Tile& tile_;
  NodeKey node_;
  int i_, k_;
  std::array<std::int64_t, kNodeSide + 2 * kTileRim> x_, z_;
};

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
void add_feet(const GroundInfo& info, NodeKey node, std::span<GpuVertex> out) {
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
      if ((walls >> edge & 1u) != 0) normal += glm::vec3(kOut[edge][0], 0.0f, kOut[edge][1]);
    }
    if (normal == glm::vec3(0.0f)) continue;
    foot.normal = foot.morph_normal = encode_octahedral(normal);
  }
}

}  // namespace

glm::ivec3 node_origin(const GroundInfo& info, const NodeMeasure& measure, NodeKey node) {
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
  add_feet(*info, node, out);
}

}  // namespace karst::core
