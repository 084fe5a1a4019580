// SPDX-License-Identifier: MIT
// Pictures read from PNG files, and how far two of them are apart.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace karst::test {

struct RgbPicture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;  // row 0 at the top; empty where the file could not be read
};

RgbPicture read_png(const std::string& path);

struct Difference {
  double mean = 0;  // of the absolute differences of all values, 0..255
  int largest = 0;
  double beyond_one = 0;  // share of values that differ by more than 1
  double far_apart = 0;   // share of values that differ by more than kFarApart
};
inline constexpr int kFarApart = 24;

// Precondition: same size.
Difference compare(const RgbPicture& a, const RgbPicture& b);

}  // namespace karst::test
