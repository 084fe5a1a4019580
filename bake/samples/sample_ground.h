// SPDX-License-Identifier: MIT
// The ground in which a sample lies: heights for kilometres around it, and the solid that joins the sample's
// to them. Fine near the sample, smooth far from it, level at its border, where the plain without end begins.
#pragma once

#include "bake/elevation/elevation.h"
#include "bake/elevation/solid.h"
#include "bake/samples/samples.h"

namespace karst::bake {

// Where a sample's voxels stand in its ground: nodes of four samples, 2^node_voxels_log2 voxels wide.
struct SampleGrid {
  double spacing_m = 1;      // between samples
  int node_voxels_log2 = 0;  // g of terrain/ground/ground.h
  int samples[2] = {};       // along x and z; the middle is the world's origin
  int first_node[2] = {};    // of the voxels, and how many nodes are theirs
  int nodes[2] = {};

  // Samples about as far apart as the sample's own ones whatever the voxel, nodes around all of its content.
  // An error that names --voxel, as WorldGrid::around() has it.
  static Error around(const Sample& sample, double voxel_m, SampleGrid& grid);

  // Of the voxels' rectangle, metres; y 0.
  Box rectangle_m() const;
};

// Heights are whole multiples of it: a thirtieth of a metre is nothing between samples metres apart, and
// tiles take fewer bytes.
inline constexpr double kSampleUnitM = 1.0 / 32;

// Heights over all of the grid, none void. The same whatever threads is.
Elevation sample_elevation(const Sample& sample, const SampleGrid& grid, int threads);

// The sample inside of a rectangle, and at its sides the ground: there heights and slopes are the ground's.
class SampleInGround final : public Solid {
 public:
  // sample and ground outlive this. rectangle: y does not matter.
  SampleInGround(const Solid& sample, const ElevationSurface& ground, const Box& rectangle_m, double width_m)
      : sample_(sample), ground_(ground), rectangle_m_(rectangle_m), per_width_(1 / width_m) {}
  double value_m(glm::dvec3 position_m) const override;

 private:
  const Solid& sample_;
  const ElevationSurface& ground_;
  Box rectangle_m_;
  double per_width_;  // of the strip along the sides in which one becomes the other
};

}  // namespace karst::bake
