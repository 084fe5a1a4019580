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

  // Of a place at the surface.
  double relief_m(glm::dvec3 p) const { return rough_m(p) * calm(p.y); }
  // value_m plus the relief, which fades out away from the surface: it need not be computed there.
  double apply(double value_m, glm::dvec3 p) const;

 private:
  double rough_m(glm::dvec3 p) const;
  double calm(double y) const;
};

// The ground around a sample, which becomes a plain with the distance from the middle.
struct SampleLand {
  double plain_m = 0;  // height, no higher than any ground of the sample but for beds of rivers
  double fades_from_m = 700, fades_to_m = 2400;
};

// A sample before its grain, a function of the place that may be slow: it is tabulated.
struct SampleShape {
  virtual ~SampleShape() = default;
  virtual double value_m(glm::dvec3 position_m) const = 0;
  // Height of the ground, anywhere: at the content's sides about that of the solid, without what overhangs.
  virtual double ground_m(double x, double z) const = 0;
  // What stands far from the sample, above the plain. away_m: from the middle.
  virtual double far_m(double x, double z, double away_m) const = 0;

  Box content_m;
  double voxel_m = 8;
  Grain grain;
  SampleLand land;
};

// Shares of a height, 0 to about 1: tables of rock with steep walls, and ranges with ridges and valleys.
// width_m: of the largest.
double mesas(double x, double z, double width_m, std::uint32_t seed);
double mountains(double x, double z, double width_m, std::uint32_t seed);

std::unique_ptr<SampleShape> make_canyon();
std::unique_ptr<SampleShape> make_caves();
std::unique_ptr<SampleShape> make_arches();
std::unique_ptr<SampleShape> make_hills();

}  // namespace karst::bake
