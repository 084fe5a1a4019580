// SPDX-License-Identifier: MIT
// How large a sample of an elevation image is on the ground.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "platform/base/error.h"

namespace karst::bake {

// Metres of a degree of longitude (x) and latitude (y) on the WGS84 ellipsoid at a latitude in degrees,
// |latitude| < 90. EPSG dataset, ellipsoid 7030; Snyder, "Map Projections: A Working Manual" (USGS PP 1395,
// 1987), equations 4-18, 4-19.
struct DegreeM {
  double x, y;
};
DegreeM metres_per_degree(double latitude_deg);

// What a GeoTIFF says about its samples (OGC 19-008r4). OpenImageIO 2.4 drops these tags, so libtiff reads
// them.
struct GeoTiffTags {
  std::optional<double> spacing_x_m, spacing_z_m;  // absent where the file has no pixel scale
  std::optional<double> nodata;                    // GDAL_NODATA
  double metres_per_unit = 1;                      // of the heights
  bool geographic = false;
};

// What nobody has given, so that the file has to say it.
struct GeoTiffNeeds {
  std::int64_t twice_middle = 0;  // twice the row in the middle of what is taken, for its latitude
  bool scale = true;              // false: tags that say nothing usable about the scale are no error
  bool height_unit = true;        // the same for heights
};

// The error names path and tag: among them are rotated and mirrored images and units that cannot be known,
// which would be read wrongly. Spacings are not range-checked here.
Error read_geotiff_tags(const std::string& path, const GeoTiffNeeds& needs, GeoTiffTags& tags);

}  // namespace karst::bake
