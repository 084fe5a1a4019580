// SPDX-License-Identifier: MIT
// From the samples of a file, of whatever kind it is, to heights and voids.
#pragma once

#include "bake/elevation/elevation.h"
#include "bake/rasters/elevation_file.h"

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace karst::bake {

// What a file says about its samples.
struct SampleFormat {
  std::string kind;  // "GTiff Int16"
  bool is_8bit = false;
  bool is_signed_16bit = false;
  bool is_float = false;     // of 32 bits or fewer
  bool is_unsigned = false;  // and whole, of more than 8 bits
  bool is_whole = false;
  bool is_unit_said = false;  // of heights
  double scale = 1, offset = 0;
  double metres_per_unit = 1;  // below 0: depths
  std::optional<double> nodata;
};

class SampleSink {
 public:
  // All outlive the sink.
  SampleSink(const ReadElevation& settings, const std::string& path, const SampleFormat& format,
             ElevationPart& part);

  // The next row of the part. row, column: of the first sample, for messages. mask: 0 where a sample is void;
  // empty: it says nothing.
  Error take_row(int row, int column, std::span<const double> samples, std::span<const unsigned char> mask);
  // After the last row: what the heights as a whole tell.
  Error finish();

 private:
  void note_extreme(double raw);
  void warn_of_void(bool at_low);

  const ReadElevation& settings_;
  const std::string& path_;
  const SampleFormat& format_;
  ElevationPart& part_;
  std::vector<double> nodata_;
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double low_ = kInfinity, next_low_ = kInfinity, high_ = -kInfinity, next_high_ = -kInfinity;
};

// Refuses 8 bits that nobody has allowed.
Error check_8bit(const ReadElevation& settings, const std::string& path, bool is_8bit);

}  // namespace karst::bake
