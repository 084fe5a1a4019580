// SPDX-License-Identifier: MIT
// Small elevation files for tests: raw TIFF files with any tag, images through OpenImageIO; and reading them.
#pragma once

#include "bake/elevation/elevation.h"

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace karst::bake {

// While it lives, memory that is lost does not count: OpenImageIO 2.4 leaks its error string when libpng
// jumps out of a damaged PNG.
class IgnoreLeaks {
 public:
  IgnoreLeaks();
  ~IgnoreLeaks();
  IgnoreLeaks(const IgnoreLeaks&) = delete;
  IgnoreLeaks& operator=(const IgnoreLeaks&) = delete;
};

template <class T>
std::string_view bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

// A little-endian TIFF of one strip whose directory says whatever a test wants.
class TiffBuilder {
 public:
  // sample_format: 1 unsigned, 2 signed, 3 float.
  TiffBuilder(std::uint32_t width, std::uint32_t height, int bits, int sample_format, std::string pixels);
  TiffBuilder& shorts(std::uint16_t tag, const std::vector<std::uint16_t>& values);
  TiffBuilder& doubles(std::uint16_t tag, const std::vector<double>& values);
  TiffBuilder& ascii(std::uint16_t tag, const std::string& text);
  // Pixel scale, tie point and geo keys as most GeoTIFFs have them.
  TiffBuilder& pixel_scale(double x, double y) { return doubles(33550, {x, y, 0}); }
  TiffBuilder& tie_point(double x, double y) { return doubles(33922, {0, 0, 0, x, y, 0}); }
  // Says that the bytes are compressed (Deflate), whether they are or not.
  TiffBuilder& compressed();
  TiffBuilder& geo_keys(const std::vector<std::uint16_t>& key_value_pairs);
  std::string bytes() const;

 private:
  struct Entry {
    std::uint16_t tag, type;
    std::uint32_t count;
    std::string data;
  };
  TiffBuilder& add(std::uint16_t tag, std::uint16_t type, std::uint32_t count, std::string data);
  std::vector<Entry> entries_;
  std::string pixels_;
};

// Writes one channel through OpenImageIO; type is "uint8", "uint16", "int16", "half" or "float", tile 0 means
// scanlines. The kind of file follows the name.
void write_image(const std::string& path, int width, int height, std::span<const float> samples,
                 const std::string& type, int tile = 0, int channels = 1);

// The message of the error that reading gives; empty where there is none.
std::string error_of(const ReadElevation& read);
Elevation elevation_of(const ReadElevation& read);

}  // namespace karst::bake
