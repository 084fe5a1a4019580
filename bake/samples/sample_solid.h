// SPDX-License-Identifier: MIT
// What the samples have in common, and the shape of each.
#pragma once

#include "bake/samples/noise.h"
#include "bake/samples/samples.h"

namespace karst::bake {

// Fine relief for the heights, finer than a voxel: `strata_m` tall layers, tilted a little, on top of an
// isotropic grain. Slopes stay below about 1/2, so that displaced triangles do not fold.
struct Grain {
  double strength_m = 0.5;
  double width_m = 6;   // of the largest bumps
  double strata_m = 4;  // height of a layer
  double strata_strength_m = 0;
  double calm_below_m = -1e9;  // ground below this height has a third of the grain: sand, gravel
  std::uint32_t seed = 1;

  // value_m plus the relief, which fades out away from the surface: it need not be computed there.
  double apply(double value_m, glm::dvec3 p) const;
};

// A sample before its grain, a function of the place that may be slow: it is tabulated.
struct SampleShape {
  virtual ~SampleShape() = default;
  virtual double value_m(glm::dvec3 position_m) const = 0;

  Box content_m;
  double voxel_m = 8;
  Grain grain;
};

std::unique_ptr<SampleShape> make_canyon();
std::unique_ptr<SampleShape> make_caves();
std::unique_ptr<SampleShape> make_arches();
std::unique_ptr<SampleShape> make_hills();

}  // namespace karst::bake
