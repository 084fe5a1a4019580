// SPDX-License-Identifier: MIT
// What GDAL reads without a word although a file's header and its samples do not agree, or the header leaves
// open what they mean.
#pragma once

#include <gdal.h>

#include <string>
#include <string_view>
#include <vector>

#include "platform/base/error.h"

namespace karst::bake {

// An open raster, the band of it that is taken, and the path it was opened by, for messages.
struct CheckedRaster {
  GDALDatasetH file = nullptr;
  GDALRasterBandH band = nullptr;
  const std::string& path;
};

// Raw samples with a header beside them; all other rasters are right. is_sized: nobody asks for what the
// header says of sizes. warnings: without the file's name.
Error check_raw_file(const CheckedRaster& raster, bool is_sized, std::vector<std::string>& warnings);

// Numbers as text below a header (Arc/Info ASCII, GRASS ASCII): reads all of the file.
Error check_text_grid(const CheckedRaster& raster);

// The start of the raster's file whose name ends so, in any case; empty where there is none.
std::string text_beside(GDALDatasetH file, std::string_view ending);

std::string lower_case(std::string_view text);

}  // namespace karst::bake
