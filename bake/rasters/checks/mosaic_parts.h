// SPDX-License-Identifier: MIT
// Are the parts of a VRT what the VRT says of them? GDAL copies their samples as they are, cut to the VRT's
// type, and leaves out the parts' own scale, unit, voids and masks.
#pragma once

#include "bake/rasters/checks/file_check.h"

namespace karst::bake {

// mosaic: an open VRT that check_mosaic() let pass. The error names the part.
Error check_mosaic_parts(const CheckedRaster& mosaic);

}  // namespace karst::bake
