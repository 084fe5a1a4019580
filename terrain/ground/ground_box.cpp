// SPDX-License-Identifier: MIT
#include "terrain/ground/ground_box.h"

#include <algorithm>
#include <limits>

namespace karst::core {
namespace {

// A vertex of the parent's lattice is off by less than two of its steps, which are four of the node's.
std::int64_t pad_of(const GroundInfo& info, int size) {
  return std::int64_t{4} << info.page_size(size);
}

}  // namespace

NodeBox node_box(const GroundInfo& info, const NodeMeasure& measure, NodeKey node) {
  const std::int64_t pad = pad_of(info, node.size);
  const auto at = [&](int axis, std::int64_t vertex) {
    const std::int64_t sample = sample_of(info.samples[axis], node.size, vertex);
    return sample_place(info, axis, sample) * kVertexStep;
  };
  const std::int64_t west = std::int64_t{node.x} * kNodeQuads;
  const std::int64_t north = std::int64_t{node.z} * kNodeQuads;
  const glm::i64vec3 low(at(0, west), std::int64_t{measure.low} * kVertexStep, at(1, north));
  const glm::i64vec3 high(at(0, west + kNodeQuads), std::int64_t{measure.high} * kVertexStep,
                          at(1, north + kNodeQuads));
  return {glm::dvec3(low - pad), glm::dvec3(high + pad)};
}

void child_boxes(const GroundInfo& info, const Tile& tile, NodeKey node, std::span<NodeBox, 4> out) {
  const int size = node.size - 1;
  const std::int64_t pad = pad_of(info, size);
  // The lines that the four have in common, across x and across z.
  std::int64_t line[2][3];
  for (int axis = 0; axis < 2; ++axis) {
    const std::int64_t first = std::int64_t{2 * kNodeQuads} * (axis == 0 ? node.x : node.z);
    for (int n = 0; n < 3; ++n) {
      const std::int64_t sample = sample_of(info.samples[axis], size, first + n * kNodeQuads);
      line[axis][n] = sample_place(info, axis, sample) * kVertexStep;
    }
  }
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const int x = quadrant & 1, z = quadrant >> 1;
    const NodeMeasure& measure = tile.nodes[node_in_tile(node.child(quadrant))];
    out[static_cast<std::size_t>(quadrant)] = {
        glm::dvec3(static_cast<double>(line[0][x] - pad),
                   static_cast<double>(std::int64_t{measure.low} * kVertexStep - pad),
                   static_cast<double>(line[1][z] - pad)),
        glm::dvec3(static_cast<double>(line[0][x + 1] + pad),
                   static_cast<double>(std::int64_t{measure.high} * kVertexStep + pad),
                   static_cast<double>(line[1][z + 1] + pad))};
  }
}

LatticeBox ground_box(const GroundInfo& info) {
  const auto steps = [](std::int64_t value) {
    return static_cast<std::int32_t>(std::clamp<std::int64_t>(value * kVertexStep,
                                                              std::numeric_limits<std::int32_t>::min(),
                                                              std::numeric_limits<std::int32_t>::max()));
  };
  return {{steps(info.corner[0]), steps(info.low), steps(info.corner[1])},
          {steps(sample_place(info, 0, info.samples[0] - 1)), steps(info.high),
           steps(sample_place(info, 1, info.samples[1] - 1))}};
}

}  // namespace karst::core
