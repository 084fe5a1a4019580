// SPDX-License-Identifier: MIT
// An elevation image in memory, and the bilinear surface through its samples.
//
// Image row 0 is the north (smallest z) and column 0 the west (smallest x). World metres have their origin at
// the image's centre in x and z; y is the elevation itself.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "platform/base/error.h"

namespace karst::bake {

// Limits on what a file may claim, checked before anything is allocated.
inline constexpr int kMaxElevationSide = 32'768;  // samples
inline constexpr std::int64_t kMaxElevationSamples =
    1LL << 28;                                 // 1.25 GiB with the mask: a host's memory, not a typo's
inline constexpr double kMinSpacingM = 1e-4;   // a scanned model
inline constexpr double kMaxSpacingM = 1e6;    // a planet in 40 samples
inline constexpr double kMaxElevationM = 1e5;  // |height|; four times Olympus Mons

// Where samples lie on the earth, as far as the files say it.
struct ElevationEarth {
  enum class Kind : std::uint8_t { none, degrees, transverse_mercator, other };
  Kind kind = Kind::none;
  std::uint32_t epsg = 0;  // 0: not known
  // Coordinates of the first sample's middle, and how far it is to the next ones, to the east and to the
  // south: degrees, or the projection's units.
  double west = 0, north = 0, step_x = 0, step_z = 0;
  double radius_m = 6'378'137.0, flattening = 1 / 298.257223563;
  double unit_m = 1;
  // Of the transverse Mercator projection: degrees and metres.
  double scale = 1, latitude_deg = 0, longitude_deg = 0, false_east_m = 0, false_north_m = 0;
};

struct Elevation {
  int width = 0;                      // samples from west to east, 2..kMaxElevationSide
  int height = 0;                     // samples from north to south, 2..kMaxElevationSide
  std::vector<float> heights_m;       // width x height, row by row; 0 where void
  std::vector<std::uint8_t> valid;    // 1 where the sample is known, 0 where it is void
  double spacing_x_m = 1.0;           // between columns, in [kMinSpacingM, kMaxSpacingM]
  double spacing_z_m = 1.0;           // between rows
  std::uint64_t voids = 0;            // samples that were void in the file
  std::vector<std::string> warnings;  // what may be read wrongly, a line each
  std::string source;                 // for reports: "GeoTIFF int16, geographic"
  ElevationEarth earth;

  std::size_t samples() const { return heights_m.size(); }
  std::size_t at(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
  }
};

struct ReadElevation {
  std::string path{};
  std::vector<std::string> more{};  // files beside path: one grid, and the first that knows a sample says it
  double pixel_size_m = 0;          // > 0 overrides what the file says; 0: the file must say
  std::optional<double> z_scale{};  // heights are multiplied by this after nodata is taken out
  bool allow_8bit = false;
  int band = 0;                  // from 1; 0: the only one
  std::int64_t max_samples = 0;  // taken even of files that are too short to hold so many heights
  std::string crs{};             // EPSG:CODE; overrides what the file says; empty: the file's
  std::optional<std::array<double, 4>> bounds{};  // west, south, east, north of the image's edges; overrides
  std::vector<double> nodata{};                   // values that mark voids, besides those the file names
  int crop[4] = {0, 0, 0, 0};  // first column, first row, columns, rows; all 0: the whole image

  // Reads what GDAL reads by the drivers of raster_elevation.cpp, and OpenEXR, in a process of its own
  // (bake/base/child.h). Samples that are NaN, infinite, masked, equal to a nodata value or, in signed
  // 16-bit files, -32768 (SRTM's void) are void. At least one sample is valid.
  Error run(Elevation& result) const;

