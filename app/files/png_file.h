// SPDX-License-Identifier: MIT
// Pictures as PNG, through libpng.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "platform/base/error.h"

namespace karst::app {

// rgba: width x height x 4 bytes, row 0 at the top; alpha is left out. The error is libpng's reason;
// png is then empty.
Error encode_png(std::span<const std::uint8_t> rgba, int width, int height, std::vector<std::byte>& png);

struct PngPicture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;  // row 0 at the top
};
// Any PNG as 8 bits a channel, sRGB. most_side, pixels, and most_bytes, of rgba: larger pictures are refused
// before memory is taken for them. The error tells what is wrong with the bytes; picture is then empty.
Error decode_png(std::span<const std::byte> png, int most_side, std::uint64_t most_bytes,
                 PngPicture& picture);

}  // namespace karst::app
