// SPDX-License-Identifier: MIT
// One file of elevation, read in a child of this program: what it says of itself, and a part of its heights.
#pragma once

#include "bake/base/child.h"
#include "bake/elevation/elevation.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace karst::bake {

// Samples of a file: row 0 is its north and column 0 its west, whichever comes first in it.
struct Window {
  int column = 0, row = 0, width = 0, height = 0;
};

struct ElevationGrid {
  int width = 0, height = 0;
  bool placed = false;                                 // west to step_z are known
  double west = 0, north = 0, step_x = 0, step_z = 0;  // in units of crs
  std::string crs;                                     // WKT; empty: none
  ElevationEarth earth;                                // of the file's first sample; not placed: none
  std::uint64_t block_row_bytes = 0;                   // decoded: what reading a row takes
  std::vector<std::string> files;                      // that it is made of
};

struct ElevationPart {
  double spacing_x_m = 0, spacing_z_m = 0;
  double unit_m = 0;                  // heights are whole multiples of it; 0: not known
  std::string source;                 // for reports: "GTiff Int16, geographic"
  std::vector<std::string> warnings;  // a line each
  std::vector<std::byte> heights;     // floats, row by row; NaN where void
};

// Both tell in one line what is wrong with the file, or with the settings for it.
Error describe_elevation(const ReadElevation& settings, const std::string& path, ElevationGrid& grid);
// part lies in the file; whole, which the spacing is for, may go beyond it. grid: of the same file.
Error read_elevation_part(const ReadElevation& settings, const std::string& path, const ElevationGrid& grid,
                          const Window& whole, const Window& part, ElevationPart& result);

// The same without a child, and without its limits.
Error describe_elevation_here(const ReadElevation& settings, const std::string& path, ElevationGrid& grid);
Error read_elevation_part_here(const ReadElevation& settings, const std::string& path, const Window& whole,
                               const Window& part, ElevationPart& result);

// By GDAL (raster_elevation.cpp), and by OpenImageIO (exr_elevation.cpp).
Error describe_raster(const ReadElevation& settings, const std::string& path, ElevationGrid& grid);
Error describe_exr(const ReadElevation& settings, const std::string& path, ElevationGrid& grid);
Error read_raster(const ReadElevation& settings, const std::string& path, const Window& whole,
                  const Window& part, ElevationPart& result);
Error read_exr(const ReadElevation& settings, const std::string& path, const Window& part,
               ElevationPart& result);

extern const ChildTask kDescribeRaster, kReadRaster, kDescribeExr, kReadExr;

}  // namespace karst::bake
