// SPDX-License-Identifier: MIT
#include "terrain/ground/ground_box.h"

#include <algorithm>
#include <limits>

namespace karst::core {

NodeBox node_box(const GroundInfo& info, const NodeMeasure& measure, NodeKey node) {
  // A vertex of the parent's lattice is off by less than two of its steps, which are four of the node's.
  const std::int64_t pad = std::int64_t{4} << info.page_size(node.size);
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
