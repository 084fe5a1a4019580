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

// The same of its four children, by quadrant, whose tile that is; of those that do not exist anything.
void child_boxes(const GroundInfo& info, const Tile& tile, NodeKey node, std::span<NodeBox, 4> out);

// Of all samples; at most what 31 bits hold.
LatticeBox ground_box(const GroundInfo& info);

}  // namespace karst::core
