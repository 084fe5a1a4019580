// SPDX-License-Identifier: MIT
#include "tests/golden/picture.h"

#include <algorithm>
#include <cstdlib>

#include <png.h>

namespace karst::test {

RgbPicture read_png(const std::string& path) {
  RgbPicture picture;
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&image, path.c_str()) == 0) return picture;
  image.format = PNG_FORMAT_RGB;
  picture.rgb.resize(static_cast<std::size_t>(image.width) * image.height * 3);
  if (png_image_finish_read(&image, nullptr, picture.rgb.data(), 0, nullptr) == 0) return {};
  picture.width = static_cast<int>(image.width);
  picture.height = static_cast<int>(image.height);
  return picture;
}

Difference compare(const RgbPicture& a, const RgbPicture& b) {
  Difference result;
  std::size_t beyond_one = 0;
  std::size_t far_apart = 0;
  double sum = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) {
    const int difference = std::abs(int{a.rgb[i]} - int{b.rgb[i]});
    sum += difference;
    result.largest = std::max(result.largest, difference);
    beyond_one += difference > 1 ? 1 : 0;
    far_apart += difference > kFarApart ? 1 : 0;
  }
  const auto values = static_cast<double>(std::max<std::size_t>(a.rgb.size(), 1));
  result.mean = sum / values;
  result.beyond_one = static_cast<double>(beyond_one) / values;
  result.far_apart = static_cast<double>(far_apart) / values;
  return result;
}

}  // namespace karst::test
