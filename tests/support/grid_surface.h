// SPDX-License-Identifier: MIT
// A made-up surface for tests and benchmarks of the view: one patch a ground column, with the links, the
// order in space and the boxes of a real one, for a fraction of the time that extraction takes.
#pragma once

#include "terrain/cull/bounds_tree.h"
#include "terrain/patch/bounds.h"
#include "terrain/surface/patch.h"

#include <cstdint>
#include <vector>

namespace karst::core {

struct GridSurface {
  std::vector<Volume> volumes;
  std::vector<Patch> patches;
  std::vector<PatchBounds> bounds;
  std::vector<LatticeBox> nodes;
  BoundsTree tree;  // over bounds, in nodes

  GridSurface() = default;
  GridSurface(GridSurface&&) = default;  // no copies: tree borrows nodes
  GridSurface& operator=(GridSurface&&) = default;

  Surface surface() const { return {volumes, patches}; }
};

// width x depth columns (1..509 each) from voxel 1 on, on hills of a few voxels made of seed; boxes reach up
// to reach_voxels (below 4) from the patch's origin. In Morton order, like the octree's. i runs along +x and
// j along -z. sheets: as many such hills above each other, 40 voxels apart, one after the other in order.
GridSurface make_grid_surface(int width, int depth, double reach_voxels, std::uint64_t seed, int sheets = 1);

}  // namespace karst::core
