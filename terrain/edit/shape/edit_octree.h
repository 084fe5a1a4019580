// SPDX-License-Identifier: MIT
// Fills or empties the voxels of a shape in a tree beside the old one: they share all that is the same, so an
// edit that finds no room further on is given up without a trace.
#pragma once

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/edit/shape/voxel_shape.h"
#include "terrain/field/octree.h"

namespace karst::core {

struct EditOctree {
  // Inputs, borrowed.
  Octree* octree = nullptr;  // its pool takes the new nodes; its root stays
  const VoxelShape* shape = nullptr;
  bool filled = false;

  struct Result {
    Octree::Node root = Octree::kEmpty;  // the octree's own where nothing changes
    glm::ivec3 low{0}, high{-1};         // box of the voxels that change, both ends included
  };

  // limit_reached ("max_octets", value: that it would take): nothing has changed then.
  Status run(Result& result) const;

  // Gives back the nodes of one tree that are not in the other: of the new one to give an edit up, of the old
  // one when it is done with. The octree's root is neither's business.
  static void release(Octree& octree, Octree::Node gone, Octree::Node stays);

 private:
  Status edit(Octree::Node node, glm::ivec3 origin, int size, Result& result, Octree::Node& made) const;
};

}  // namespace karst::core