  // All files that run() reads, as far as they can be found: headers, masks, the parts of mosaics.
  std::vector<std::string> files() const;
};

// Where samples lie: row 0 is the north, column 0 the west, and the middle of sample (0, 0) is at west +
// step_x / 2, north - step_z / 2 in units of crs.
struct SamplePlace {
  bool known = false;
  double west = 0, north = 0, step_x = 1, step_z = 1;
  std::string crs;  // WKT; empty: none
};

// The same, some rows at a time, for elevation that is larger than memory.
class ElevationRows {
 public:
  // Limits of what is read so.
  static constexpr std::int64_t kMostSide = 1 << 22;
  static constexpr std::int64_t kMostSamples = std::int64_t{1} << 40;

  ElevationRows();
  ElevationRows(const ElevationRows&) = delete;
  ElevationRows& operator=(const ElevationRows&) = delete;
  ~ElevationRows();

  // settings outlive this. Reads what the files say of themselves, and some rows.
  Error open(const ReadElevation& settings);
  // Heights of rows [first, first + count), NaN where void. out: count x width().
  Error read(int first, int count, std::span<float> out);

  int width() const;
  int height() const;
  // Of rows that take about 16 MiB.
  int rows_at_once() const;
  // Known when rows have been read: no heights, and what they may be read wrongly by.
  const Elevation& facts() const;
  double unit_m() const;             // heights are whole multiples of it; 0: not known
  std::uint64_t file_bytes() const;  // of all that the files are made of
  // After open().
  SamplePlace place() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Fills voids smoothly from the samples around them and marks all samples valid. `voids` keeps its count.
// Precondition: at least one sample is valid.
void fill_voids(Elevation& elevation);

// The bilinear surface through the samples of an elevation that outlives it; beyond the outermost samples the
// nearest border point. Called tens of millions of times.
class ElevationSurface {
 public:
  explicit ElevationSurface(const Elevation& e)
      : heights_(e.heights_m.data()),
        valid_(e.valid.data()),
        width_(static_cast<std::size_t>(e.width)),
        last_column_(e.width - 1),
        last_row_(e.height - 1),
        columns_per_m_(1.0 / e.spacing_x_m),
        rows_per_m_(1.0 / e.spacing_z_m) {}

  // Elevation in metres at world metres x (east), z (south). Voids count as height 0: fill them or mind
  // validity().
  double at(double x_m, double z_m) const {
    Cell c = cell(x_m, z_m);
    const float* h = heights_ + c.first;
    const double north = double{h[0]} + c.u * (double{h[1]} - double{h[0]});
    h += width_;
    const double south = double{h[0]} + c.u * (double{h[1]} - double{h[0]});
    return north + c.v * (south - north);
  }

  // 1 where all samples around are known, 0 where none is, bilinear between.
  double validity(double x_m, double z_m) const {
    const Cell c = cell(x_m, z_m);
    const std::uint8_t* m = valid_ + c.first;
    const double north = m[0] + c.u * (m[1] - m[0]);
    m += width_;
    const double south = m[0] + c.u * (m[1] - m[0]);
    return north + c.v * (south - north);
  }

  // Metres from the image's centre to the outermost samples.
  double half_width_m() const { return 0.5 * last_column_ / columns_per_m_; }
  double half_height_m() const { return 0.5 * last_row_ / rows_per_m_; }

 private:
  struct Cell {
    std::size_t first;  // index of the north-west sample
    double u, v;        // 0..1 towards east and south
  };

  Cell cell(double x_m, double z_m) const {
    const double i = clamp(x_m * columns_per_m_ + 0.5 * last_column_, last_column_);
    const double j = clamp(z_m * rows_per_m_ + 0.5 * last_row_, last_row_);
    const int column = i < last_column_ ? static_cast<int>(i) : last_column_ - 1;
    const int row = j < last_row_ ? static_cast<int>(j) : last_row_ - 1;
    return {static_cast<std::size_t>(row) * width_ + static_cast<std::size_t>(column), i - column, j - row};
  }
  static double clamp(double x, double high) { return x > 0 ? (x < high ? x : high) : 0; }  // NaN gives 0

  const float* heights_;
  const std::uint8_t* valid_;
  std::size_t width_;
  int last_column_, last_row_;
  double columns_per_m_, rows_per_m_;
};

}  // namespace karst::bake
