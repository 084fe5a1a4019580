// SPDX-License-Identifier: MIT
#include "terrain/ground/ground_box.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>

namespace karst::core {
namespace {

// A vertex of the parent's lattice is off by less than two of its steps, which are four of the node's.
std::int64_t pad_of(const GroundInfo& info, int size) {
  return std::int64_t{4} << info.page_size(size);
}

}  // namespace

// At corners of a cube's faces the grid's lines meet at 60 degrees, so that one diagonal of a quad is
// sqrt(8/3) of its sides at the face's middle, where the two are apart the most.
constexpr double kCubeSkew = 1.1548;

double height_stretch(const GroundInfo& info, std::int32_t low, std::int32_t high) {
  const Basis& basis = info.basis;
  if (basis.kind == BasisKind::function) {
    // No radius is known: that of the circle of which a quad is an arc.
    const double spacing_m = std::max(info.steps[0], info.steps[1]) / kVertexStep * basis.height_unit_m;
    return 1.0 + std::max(std::abs(basis.height_m(low)), std::abs(basis.height_m(high))) * basis.turn_rad /
                     spacing_m;
  }
  const double most_m = std::max(std::abs(basis.height_m(low)), std::abs(basis.height_m(high)));
  return (info.is_cube() ? kCubeSkew : 1.0) + most_m / (0.98 * std::abs(basis.radius_m));
}

double node_radius(const GroundInfo& info, std::int32_t low, std::int32_t high, int size) {
  const auto quads = static_cast<double>(std::int64_t{kNodeQuads} << size);
  const double stretch = height_stretch(info, low, high);
  // Two points of which one is the middle's: heights apart, and at most as far along as their arcs are. What
  // vertices are rounded by, targets' too, is less than eight steps of the size.
  const double pad = std::ldexp(16.0, size);
  const double tall = (static_cast<double>(high) - low) * kVertexStep + pad;
  return 0.5 * std::hypot(quads * info.steps[0] * stretch + pad, tall, quads * info.steps[1] * stretch + pad);
}

NodeBall node_ball(const GroundInfo& info, const NodeMeasure& measure, NodeKey node) {
  const int face = face_of(info, node);
  const auto middle = [&](int axis, std::int64_t index) {
    const std::int64_t vertex = index * kNodeQuads + kNodeQuads / 2;
    return axis_place(info.basis, axis, face,
                      static_cast<double>(sample_of(info.samples[axis], node.size, vertex)));
  };
  const double height = 0.5 * (static_cast<double>(measure.low) + measure.high);
  const glm::dvec3 metres =
      place_m(info.basis, face, middle(0, node.x), middle(1, node.z), info.basis.height_m(height));
  return {metres * (kVertexStep / info.basis.height_unit_m),
          node_radius(info, measure.low, measure.high, node.size)};
}

NodeBox node_box(const GroundInfo& info, const NodeMeasure& measure, NodeKey node) {
  if (info.basis.is_curved()) {
    const NodeBall ball = node_ball(info, measure, node);
    return {ball.centre - ball.radius, ball.centre + ball.radius};
  }
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
  const bool is_lent = info.basis.kind != BasisKind::function || info.basis.function.place != nullptr;
  if (info.basis.is_curved() && is_lent) {
    glm::dvec3 low(std::numeric_limits<double>::max()), high(-low);
    NodeMeasure all;
    all.low = info.low;
    all.high = info.high;
    const NodeKey past = info.is_cube() ? NodeKey{info.top_size(), kCubeCells[0], kCubeCells[1]}
                                        : NodeKey{info.top_size(), 1, 1};
    for (int z = 0; z < past.z; ++z) {
      for (int x = 0; x < past.x; ++x) {
        if (!node_exists(info, {past.size, x, z})) continue;
        const NodeBox box = node_box(info, all, {past.size, x, z});
        low = glm::min(low, box.low);
        high = glm::max(high, box.high);
      }
    }
    constexpr double kMost = std::numeric_limits<std::int32_t>::max();
    return {glm::ivec3(glm::clamp(low, -kMost, kMost)), glm::ivec3(glm::clamp(high, -kMost, kMost))};
  }
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
