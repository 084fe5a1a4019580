// SPDX-License-Identifier: MIT
// Reading elevation: files that lie on one grid, each read in a child of this program (elevation_file.h),
// and what is taken of them.
#include "bake/elevation/elevation.h"

#include "app/files/regular_file.h"
#include "bake/rasters/elevation_file.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace karst::bake {
namespace {

// Samples that are taken whatever the length of the files, and more for each of their bytes: elevation is
// compressed to a byte or two a sample. What is beyond is a sea, or made to take memory and time.
constexpr std::uint64_t kFreeSamples = 1 << 19;
constexpr std::uint64_t kSamplesAByte = 4;
constexpr double kOffGrid = 0.01;  // samples

Error failure(const std::string& path, const std::string& what) {
  return path + ": " + what;
}

struct SizeLimits {
  std::int64_t side = kMaxElevationSide;
  std::int64_t samples = kMaxElevationSamples;
};

Error check_size(const std::string& path, const SizeLimits& limits, std::int64_t width, std::int64_t height) {
  const std::string size = std::to_string(width) + " x " + std::to_string(height);
  if (width < 2 || height < 2) return failure(path, "size: " + size + " samples; each side needs 2 or more");
  if (width > limits.side || height > limits.side || width * height > limits.samples) {
    return failure(path, "size: " + size + " samples; the most is " + std::to_string(limits.side) +
                             " a side and " + std::to_string(limits.samples) +
                             " together; --crop takes a part");
  }
  return {};
}

// A file, and where its samples lie among those of the first.
struct Part {
  std::string path;
  std::uint64_t bytes = 0;
  ElevationGrid grid;
  std::int64_t column = 0, row = 0;
};

// Which samples of the first file those of part lie on.
Error place(const Part& first, Part& part) {
  const ElevationGrid& a = first.grid;
  const ElevationGrid& b = part.grid;
  if (!a.placed || !b.placed) {
    return failure((a.placed ? part : first).path,
                   "does not say where it lies, and several files need to; gdal_translate -a_ullr says it");
  }
  const auto apart = [](double x, double y, int count) {
    return !(std::abs(x - y) * count <= kOffGrid * std::abs(x));
  };
  if (a.crs != b.crs || apart(a.step_x, b.step_x, std::max(a.width, b.width)) ||
      apart(a.step_z, b.step_z, std::max(a.height, b.height))) {
    return failure(part.path, "has another coordinate reference system or sample size than " + first.path +
                                  "; gdalwarp makes one raster of both");
  }
  const double column = (b.west - a.west) / a.step_x, row = (a.north - b.north) / a.step_z;
  if (!(std::abs(column - std::round(column)) <= kOffGrid && std::abs(row - std::round(row)) <= kOffGrid)) {
    return failure(part.path,
                   "its samples lie between those of " + first.path + "; gdalwarp makes one raster of both");
  }
  constexpr double kFarthest = 1e9;
  if (!(std::abs(column) < kFarthest && std::abs(row) < kFarthest))
    return failure(part.path, "lies far away from " + first.path);
  part.column = std::llround(column);
  part.row = std::llround(row);
  return {};
}

class Reader {
 public:
  Reader(const ReadElevation& settings, const SizeLimits& limits, Elevation& result)
      : settings_(settings), limits_(limits), result_(result) {}

  Error open() {
    if (Error error = describe(); !error.ok()) return error;
    return choose_window();
  }

  // Rows of the window; out is NaN where no part knows a sample.
  Error read_rows(int first, int count, std::span<float> out) {
    std::fill(out.begin(), out.end(), std::numeric_limits<float>::quiet_NaN());
    for (const Part& part : parts_) {
      if (Error error = read(part, first, count, out); !error.ok()) return error;
    }
    return {};
  }
  double unit_m() const { return unit_m_; }
  std::uint64_t file_bytes() const { return bytes_; }
  SamplePlace sample_place() const {
    const ElevationGrid& grid = parts_.front().grid;
    if (!grid.placed) return {};
    return {true,
            grid.west + static_cast<double>(west_) * grid.step_x,
            grid.north - static_cast<double>(north_) * grid.step_z,
            grid.step_x,
            grid.step_z,
            grid.crs};
  }

