// SPDX-License-Identifier: MIT
// The letters of the editor's lines: printable ASCII, 5 x 8 dots in cells of 8 x 8 texels.
#pragma once

#include <cstdint>
#include <span>

namespace karst::app {

inline constexpr int kFontWidth = 128, kFontHeight = 64;  // texels of the atlas: 16 x 8 cells
inline constexpr int kGlyphWidth = 5, kGlyphHeight = 8;   // dots, at the top left of a cell
inline constexpr int kCellSide = 8;
inline constexpr int kSolidCell = 127;  // all of it is covered: for lines and boxes

// One byte a texel, 255 where it is covered, row 0 first; letter c is cell c, from the left and the top.
// atlas: kFontWidth x kFontHeight bytes.
void make_font(std::span<std::uint8_t> atlas);

}  // namespace karst::app
