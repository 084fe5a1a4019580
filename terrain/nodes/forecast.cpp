// SPDX-License-Identifier: MIT
#include "terrain/nodes/forecast.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "terrain/lod/morph.h"
#include "terrain/nodes/ground_view.h"

namespace karst::core {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();
// Of a box's corner, what a plane of float coefficients and the GPU may be off by (frustum.cpp).
constexpr double kPlaneRounding = 0x1p-19;

}  // namespace

NodeThresholds::NodeThresholds(const GroundInfo& info, const GroundRequest& request)
    : morphing(request.morphing) {
  const float least_cos2 = request.scale.least_cos2;
  // What floats lose of distances, a factor a size; what halves do is in what was measured.
  const double rounding = least_cos2 < 0.0f ? 1.0 : 1.0 + 0x1p-16 / double{least_cos2};
  unit[0] = std::ldexp(1.0, info.lattice_size);
  for (std::size_t size = 1; size < unit.size(); ++size) unit[size] = unit[size - 1] * 2 * rounding;
  const bool by_error = request.sides_away <= 0;
  is_finite = !by_error || request.scale.steps_per_step < kInfinite;
  // Distances of deviations are those of the full surface's points (measure_ground.h). A point in the picture
  // whose full one is beyond the picture's corner is nearer than that by least_cos2 of the deviation at most.
  demand = place_of_demand(
      by_error && is_finite ? double{request.scale.steps_per_step} + std::max(0.0, double{least_cos2}) : 1.0);
  steps_away =
      std::max(request.sides_away, 0.0) * kNodeQuads * std::max(info.steps[0], info.steps[1]) / unit[0];
}

double NodeThresholds::of(const NodeMeasure& measure, int size) const {
  const std::uint16_t* const halves = measure.thresholds + demand.n;
  if (!morphing || !is_finite || halves[1] >= kNeverMorphs) return double{kInfinite};
  const double at_n = double{threshold_steps(halves[0])};
  const double after_n = double{threshold_steps(halves[1])};
  return ((at_n + (after_n - at_n) * demand.share) * demand.factor + steps_away) *
         unit[static_cast<std::size_t>(size)];
}

// A threshold is at least demand times error.
float most_error(const GroundInfo& info, const NodeMeasure& measure, int size) {
  const std::uint16_t greatest = measure.thresholds[kDemands - 1];
  if (greatest >= kNeverMorphs) return kInfinite;
  return threshold_steps(greatest) * std::ldexp(1.0f, info.page_size(size)) /
         static_cast<float>(demand(kDemands - 1));
}

Frustum planes_at(const GroundRequest& request) {
  Camera camera = *request.camera;
  const glm::dvec3 corner = glm::dvec3(camera.voxel) * double{kStepsPerVoxel};
  if (request.frustum != nullptr) {
    Frustum moved = *request.frustum;
    for (Plane& plane : moved.planes) {
      const double offset = double{plane.offset} + glm::dot(glm::dvec3(plane.normal), corner);
      // What floats lost of both terms.
      plane.offset = static_cast<float>(
          offset +
          (std::abs(offset) + std::abs(double{plane.offset}) + glm::length(corner)) * kPlaneRounding);
    }
    return moved;
  }
  camera.voxel = glm::ivec3(0);
  return make_frustum(camera);
}

Forecast::Forecast(const GroundInfo& info, const GroundRequest& request, const glm::dvec3& way)
    : info_(info),
      request_(request),
      thresholds_(info, request),
      frustum_(planes_at(request)),
      corner_(glm::dvec3(request.camera->voxel) * double{kStepsPerVoxel} + way),
      eye_(corner_ + glm::dvec3(request.camera->fine)) {}

NodeBall Forecast::ball(const NodeMeasure& measure, NodeKey node) const {
  if (info_.basis.is_curved()) return node_ball(info_, measure, node);
  const NodeBox box = node_box(info_, measure, node);
  return {0.5 * (box.low + box.high), 0.5 * glm::length(box.high - box.low)};
}

bool Forecast::sees(const NodeBall& ball) const {
  if (!request_.culls) return true;
  const glm::dvec3 centre = ball.centre - corner_;
  return std::all_of(std::begin(frustum_.planes), std::end(frustum_.planes), [&](const Plane& plane) {
    return double{plane.offset} + glm::dot(glm::dvec3(plane.normal), centre) + ball.radius >= 0;
  });
}

float Forecast::need(const NodeMeasure& measure, NodeKey node, const NodeBall& ball) const {
  const float error = most_error(info_, measure, node.size);
  if (node.size <= request_.least_size || error <= request_.spared_error || !sees(ball)) return 0;
  const float least_cos2 = request_.scale.least_cos2;
  double apparent = -double{least_cos2};
  if (least_cos2 >= 0.0f) {
    const glm::dvec3 d = ball.centre - eye_;
    const double r = glm::length(d);
    const double ahead = std::max(0.0, glm::dot(d, request_.camera->forward));
    apparent =
        std::max(ahead * ahead, double{least_cos2} * r * r) / std::max(r, 1.0) - kSteepest * ball.radius;
  }
  if (apparent >= thresholds_.of(measure, node.size)) return 0;
  const double left = apparent - double{error};
  const double px = left > 0 ? double{request_.scale.pixels} * double{error} / left : double{kMostNeed};
  return std::clamp(static_cast<float>(px), 1e-3f, kMostNeed);
}

}  // namespace karst::core
