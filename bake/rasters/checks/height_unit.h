// SPDX-License-Identifier: MIT
// What the heights of a raster are counted in, and from where.
#pragma once

#include <string>

#include "bake/rasters/checks/file_check.h"

namespace karst::bake {

struct HeightUnit {
  bool is_said = false;   // by the band, by the vertical part of its CRS or by an old .prj
  double metres = 0;      // of a unit; 0: not known
  bool is_depth = false;  // counted downwards
  std::string name;       // as the file has it
};

// srs: of the raster, or what the user says instead; null: none.
HeightUnit height_unit(const CheckedRaster& raster, OGRSpatialReferenceH srs);

}  // namespace karst::bake
