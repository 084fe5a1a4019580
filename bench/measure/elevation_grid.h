// SPDX-License-Identifier: MIT
// Elevation samples that pictures are measured against: what a world was baked from.
//
// World metres as karst-bake makes them: x = z = 0 is the grid's centre, row 0 the north (smallest z), column
// 0 the west (smallest x), y the elevation.
#pragma once

#include <string>
#include <vector>

#include "platform/base/error.h"

namespace karst::bench {

struct ElevationGrid {
  int columns = 0, rows = 0;                    // samples, 2..kMaxSide
  double spacing_x_m = 1.0, spacing_z_m = 1.0;  // between samples
  std::vector<float> heights_m;                 // columns x rows, row by row

  static constexpr int kMaxSide = 32'768;

  struct Range {
    double low_m, high_m;
  };
  // Heights of the two ways to cut the cell at x, z into triangles: a mesh through the samples has one of
  // them. Outside the grid, of its nearest cell, extended.
  Range range(double x_m, double z_m) const;

  // Whether x, z lies inside the grid less so many cells at its border.
  bool inside(double x_m, double z_m, double margin_cells) const;
};

// Reads a grey PNG of 8 or 16 bits, heights = samples x z_scale. The error names the file and the cause.
// pixel_size_m, z_scale: as given to karst-bake.
Error read_elevation_png(const std::string& path, double pixel_size_m, double z_scale, ElevationGrid& grid);

}  // namespace karst::bench
