// SPDX-License-Identifier: MIT
// Boxes of nodes, home at size 0, and of all of a ground.
#pragma once

#include <span>

#include <glm/vec3.hpp>

#include "terrain/ground/tile.h"
#include "terrain/view/frustum.h"

namespace karst::core {

struct NodeBox {
  glm::dvec3 low, high;  // lattice steps from the ground's corner
};

// Of all that is drawn in a node, at its size or smaller ones, morphing or not.
NodeBox node_box(const GroundInfo& info, const NodeMeasure& measure, NodeKey node);

// A ball that holds the same: what nodes of a curved basis are culled and measured by.
struct NodeBall {
  glm::dvec3 centre;  // lattice steps
  double radius;
};
NodeBall node_ball(const GroundInfo& info, const NodeMeasure& measure, NodeKey node);
// Its radius; low, high: heights in the node.
double node_radius(const GroundInfo& info, std::int32_t low, std::int32_t high, int size);

// How much longer what spans a quad, as steps[] say it, may be at a node's height.
double height_stretch(const GroundInfo& info, std::int32_t low, std::int32_t high);
// The same of its four children, by quadrant, whose tile that is; of those that do not exist anything.
void child_boxes(const GroundInfo& info, const Tile& tile, NodeKey node, std::span<NodeBox, 4> out);

// Of all samples; at most what 31 bits hold.
// Of a basis whose function is not lent: as on a plane.
LatticeBox ground_box(const GroundInfo& info);

}  // namespace karst::core