  Error run() {
    if (Error error = open(); !error.ok()) return error;
    const std::size_t samples =
        static_cast<std::size_t>(result_.width) * static_cast<std::size_t>(result_.height);
    result_.heights_m.assign(samples, 0);
    if (Error error = read_rows(0, result_.height, result_.heights_m); !error.ok()) return error;
    result_.valid.assign(samples, 1);
    for (std::size_t k = 0; k < samples; ++k) {
      if (!std::isnan(result_.heights_m[k])) continue;
      result_.heights_m[k] = 0;
      result_.valid[k] = 0;
      ++result_.voids;
    }
    if (result_.voids == samples) return failure(settings_.path, "no sample is valid: all are void");
    if (parts_.size() > 1) result_.source += ", " + std::to_string(parts_.size()) + " files";
    return {};
  }

 private:
  Error describe() {
    std::vector<std::string> paths = settings_.more;
    paths.insert(paths.begin(), settings_.path);
    for (const std::string& path : paths) {
      Part part{path, 0, {}, 0, 0};
      int file = -1;
      if (Error error = app::open_regular_file(path, file, part.bytes); !error.ok()) return error;
      close(file);
      if (Error error = describe_elevation(settings_, path, part.grid); !error.ok()) return error;
      for (const std::string& name : part.grid.files) {
        std::uint64_t bytes = 0;
        if (!app::open_regular_file(name, file, bytes).ok()) continue;
        close(file);
        bytes_ += bytes;
      }
      if (!parts_.empty()) {
        if (Error error = place(parts_.front(), part); !error.ok()) return error;
      }
      parts_.push_back(std::move(part));
    }
    return {};
  }

  // Of all files together, or of the crop.
  Error choose_window() {
    std::int64_t east = 0, south = 0;
    for (const Part& part : parts_) {
      west_ = std::min(west_, part.column);
      north_ = std::min(north_, part.row);
      east = std::max(east, part.column + part.grid.width);
      south = std::max(south, part.row + part.grid.height);
    }
    const std::int64_t whole_width = east - west_, whole_height = south - north_;
    const int* const crop = settings_.crop;
    const bool cropped = crop[2] != 0 || crop[3] != 0;
    std::int64_t width = whole_width, height = whole_height;
    if (cropped) {
      if (crop[0] < 0 || crop[1] < 0 || crop[2] < 2 || crop[3] < 2 || crop[0] > whole_width - crop[2] ||
          crop[1] > whole_height - crop[3]) {
        return failure(settings_.path, "--crop: not inside the image of " + std::to_string(whole_width) +
                                           " x " + std::to_string(whole_height) +
                                           " samples, or less than 2 x 2");
      }
      west_ += crop[0];
      north_ += crop[1];
      width = crop[2];
      height = crop[3];
    }
    if (Error error = check_size(settings_.path, limits_, width, height); !error.ok()) return error;
    const auto samples = static_cast<std::uint64_t>(width * height);
    const auto allowed = static_cast<std::uint64_t>(std::max<std::int64_t>(settings_.max_samples, 0));
    if (samples > std::max(allowed, kFreeSamples + kSamplesAByte * bytes_)) {
      return failure(settings_.path, "size: " + std::to_string(width) + " x " + std::to_string(height) +
                                         " samples in " + std::to_string(bytes_) +
                                         " bytes, which hold few heights; --crop takes a part, "
                                         "--max-samples " +
                                         std::to_string(samples) + " all of them");
    }
    result_.width = static_cast<int>(width);
    result_.height = static_cast<int>(height);
    result_.earth = parts_.front().grid.earth;
    result_.earth.west += result_.earth.step_x * static_cast<double>(west_);
    result_.earth.north -= result_.earth.step_z * static_cast<double>(north_);
    return {};
  }

