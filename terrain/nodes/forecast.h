// SPDX-License-Identifier: MIT
// What a view will need of the ground when its eye has moved on: for what is read ahead, and for what need
// not be read, because it would come too late. Nodes are judged as GroundView does it, but by balls: nothing
// that is drawn depends on it.
#pragma once

#include <array>

#include <glm/vec3.hpp>

#include "terrain/ground/ground_box.h"
#include "terrain/ground/tile.h"
#include "terrain/view/frustum.h"

namespace karst::core {

struct GroundRequest;

// Thresholds of nodes for what a view asks (ground_view.h).
struct NodeThresholds {
  NodeThresholds(const GroundInfo& info, const GroundRequest& request);

  // D, lattice steps, not rounded; infinite where a node is to be split wherever it is. size: above 0.
  double of(const NodeMeasure& measure, int size) const;

  DemandPlace demand{};
  bool morphing;
  bool is_finite;                            // the demand
  double steps_away;                         // sides_away, of a node of size 0, over unit[0]
  std::array<double, kMostSize + 1> unit{};  // by size: 2^s f^s
};

// No drawn point of a node is further from the full surface; lattice steps, may be infinite.
float most_error(const GroundInfo& info, const NodeMeasure& measure, int size);

// The request's planes, relative to its camera's voxel.
Frustum planes_at(const GroundRequest& request);

class Forecast {
 public:
  static constexpr float kMostNeed = 1e6f;

  // way: that the eye will have moved; lattice steps. info, request: borrowed. Precondition: request.camera.
  Forecast(const GroundInfo& info, const GroundRequest& request, const glm::dvec3& way);

  NodeBall ball(const NodeMeasure& measure, NodeKey node) const;
  bool sees(const NodeBall& ball) const;
  // Pixels that the ground is off by in the node, then, where it is not split, at most kMostNeed; 0: it need
  // not be split, or is out of view.
  float need(const NodeMeasure& measure, NodeKey node, const NodeBall& ball) const;
  // Lattice steps from the ground's corner.
  const glm::dvec3& eye() const { return eye_; }
  const GroundInfo& info() const { return info_; }

 private:
  const GroundInfo& info_;
  const GroundRequest& request_;
  NodeThresholds thresholds_;
  Frustum frustum_;    // of the camera where it is
  glm::dvec3 corner_;  // what its planes are told from, moved on; steps from the ground's corner
  glm::dvec3 eye_;
};

}  // namespace karst::core
