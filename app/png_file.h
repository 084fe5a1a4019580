// SPDX-License-Identifier: MIT
// Pictures as PNG, through libpng.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace karst::app {

// rgba: width x height x 4 bytes, row 0 at the top; alpha is left out. Returns an empty string on success,
// else libpng's reason; png is then empty.
[[nodiscard]] std::string encode_png(std::span<const std::uint8_t> rgba, int width, int height,
                                     std::vector<std::byte>& png);

}  // namespace karst::app
