// SPDX-License-Identifier: MIT
#include "bench/measure/elevation_grid.h"

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>

#include <png.h>

#include "app/files/whole_file.h"

namespace karst::bench {
using namespace app;
namespace {

struct Source {
  std::span<const std::byte> rest;
  std::string error;
};

void on_error(png_structp png, png_const_charp text) {
  static_cast<Source*>(png_get_error_ptr(png))->error = text;
  png_longjmp(png, 1);
}

void on_warning(png_structp /*png*/, png_const_charp /*text*/) {}

void on_read(png_structp png, png_bytep out, size_t bytes) {
  Source& source = *static_cast<Source*>(png_get_io_ptr(png));
  if (bytes > source.rest.size()) png_error(png, "cut short");
  std::memcpy(out, source.rest.data(), bytes);
  source.rest = source.rest.subspan(bytes);
}

// Everything that a jump out of libpng must not skip the destructor of is owned by the caller.
bool read_rows(png_structp png, png_infop info, double z_scale, ElevationGrid& grid,
               std::vector<png_byte>& row) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_read_info(png, info);
  const png_uint_32 columns = png_get_image_width(png, info);
  const png_uint_32 rows = png_get_image_height(png, info);
  const int depth = png_get_bit_depth(png, info);
  constexpr png_uint_32 kMost = ElevationGrid::kMaxSide;
  if (columns < 2 || rows < 2 || columns > kMost || rows > kMost) {
    png_error(png, "not 2..32768 samples a side");
  }
  if (png_get_color_type(png, info) != PNG_COLOR_TYPE_GRAY || depth < 8)
    png_error(png, "not grey of 8 or 16 bits");
  if (png_get_interlace_type(png, info) != PNG_INTERLACE_NONE) png_error(png, "interlaced");
  grid.columns = static_cast<int>(columns);
  grid.rows = static_cast<int>(rows);
  const std::size_t bytes = depth == 16 ? 2 : 1;
  row.resize(columns * bytes);
  for (png_uint_32 r = 0; r < rows; ++r) {
    png_read_row(png, row.data(), nullptr);
    for (std::size_t i = 0; i < row.size(); i += bytes) {
      const int sample = bytes == 2 ? row[i] << 8 | row[i + 1] : row[i];
      grid.heights_m.push_back(static_cast<float>(sample * z_scale));
    }
  }
  return true;
}

}  // namespace

ElevationGrid::Range ElevationGrid::range(double x_m, double z_m) const {
  const auto place = [](double metres, double spacing, int samples) {
    return std::clamp(metres / spacing + 0.5 * (samples - 1), 0.0, samples - 1.0);
  };
  const double u = place(x_m, spacing_x_m, columns);
  const double v = place(z_m, spacing_z_m, rows);
  const int column = std::min(static_cast<int>(u), columns - 2);
  const int row = std::min(static_cast<int>(v), rows - 2);
  const double a = u - column;
  const double b = v - row;
  const float* h = &heights_m[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                              static_cast<std::size_t>(column)];
  const double h00 = h[0], h10 = h[1], h01 = h[columns], h11 = h[columns + 1];
  const double falling = a > b ? h00 + a * (h10 - h00) + b * (h11 - h10)  // cut from 00 to 11
                               : h00 + b * (h01 - h00) + a * (h11 - h01);
  const double rising = a + b < 1 ? h00 + a * (h10 - h00) + b * (h01 - h00)  // cut from 10 to 01
                                  : h11 + (1 - a) * (h01 - h11) + (1 - b) * (h10 - h11);
  return {std::min(falling, rising), std::max(falling, rising)};
}

bool ElevationGrid::inside(double x_m, double z_m, double margin_cells) const {
  return std::abs(x_m) <= (0.5 * (columns - 1) - margin_cells) * spacing_x_m &&
         std::abs(z_m) <= (0.5 * (rows - 1) - margin_cells) * spacing_z_m;
}

Error read_elevation_png(const std::string& path, double pixel_size_m, double z_scale, ElevationGrid& grid) {
  WholeFile file;
  if (Error error = file.open(path, WholeFile::kMostBytes); !error.ok()) return error;
  Source source{file.bytes(), {}};
  grid = {};
  grid.spacing_x_m = grid.spacing_z_m = pixel_size_m;
  if (source.rest.size() < 8 ||
      png_sig_cmp(reinterpret_cast<png_const_bytep>(source.rest.data()), 0, 8) != 0) {
    return path + ": not a PNG file";
  }
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &source, on_error, on_warning);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  bool read = false;
  std::vector<png_byte> row;
  if (info != nullptr) {
    png_set_read_fn(png, &source, on_read);
    read = read_rows(png, info, z_scale, grid, row);
  }
  png_destroy_read_struct(&png, &info, nullptr);
  if (!read) return path + ": " + (source.error.empty() ? "no memory" : source.error);
  return {};
}

}  // namespace karst::bench
