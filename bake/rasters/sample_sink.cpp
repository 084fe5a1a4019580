// SPDX-License-Identifier: MIT
#include "bake/rasters/sample_sink.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <utility>

namespace karst::bake {
namespace {

constexpr double kMostRelief = 30'000;  // metres; of Mars, the most of all that is mapped
constexpr double kFarM = 1'000;         // that an extreme of any value is apart from all other heights
constexpr double kSeaCliffM = 100;      // the same where it is 0
constexpr double kShades = 0.5;         // of 1, that a picture has at least
constexpr double kUsualVoids[] = {999, 9'999, 99'999, 32'767, 32'768, 65'535};  // with either sign
constexpr double kSrtmVoid = -32'768;  // SRTM marks voids so, and seldom says it in a tag

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

}  // namespace

SampleSink::SampleSink(const ReadElevation& settings, const std::string& path, const SampleFormat& format,
                       ElevationPart& part)
    : settings_(settings), path_(path), format_(format), part_(part), nodata_(settings.nodata) {
  if (format.nodata) nodata_.push_back(*format.nodata);
  if (format.is_signed_16bit) nodata_.push_back(kSrtmVoid);
  // A float file holds its nodata value rounded to float.
  if (format.is_float) {
    for (double& v : nodata_) v = double{static_cast<float>(v)};
  }
}

Error SampleSink::take_row(int row, int column, std::span<const double> samples,
                           std::span<const unsigned char> mask) {
  const double scale = format_.metres_per_unit * settings_.z_scale.value_or(1);
  const std::size_t start = part_.heights.size();
  part_.heights.resize(start + samples.size() * sizeof(float));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double raw = samples[i];
    float height = std::numeric_limits<float>::quiet_NaN();
    const bool is_void = !std::isfinite(raw) || (!mask.empty() && mask[i] == 0) ||
                         std::find(nodata_.begin(), nodata_.end(), raw) != nodata_.end();
    if (!is_void) {
      const double height_m = (raw * format_.scale + format_.offset) * scale;
      if (!(std::abs(height_m) <= kMaxElevationM)) {
        return path_ + ": height " + number(raw) + " at column " +
               std::to_string(column + static_cast<int>(i)) + ", row " + std::to_string(row) +
               " is not within 100000 m; is it a void (--nodata V)?";
      }
      note_extreme(raw);
      height = static_cast<float>(height_m);
    }
    std::memcpy(part_.heights.data() + start + i * sizeof(float), &height, sizeof height);
  }
  return {};
}

Error SampleSink::finish() {
  part_.source = format_.kind;
  const double unit = std::abs(format_.scale * format_.metres_per_unit * settings_.z_scale.value_or(1));
  const double offset = format_.offset / format_.scale;
  if (format_.is_whole && offset == std::floor(offset)) part_.unit_m = unit;
  const std::size_t before = part_.warnings.size();
  for (const bool at_low : {true, false}) warn_of_void(at_low);
  const bool has_voids = part_.warnings.size() > before;
  const double relief = (high_ - low_) * unit;
  const bool is_count = format_.scale == 1 && !settings_.z_scale;
  if (!settings_.z_scale && relief > kMostRelief) {
    // The finer end of 16-bit height maps: counts of a range that only their author knows.
    if (format_.is_unsigned && is_count) {
      return path_ + ": heights from " + number(low_) + " to " + number(high_) +
             " would be more relief than any planet has; give --z-scale S, the metres of a count (1: they "
             "are metres), or --nodata V where one of them marks voids";
    }
    if (!has_voids) {
      part_.warnings.push_back(path_ +
                               ": more relief than any planet has; --z-scale S says the metres of a unit");
    }
  }
  // Of pictures: black to white.
  const bool is_shade = !format_.is_whole && is_count && !format_.is_unit_said;
  if (is_shade && low_ >= 0 && high_ <= 1 && relief > kShades) {
    part_.warnings.push_back(path_ +
                             ": heights within 0 to 1 look like shades of a picture; --z-scale S says the "
                             "metres from 0 to 1");
  }
  return {};
}

// Keeps the two least and the two greatest of the values that differ.
void SampleSink::note_extreme(double raw) {
  if (raw < low_) {
    next_low_ = std::exchange(low_, raw);
  } else if (raw > low_) {
    next_low_ = std::min(next_low_, raw);
  }
  if (raw > high_) {
    next_high_ = std::exchange(high_, raw);
  } else if (raw < high_) {
    next_high_ = std::max(next_high_, raw);
  }
}

// An extreme that is further from all other heights than these are from each other, and is a value that
// voids are often marked with, or very far.
void SampleSink::warn_of_void(bool at_low) {
  const double value = at_low ? low_ : high_;
  const double gap = at_low ? next_low_ - low_ : high_ - next_high_;
  const double rest = at_low ? high_ - next_low_ : next_high_ - low_;
  if (!std::isfinite(gap) || !(gap > rest)) return;
  const double gap_m =
      gap * std::abs(format_.scale * format_.metres_per_unit * settings_.z_scale.value_or(1));
  const bool is_usual =
      std::find(std::begin(kUsualVoids), std::end(kUsualVoids), std::abs(value)) != std::end(kUsualVoids);
  if (!is_usual && !(gap_m > (value == 0 ? kSeaCliffM : kFarM))) return;
  part_.warnings.push_back(path_ + ": heights of " + number(value) +
                           " are far from all others and may mark voids: --nodata " + number(value));
}

Error check_8bit(const ReadElevation& settings, const std::string& path, bool is_8bit) {
  if (!is_8bit || settings.allow_8bit) return {};
  return path + ": sample type: 8 bits give steps, not slopes; --allow-8bit takes it all the same";
}

}  // namespace karst::bake
