// SPDX-License-Identifier: MIT
// What the samples have in common, and one maker for each.
#pragma once

#include "app/bake/noise.h"
#include "app/bake/samples.h"

namespace karst::bake {

// Fine relief for the heights, finer than a voxel: value plus noise near the surface. `strata_m` tall layers,
// tilted a little, are laid on top of an isotropic grain. The slope stays below about 1/2, so that displaced
// triangles do not fold.
struct Grain {
  double strength_m = 0.5;
  double width_m = 6;   // of the largest bumps
  double strata_m = 0;  // height of a layer; 0: none
  double strata_strength_m = 0;
  std::uint32_t seed = 1;

  double apply(double value_m, glm::dvec3 p) const;
};

Sample make_canyon();
Sample make_caves();
Sample make_arches();
Sample make_hills();

}  // namespace karst::bake
