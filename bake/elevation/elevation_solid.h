// SPDX-License-Identifier: MIT
// Elevation as a solid: all below the bilinear surface, or all below the mean elevation of each voxel column.
#pragma once

#include "bake/elevation/elevation.h"
#include "bake/elevation/solid.h"

#include <cstdint>
#include <vector>

namespace karst::bake {

// The solid below a bilinear elevation. Where `known` is given, it ends at the border of the voids: the
// solid's sides there stand where half of the weight of the samples around is void.
class ElevationSolid final : public Solid {
 public:
  // elevation outlives the solid. holes: elevation.valid marks what is left out.
  ElevationSolid(const Elevation& elevation, bool holes);
  double value_m(glm::dvec3 position_m) const override;
  double elevation_m(double x_m, double z_m) const { return surface_.at(x_m, z_m); }
  bool in_hole(double x_m, double z_m) const { return holes_ && surface_.validity(x_m, z_m) < 0.5; }
  const ElevationSurface& surface() const { return surface_; }

 private:
  ElevationSurface surface_;
  double cell_m_;  // turns validity into a length
  bool holes_;
};

// Column tops of a grid in voxels from its bottom, index z * extent.x + x, NaN where most of a column is a
// hole. The mean elevation over the column's footprint (K 3.2 averages blocks of the image; here the bilinear
// surface, so that any voxel size goes with any spacing), rounded to whole voxels and settled, see
// settle_tops.
std::vector<float> column_tops(const ElevationSolid& solid, const Elevation& elevation, const WorldGrid& grid,
                               int threads);

// Takes away what is one column wide: on tips, pits and columns that touch only across an edge the smoothed
// gradient that vertices move along turns against the surface, and neighbouring vertices pass each other. The
// heights that are fitted afterwards bring the shape back. On return every column has at least two of its
// four neighbours as high and two as low as itself, and of four columns around a corner the two diagonal ones
// are not both higher than the other two; but for a few, where these rules contradict each other. tops: means
// in, whole voxels out.
void settle_tops(std::vector<float>& tops, int width, int height);

// The solid below column tops: what the voxels of a height field are made from before shapes are carved.
class ColumnSolid final : public Solid {
 public:
  // tops outlive the solid.
  ColumnSolid(const std::vector<float>& tops, const WorldGrid& grid) : tops_(tops), grid_(grid) {}
  double value_m(glm::dvec3 position_m) const override;

 private:
  const std::vector<float>& tops_;
  WorldGrid grid_;
};

}  // namespace karst::bake
