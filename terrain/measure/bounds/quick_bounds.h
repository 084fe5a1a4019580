// SPDX-License-Identifier: MIT
// Bounds of a patch's vertices in a twentieth of the time that the vertices themselves take: of its control
// points and of how high its heights are at most. Never inside the exact ones.
#pragma once

#include "terrain/patch/bounds.h"
#include "terrain/patch/generate_vertices.h"
#include "terrain/patch/heights.h"
#include "terrain/surface/patch.h"

namespace karst::core {

struct QuickBounds {
  PatchBounds box;   // holds GenerateVertices::bounds() at the heights' level
  MorphWays ways;    // no less than those of the undisplaced surface
  double apart = 0;  // lattice steps: no displaced place of it is further from the undisplaced one
};

QuickBounds quick_bounds(const Surface& surface, const Heights& heights, PatchId patch);

}  // namespace karst::core
