// SPDX-License-Identifier: MIT
// A look at a VRT, GDAL's description of a raster by others, before GDAL follows it: a VRT may name any file,
// an address on the net, or code.
#pragma once

#include <string>

#include "platform/base/error.h"

namespace karst::bake {

// Is path a VRT? By its first bytes, as GDAL tells it.
bool is_mosaic(const std::string& path);

// An error unless the VRT is a mosaic as gdalbuildvrt writes it, of files in its own folder or below.
Error check_mosaic(const std::string& path);

}  // namespace karst::bake
