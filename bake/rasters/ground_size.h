// SPDX-License-Identifier: MIT
// How large a sample of a raster is on the ground, from its geotransform and its coordinate reference system.
#pragma once

#include "bake/rasters/elevation_file.h"
#include "platform/base/error.h"

#include <gdal.h>
#include <ogr_srs_api.h>

#include <array>
#include <string>
#include <vector>

namespace karst::bake {

// Metres of a degree of longitude (x) and latitude (y) on an ellipsoid at a latitude in degrees,
// |latitude| < 90. Snyder, "Map Projections: A Working Manual" (USGS PP 1395, 1987), equations 4-18, 4-19.
struct DegreeM {
  double x, y;
};
struct Ellipsoid {  // WGS84: EPSG dataset, ellipsoid 7030
  double equatorial_radius_m = 6'378'137.0;
  double flattening = 1 / 298.257223563;
};
DegreeM metres_per_degree(double latitude_deg, const Ellipsoid& ellipsoid = {});

// Where the samples of a raster lie, once rows run from the north and columns from the west.
struct Placement {
  // Column and row to coordinates of the CRS, GDAL's six numbers; numbers 2 and 4 are 0, and where it is
  // placed 1 is above 0 and 5 below.
  std::array<double, 6> to_crs{0, 1, 0, 0, 0, 1};
  bool placed = false;
  bool sized = false;            // numbers 1 and 5 hold, whether it is placed or not
  bool rows_from_south = false;  // in the file
  bool columns_from_east = false;

  // The error, without the file's name, is of a raster that is turned.
  Error read(GDALDatasetH file);
  // West, south, east and north of the image's edges, instead. The error is of bounds that are none.
  Error set_bounds(GDALDatasetH file, const std::array<double, 4>& bounds);
};

struct GroundSize {
  double x_m = 0, z_m = 0;  // between columns, between rows; not range-checked
  bool in_feet = false;     // the horizontal axes are
  std::string note;         // for reports: "geographic"; may be empty
  std::vector<std::string> warnings;

  // given_m > 0: the user's word goes before the file's. In degrees, and in projections that stretch the
  // ground by more than a hundredth there, the size is that at the window's middle. The error is without the
  // file's name.
  // srs: null: none.
  Error read(GDALDatasetH file, OGRSpatialReferenceH srs, const Placement& placement, const Window& window,
             double given_m);
};

// What a coordinate reference system says of where samples lie; none where it is null or the raster is not
// placed.
ElevationEarth earth_of(OGRSpatialReferenceH srs, const Placement& placement);

}  // namespace karst::bake
