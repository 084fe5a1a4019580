// SPDX-License-Identifier: MIT
// Reading elevation. Pixels come through OpenImageIO, whose readers are picked by the file's first bytes, so
// that a file is never handed to a reader for a kind of image that elevation does not come in. Pixels are
// read a band of rows at a time and memory grows with what was read: a short file that claims to be large
// fails before it costs anything.
#include "bake/elevation/elevation.h"

#include "bake/base/image_threads.h"

#include "bake/elevation/envi.h"
#include "bake/elevation/exr_header.h"
#include "bake/elevation/geo_scale.h"
#include "bake/elevation/quiet_stderr.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

namespace karst::bake {
namespace {

constexpr int kBandRows = 64;                         // rows read at a time; 8 MiB of float at the widest
constexpr std::uintmax_t kLargeTileBytes = 16 << 20;  // from here on a tile needs bytes in the file
constexpr std::uintmax_t kMostUnpacked = 64;          // bytes of a large tile a byte of file
constexpr int kMaxTileSide = 4'096;                   // samples; a tile is read whole
constexpr std::size_t kMaxHeaderBytes = 1 << 16;      // of an ENVI header; real ones have a few hundred
constexpr double kMostRelief = 30'000;                // metres; of Mars, the most of all that is mapped
constexpr double kUsualVoids[] = {999, 9'999, 99'999, 32'767, 32'768, 65'535};  // with either sign
constexpr double kSrtmVoid = -32'768;  // SRTM marks voids so, and seldom says it in a tag

Error failure(const std::string& path, const std::string& what) {
  return path + ": " + what;
}

// What a file says about its samples, whichever kind it is.
struct Format {
  int width = 0, height = 0;
  std::string kind;  // "GeoTIFF int16"
  bool is_8bit = false;
  bool is_signed_16bit = false;
  bool is_float = false;
  bool is_unsigned = false;  // and whole
  double metres_per_unit = 1;
  std::optional<double> spacing_x_m, spacing_z_m;
  std::optional<double> nodata;
};

Error check_size(const std::string& path, std::int64_t width, std::int64_t height) {
  const std::string size = std::to_string(width) + " x " + std::to_string(height);
  if (width < 2 || height < 2) return failure(path, "size: " + size + " samples; each side needs 2 or more");
  if (width > kMaxElevationSide || height > kMaxElevationSide || width * height > kMaxElevationSamples) {
    return failure(path, "size: " + size + " samples; the most is " + std::to_string(kMaxElevationSide) +
                             " a side and " + std::to_string(kMaxElevationSamples) + " together");
  }
  return {};
}

// Turns samples of a file into heights and voids, and counts and checks them.
class SampleSink {
 public:
  // All outlive the sink.
  SampleSink(const ReadElevation& settings, const Format& format, Elevation& result)
      : settings_(settings), format_(format), result_(result) {}

  Error start() {
    if (format_.nodata) nodata_.push_back(*format_.nodata);
    if (format_.is_signed_16bit) nodata_.push_back(kSrtmVoid);
    nodata_.insert(nodata_.end(), settings_.nodata.begin(), settings_.nodata.end());
    // A float file holds its nodata value rounded to float.
    if (format_.is_float) {
      for (double& v : nodata_) v = double{static_cast<float>(v)};
    }
    const int* crop = settings_.crop;
    const bool whole = crop[2] == 0 && crop[3] == 0;
    first_column_ = whole ? 0 : crop[0];
    first_row_ = whole ? 0 : crop[1];
    result_ = {};
    result_.width = whole ? format_.width : crop[2];
    result_.height = whole ? format_.height : crop[3];
    if (first_column_ < 0 || first_row_ < 0 || result_.width < 2 || result_.height < 2 ||
        first_column_ > format_.width - result_.width || first_row_ > format_.height - result_.height) {
      return failure(settings_.path, "--crop: not inside the image of " + std::to_string(format_.width) +
                                         " x " + std::to_string(format_.height) +
                                         " samples, or less than 2 x 2");
    }
    return {};
  }

  int end_row() const { return first_row_ + result_.height; }

  // row: format.width samples. Rows come in order from 0.
  template <class T>
  Error take_row(int row, const T* samples) {
    if (row < first_row_ || row >= end_row()) return {};
    for (int i = first_column_; i < first_column_ + result_.width; ++i) {
      const double raw = static_cast<double>(samples[i]);
      if (!std::isfinite(raw) || std::find(nodata_.begin(), nodata_.end(), raw) != nodata_.end()) {
        push(0, false);
        continue;
      }
      const double height_m = raw * format_.metres_per_unit * settings_.z_scale.value_or(1);
      if (!(std::abs(height_m) <= kMaxElevationM)) {
        return failure(settings_.path, "height " + std::to_string(raw) + " at column " + std::to_string(i) +
                                           ", row " + std::to_string(row) +
                                           " is not within 100000 m; is it a void (--nodata V)?");
      }
      note_extreme(raw);
      push(static_cast<float>(height_m), true);
    }
    return {};
  }

  Error finish() {
    if (result_.voids == result_.samples()) {
      return failure(settings_.path, "no sample is valid: all are void");
    }
    result_.source = format_.kind;
    // The finer end of 16-bit height maps: counts of a range that only their author knows.
    if (format_.is_unsigned && !settings_.z_scale && (high_ - low_) * format_.metres_per_unit > kMostRelief) {
      return failure(settings_.path, "heights from " + whole(low_) + " to " + whole(high_) +
                                         " would be more relief than any planet has; give --z-scale S, the "
                                         "metres of a count (1: they are metres)");
    }
    for (const bool at_low : {true, false}) warn_of_void(at_low);
    return set_spacing();
  }

 private:
  static std::string whole(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", value);
    return text;
  }

  // Keeps the two least and the two greatest of the values that differ.
  void note_extreme(double raw) {
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

  // An extreme that is far from all other heights, and is a value that voids are often marked with.
  void warn_of_void(bool at_low) {
    const double value = at_low ? low_ : high_;
    if (std::find(std::begin(kUsualVoids), std::end(kUsualVoids), std::abs(value)) == std::end(kUsualVoids))
      return;
    const double gap = at_low ? next_low_ - low_ : high_ - next_high_;
    const double rest = at_low ? high_ - next_low_ : next_high_ - low_;
    if (!std::isfinite(gap) || !(gap > rest)) return;
    result_.warnings.push_back(
        failure(settings_.path, "heights of " + whole(value) +
                                    " are far from all others and may mark voids: --nodata " + whole(value))
            .text());
  }

  void push(float height_m, bool valid) {
    result_.heights_m.push_back(height_m);
    result_.valid.push_back(valid ? 1 : 0);
    result_.voids += valid ? 0 : 1;
  }

  Error set_spacing() {
    const double given = settings_.pixel_size_m;
    if (given <= 0 && (!format_.spacing_x_m || !format_.spacing_z_m)) {
      return failure(settings_.path,
                     "pixel size: the file does not say how large a sample is; give --pixel-size M");
    }
    result_.spacing_x_m = given > 0 ? given : *format_.spacing_x_m;
    result_.spacing_z_m = given > 0 ? given : *format_.spacing_z_m;
    for (const double spacing : {result_.spacing_x_m, result_.spacing_z_m}) {
      if (!(spacing >= kMinSpacingM && spacing <= kMaxSpacingM)) {
        return failure(settings_.path,
                       "pixel size: " + std::to_string(spacing) + " m is not in 0.0001 to 1000000 m");
      }
    }
    return {};
  }

  const ReadElevation& settings_;
  const Format& format_;
  std::vector<double> nodata_;
  int first_column_ = 0, first_row_ = 0;
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double low_ = kInfinity, next_low_ = kInfinity, high_ = -kInfinity, next_high_ = -kInfinity;
  Elevation& result_;
};

Error check_8bit(const ReadElevation& settings, const Format& format) {
  if (format.is_8bit && !settings.allow_8bit) {
    return failure(settings.path,
                   "sample type: 8 bits give steps, not slopes; --allow-8bit takes it all the same");
  }
  return {};
}

using InputFile = std::unique_ptr<OIIO::ImageInput>;

Error reading_failure(const std::string& path, OIIO::ImageInput& input) {
  std::string why = input.geterror();
  std::replace(why.begin(), why.end(), '\n', ' ');
  return failure(path, "unreadable image: " + (why.empty() ? "truncated or damaged" : why));
}

// Rows [row, last) into band. Scanlines are read one by one: OpenImageIO 2.4's read_scanlines returns success
// and stale memory where a TIFF is truncated (tests/bake, RefusesEveryTruncation).
template <class T>
bool read_band(OIIO::ImageInput& input, OIIO::TypeDesc type, int row, int last, std::vector<T>& band) {
  const OIIO::ImageSpec& spec = input.spec();
  if (spec.tile_width > 0) {
    return input.read_tiles(0, 0, spec.x, spec.x + spec.width, spec.y + row, spec.y + last, spec.z,
                            spec.z + 1, 0, 1, type, band.data());
  }
  const auto width = static_cast<std::size_t>(spec.width);
  for (int k = row; k < last; ++k) {
    if (!input.read_scanline(spec.y + k, spec.z, type,
                             band.data() + static_cast<std::size_t>(k - row) * width)) {
      return false;
    }
  }
  return true;
}

template <class T>
Error read_bands(const std::string& path, OIIO::ImageInput& input, OIIO::TypeDesc type, SampleSink& sink) {
  const OIIO::ImageSpec& spec = input.spec();
  const int rows = spec.tile_width > 0 ? spec.tile_height : kBandRows;
  const auto width = static_cast<std::size_t>(spec.width);
  std::vector<T> band(width * static_cast<std::size_t>(rows));
  const int end = sink.end_row();
  for (int row = 0; row < end; row += rows) {
    const int last = std::min(row + rows, spec.height);
    if (!read_band(input, type, row, last, band)) return reading_failure(path, input);
    for (int k = row; k < last; ++k) {
      const T* samples = band.data() + static_cast<std::size_t>(k - row) * width;
      if (Error error = sink.take_row(k, samples); !error.ok()) return error;
    }
  }
  return {};
}

Error read_pixels(const ReadElevation& settings, OIIO::ImageInput& input, SampleSink& sink) {
  const OIIO::TypeDesc type = input.spec().format;
  switch (type.basetype) {
    // Native types: OpenImageIO would scale integers to 0..1 when asked for float.
    case OIIO::TypeDesc::UINT8:
      return read_bands<std::uint8_t>(settings.path, input, type, sink);
    case OIIO::TypeDesc::INT8:
      return read_bands<std::int8_t>(settings.path, input, type, sink);
    case OIIO::TypeDesc::UINT16:
      return read_bands<std::uint16_t>(settings.path, input, type, sink);
    case OIIO::TypeDesc::INT16:
      return read_bands<std::int16_t>(settings.path, input, type, sink);
    case OIIO::TypeDesc::DOUBLE:
      // OpenImageIO 2.4 says that it read them and leaves the buffer as it was: a plain at height 0.
      return failure(settings.path,
                     "sample type: double is not read; gdal_translate -ot Float32 makes float");
    case OIIO::TypeDesc::HALF:
    case OIIO::TypeDesc::FLOAT:
      return read_bands<float>(settings.path, input, OIIO::TypeDesc::FLOAT, sink);
    default:
      return failure(settings.path, std::string("sample type: ") + type.c_str() + " is not 16-bit or float");
  }
}

// What an image must be before any of its pixels is looked at.
Error check_spec(const std::string& path, const OIIO::ImageSpec& spec) {
  if (Error error = check_size(path, spec.width, spec.height); !error.ok()) return error;
  const int bits = spec.get_int_attribute("oiio:BitsPerSample", 0);
  if (bits > 8 && bits != 8 * static_cast<int>(spec.format.size())) {
    // They would come stretched over the range of the type.
    return failure(path, "sample type: " + std::to_string(bits) +
                             " bits are not read; gdal_translate -co NBITS=16 makes whole ones");
  }
  if (spec.depth > 1) return failure(path, "depth: a volume, not an image");
  if (spec.nchannels != 1) {
    return failure(path, "channels: " + std::to_string(spec.nchannels) + "; elevation has one");
  }
  if (spec.tile_width < 0 || spec.tile_height < 0 || spec.tile_width > kMaxTileSide ||
      spec.tile_height > kMaxTileSide) {
    return failure(path, "tiles: larger than " + std::to_string(kMaxTileSide) + " a side");
  }
  return {};
}

Error read_image(const ReadElevation& settings, const char* reader, Elevation& result) {
  if (std::string_view(reader) == "openexr") {
    if (Error error = check_exr_header(settings.path, kMaxTileSide); !error.ok()) return error;
  }
  const QuietStderr quiet;
  keep_image_threads_away();
  InputFile input = OIIO::ImageInput::create(reader);
  if (input == nullptr) {
    return failure(settings.path, std::string("OpenImageIO has no reader for ") + reader);
  }
  OIIO::ImageSpec spec;
  if (!input->open(settings.path, spec)) return reading_failure(settings.path, *input);
  if (Error error = check_spec(settings.path, spec); !error.ok()) return error;
  std::error_code unknown;
  const std::uintmax_t bytes = std::filesystem::file_size(settings.path, unknown);
  const std::uintmax_t block = spec.tile_width > 0 ? spec.tile_bytes() : spec.scanline_bytes();
  if (block > kLargeTileBytes && (unknown || block / kMostUnpacked > bytes)) {
    return failure(settings.path, "tiles: one of " + std::to_string(block) + " bytes in a file of " +
                                      std::to_string(bytes) + "; gdal_translate makes smaller ones");
  }
  Format format;
  format.width = spec.width;
  format.height = spec.height;
  format.is_8bit = spec.format.size() == 1;
  format.is_signed_16bit = spec.format.basetype == OIIO::TypeDesc::INT16;
  format.is_float = spec.format.is_floating_point() && spec.format.basetype != OIIO::TypeDesc::DOUBLE;
  format.is_unsigned = spec.format.basetype == OIIO::TypeDesc::UINT16;
  format.kind =
      std::string(std::string_view(reader) == "openexr" ? "EXR" : reader) + " " + spec.format.c_str();
  if (Error error = check_8bit(settings, format); !error.ok()) return error;
  if (std::string_view(reader) == "tiff") {
    GeoTiffTags tags;
    const bool whole = settings.crop[3] == 0;
    const std::int64_t twice_middle =
        whole ? spec.height : 2 * std::int64_t{settings.crop[1]} + settings.crop[3];
    const GeoTiffNeeds needs{twice_middle, settings.pixel_size_m <= 0, !settings.z_scale};
    Error error = read_geotiff_tags(settings.path, needs, tags);
    if (!error.ok()) return error;
    format.spacing_x_m = tags.spacing_x_m;
    format.spacing_z_m = tags.spacing_z_m;
    format.nodata = tags.nodata;
    format.metres_per_unit = tags.metres_per_unit;
    format.kind = std::string(tags.spacing_x_m ? "GeoTIFF " : "TIFF ") + spec.format.c_str() +
                  (tags.geographic ? ", geographic" : "");
  }
  SampleSink sink(settings, format, result);
  if (Error error = sink.start(); !error.ok()) return error;
  if (Error error = read_pixels(settings, *input, sink); !error.ok()) return error;
  return sink.finish();
}

// One sample of an ENVI file: its bytes in the file's order.
template <class T>
T decode(const std::byte* bytes, bool big_endian) {
  std::byte native[sizeof(T)];
  const bool swap = big_endian != (std::endian::native == std::endian::big);
  for (std::size_t k = 0; k < sizeof(T); ++k) native[k] = bytes[swap ? sizeof(T) - 1 - k : k];
  T value;
  std::memcpy(&value, native, sizeof(T));
  return value;
}

template <class T>
Error read_envi_rows(const std::string& path, std::istream& file, const EnviHeader& header,
                     SampleSink& sink) {
  const auto width = static_cast<std::size_t>(header.width);
  std::vector<std::byte> bytes(width * sizeof(T));
  std::vector<T> row(width);
  file.seekg(static_cast<std::streamoff>(header.offset));
  for (int j = 0; j < sink.end_row(); ++j) {
    if (!file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()))) {
      return failure(path, "truncated in row " + std::to_string(j));
    }
    for (std::size_t i = 0; i < width; ++i)
      row[i] = decode<T>(bytes.data() + i * sizeof(T), header.big_endian);
    if (Error error = sink.take_row(j, row.data()); !error.ok()) return error;
  }
  return {};
}

Error read_envi_header(const std::string& header_path, bool need_scale, EnviHeader& header) {
  std::ifstream text_file(header_path, std::ios::binary);
  std::string text(kMaxHeaderBytes, '\0');
  text_file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (text_file.gcount() == static_cast<std::streamsize>(kMaxHeaderBytes)) {
    return failure(header_path,
                   "longer than " + std::to_string(kMaxHeaderBytes) + " bytes: not an ENVI header");
  }
  text.resize(static_cast<std::size_t>(text_file.gcount()));
  if (Error error = parse_envi_header(text, header_path, need_scale, header); !error.ok()) return error;
  return check_size(header_path, header.width, header.height);
}

Error read_envi(const ReadElevation& settings, std::istream& file, const std::string& header_path,
                Elevation& result) {
  EnviHeader header;
  Error error = read_envi_header(header_path, settings.pixel_size_m <= 0, header);
  if (!error.ok()) return error;
  Format format;
  format.width = header.width;
  format.height = header.height;
  format.is_8bit = header.type == EnviType::u8;
  format.is_signed_16bit = header.type == EnviType::i16;
  format.is_float = header.type == EnviType::f32;
  format.is_unsigned = header.type == EnviType::u16;
  format.spacing_x_m = header.spacing_x_m;
  format.spacing_z_m = header.spacing_z_m;
  format.nodata = header.nodata;
  if (error = check_8bit(settings, format); !error.ok()) return error;
  SampleSink sink(settings, format, result);
  if (error = sink.start(); !error.ok()) return error;
  switch (header.type) {
    case EnviType::u8:
      format.kind = "ENVI uint8";
      error = read_envi_rows<std::uint8_t>(settings.path, file, header, sink);
      break;
    case EnviType::i16:
      format.kind = "ENVI int16";
      error = read_envi_rows<std::int16_t>(settings.path, file, header, sink);
      break;
    case EnviType::u16:
      format.kind = "ENVI uint16";
      error = read_envi_rows<std::uint16_t>(settings.path, file, header, sink);
      break;
    case EnviType::f32:
      format.kind = "ENVI float";
      error = read_envi_rows<float>(settings.path, file, header, sink);
      break;
  }
  if (!error.ok()) return error;
  if (header.geographic) format.kind += ", geographic";
  return sink.finish();
}

// The OpenImageIO reader for a file, by its first bytes, or null.
const char* reader_for(std::string_view first_bytes) {
  using namespace std::string_view_literals;
  for (const std::string_view magic : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv}) {
    if (first_bytes.starts_with(magic)) return "tiff";
  }
  if (first_bytes.starts_with("\x89PNG\r\n\x1a\n"sv)) return "png";
  if (first_bytes.starts_with("\x76\x2f\x31\x01"sv)) return "openexr";
  return nullptr;
}

}  // namespace

Error ReadElevation::run(Elevation& result) const {
  std::ifstream file(path, std::ios::binary);
  if (!file) return failure(path, "cannot be opened");
  char first_bytes[8] = {};
  file.read(first_bytes, sizeof first_bytes);
  if (file.bad()) return failure(path, "cannot be read");
  const auto count = static_cast<std::size_t>(file.gcount());
  file.clear();
  if (const char* reader = reader_for({first_bytes, count})) {
    file.close();
    return read_image(*this, reader, result);
  }
  const std::string header = find_envi_header(path);
  if (header.empty())
    return failure(path, "not a TIFF, PNG, EXR or ENVI file (raw samples with a .hdr beside them)");
  return read_envi(*this, file, header, result);
}

}  // namespace karst::bake
