// SPDX-License-Identifier: MIT
// A look at an OpenEXR file's header before the library opens it (OpenEXR, "File Layout": magic, version,
// attributes). The library sizes its tables by the data window as it opens a file; here that window is
// checked first.
#pragma once

#include <string>

#include "platform/base/error.h"

namespace karst::bake {

// An error unless path is a single-part flat OpenEXR file whose data window is within the limits of
// elevation.h and whose tiles, if it has any, are neither tiny nor larger than max_tile_side samples.
Error check_exr_header(const std::string& path, int max_tile_side);

}  // namespace karst::bake