  Error read(const Part& part, int first, int count, std::span<float> out) {
    // The window that is taken, seen from the file, and what of the rows is in the file.
    const std::int64_t column = west_ - part.column, row = north_ - part.row;
    const auto first_column = std::max<std::int64_t>(column, 0);
    const auto end_column = std::min<std::int64_t>(column + result_.width, part.grid.width);
    const bool is_first = &part == &parts_.front();
    const auto of_file = [&](std::int64_t from, std::int64_t to) {
      return std::pair(std::max<std::int64_t>(from, 0), std::min<std::int64_t>(to, part.grid.height));
    };
    const auto [all_first, all_end] = of_file(row, row + result_.height);
    if (first_column >= end_column || all_first >= all_end) {
      if (!is_first) return {};
      return failure(part.path, "the first file has no sample inside of --crop; name another one first");
    }
    const auto [first_row, end_row] = of_file(row + first, row + first + count);
    if (first_row >= end_row) return {};
    const auto whole_number = [](std::int64_t n) { return static_cast<int>(n); };
    const Window whole{whole_number(column), whole_number(row), result_.width, result_.height};
    const Window inside{whole_number(first_column), whole_number(first_row),
                        whole_number(end_column - first_column), whole_number(end_row - first_row)};
    ElevationPart read;
    Error error = read_elevation_part(settings_, part.path, part.grid, whole, inside, read);
    if (!error.ok()) return error;
    for (std::string& warning : read.warnings) {
      std::vector<std::string>& all = result_.warnings;
      if (std::find(all.begin(), all.end(), warning) == all.end()) all.push_back(std::move(warning));
    }
    // The first file may begin south of these rows.
    if (is_first || result_.source.empty()) {
      result_.source = read.source;
      result_.spacing_x_m = read.spacing_x_m;
      result_.spacing_z_m = read.spacing_z_m;
      if (error = check_spacing(); !error.ok()) return error;
    }
    unit_m_ = !unit_known_ || unit_m_ == read.unit_m ? read.unit_m : 0;
    unit_known_ = true;
    for (int j = 0; j < inside.height; ++j) {
      const std::byte* from = read.heights.data() + static_cast<std::size_t>(j) *
                                                        static_cast<std::size_t>(inside.width) *
                                                        sizeof(float);
      std::size_t k = result_.at(inside.column - whole.column, inside.row - whole.row - first + j);
      for (int i = 0; i < inside.width; ++i, ++k, from += sizeof(float)) {
        float height = 0;
        std::memcpy(&height, from, sizeof height);
        if (!std::isnan(height) && std::isnan(out[k])) out[k] = height;
      }
    }
    return {};
  }

  Error check_spacing() const {
    for (const double spacing : {result_.spacing_x_m, result_.spacing_z_m}) {
      if (!(spacing >= kMinSpacingM && spacing <= kMaxSpacingM)) {
        return failure(settings_.path,
                       "pixel size: " + std::to_string(spacing) + " m is not in 0.0001 to 1000000 m");
      }
    }
    return {};
  }

  const ReadElevation& settings_;
  SizeLimits limits_;
  Elevation& result_;
  std::vector<Part> parts_;
  std::uint64_t bytes_ = 0;            // of all that the files are made of
  std::int64_t west_ = 0, north_ = 0;  // the window's first sample, from the first file's
  double unit_m_ = 0;                  // of all that was read
  bool unit_known_ = false;
};

}  // namespace

Error ReadElevation::run(Elevation& result) const {
  result = {};
  return Reader(*this, SizeLimits(), result).run();
}

struct ElevationRows::State {
  explicit State(const ReadElevation& settings) : reader(settings, {kMostSide, kMostSamples}, facts) {}
  Elevation facts;
  Reader reader;
};

ElevationRows::ElevationRows() = default;
ElevationRows::~ElevationRows() = default;

Error ElevationRows::open(const ReadElevation& settings) {
  state_ = std::make_unique<State>(settings);
  if (Error error = state_->reader.open(); !error.ok()) return error;
  std::vector<float> row(static_cast<std::size_t>(width()) * 2);
  Error error = read(0, 2, row);
  state_->facts.warnings.clear();  // of two rows, as if they were all
  return error;
}

Error ElevationRows::read(int first, int count, std::span<float> out) {
  return state_->reader.read_rows(first, count, out);
}

int ElevationRows::width() const {
  return state_->facts.width;
}

int ElevationRows::height() const {
  return state_->facts.height;
}

int ElevationRows::rows_at_once() const {
  constexpr std::int64_t kSamplesAtOnce = 4 << 20;
  return static_cast<int>(std::clamp<std::int64_t>(kSamplesAtOnce / width(), 1, height()));
}

const Elevation& ElevationRows::facts() const {
  return state_->facts;
}

std::uint64_t ElevationRows::file_bytes() const {
  return state_->reader.file_bytes();
}

double ElevationRows::unit_m() const {
  return state_->reader.unit_m();
}

SamplePlace ElevationRows::place() const {
  return state_->reader.sample_place();
}

std::vector<std::string> ReadElevation::files() const {
  std::vector<std::string> all = more, found;
  if (!path.empty()) all.insert(all.begin(), path);
  found = all;
  for (const std::string& name : all) {
    ElevationGrid grid;
    std::uint64_t bytes = 0;
    int file = -1;
    if (!app::open_regular_file(name, file, bytes).ok()) continue;
    close(file);
    if (describe_elevation(*this, name, grid).ok())
      found.insert(found.end(), grid.files.begin(), grid.files.end());
  }
  return found;
}

}  // namespace karst::bake
