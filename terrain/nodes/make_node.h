// SPDX-License-Identifier: MIT
// The vertices of a node, from the tile that it lies in.
#pragma once

#include <span>

#include <glm/vec3.hpp>

#include "terrain/ground/tile.h"
#include "terrain/patch/gpu_vertex.h"

namespace karst::core {

// Where the places of the node's vertices count from: voxels of its size from the ground's corner, or of a
// curved basis from its frame's origin.
glm::ivec3 node_origin(const GroundInfo& info, const NodeMeasure& measure, NodeKey node);

struct MakeNode {
  // Inputs, borrowed.
  const GroundInfo* info = nullptr;
  const Tile* tile = nullptr;  // tile_of(node)
  NodeKey node;                // exists
  bool morphs = true;          // false: the root, whose vertices have nowhere to go

  // Output, borrowed: kNodePageVertices: those of the grid in slot order (family_row.h), then its corners
  // once more, which are drawn at the feet of walls. Lattice steps of the node's size from node_origin(),
  // even ones; int16's ends where heights are further from the middle of the node's. A vertex's target is its
  // place on the lattice of the next greater size, or the mean of two such places: of the ends of the edge of
  // the parent's quad that it is the middle of, or of the quad's diagonal. Normals are those of the grid of
  // the node's size, by differences to both neighbours, and of the parent's (S: normals per level).
  std::span<GpuVertex> out;

  void run() const;
};

}  // namespace karst::core
