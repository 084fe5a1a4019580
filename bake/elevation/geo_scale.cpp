// SPDX-License-Identifier: MIT
// GeoTIFF tags (OGC 19-008r4, sections 7 and annex B; tag numbers below) through libtiff, and GDAL's nodata
// tag (GDAL documentation, "GTiff -- GeoTIFF File Format": TIFFTAG_GDAL_NODATA).
#include "bake/elevation/geo_scale.h"

#include <tiffio.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <span>
#include <string_view>

namespace karst::bake {
namespace {

constexpr std::uint32_t kModelPixelScaleTag = 33550;
constexpr std::uint32_t kModelTiepointTag = 33922;
constexpr std::uint32_t kModelTransformationTag = 34264;
constexpr std::uint32_t kGeoKeyDirectoryTag = 34735;
constexpr std::uint32_t kGeoDoubleParamsTag = 34736;
constexpr std::uint32_t kGdalMetadataTag = 42112;  // XML; the scale and offset of samples are items of it
constexpr std::uint32_t kGdalNodataTag = 42113;

constexpr int kModelTypeKey = 1024;  // 1 projected, 2 geographic, 3 geocentric
constexpr int kGeogAngularUnitsKey = 2054;
constexpr int kProjectedTypeKey = 3072;
constexpr int kWebMercator = 3857;  // EPSG: metres of the equator, whatever the latitude
constexpr int kProjLinearUnitsKey = 3076;
constexpr int kProjLinearUnitSizeKey = 3077;
constexpr int kVerticalUnitsKey = 4099;

// EPSG unit codes.
constexpr int kMetre = 9001, kFoot = 9002, kUsSurveyFoot = 9003, kDegree = 9102, kDegreeOfEpsg = 9122,
              kUserDefined = 32767;

// What libtiff may take for one tag or strip list: a header that asks for more is hostile.
constexpr tmsize_t kMaxTagBytes = 64 << 20;

// libtiff warns of tags that lie beyond the end of the file, and goes on without them: a lost nodata tag
// would turn voids into mountains. Sets the bool that it is given.
int note_message(TIFF*, void* truncated, const char*, const char* format, va_list) {
  if (std::string_view(format).starts_with("IO error")) *static_cast<bool*>(truncated) = true;
  return 1;  // handled: nothing is printed
}

struct CloseTiff {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using TiffFile = std::unique_ptr<TIFF, CloseTiff>;

// truncated: set when libtiff misses bytes; outlives the file.
TiffFile open_tiff(const std::string& path, bool& truncated) {
  TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
  if (options == nullptr) return {};
  TIFFOpenOptionsSetMaxSingleMemAlloc(options, kMaxTagBytes);
  TIFFOpenOptionsSetErrorHandlerExtR(options, note_message, &truncated);
  TIFFOpenOptionsSetWarningHandlerExtR(options, note_message, &truncated);
  TiffFile tiff(TIFFOpenExt(path.c_str(), "rm", options));
  TIFFOpenOptionsFree(options);
  return tiff;
}

// The values of a tag that libtiff does not know by name, empty where it is absent or of another type.
template <class T>
std::span<const T> tag_values(TIFF* tiff, std::uint32_t tag, TIFFDataType type) {
  const TIFFField* field = TIFFFindField(tiff, tag, TIFF_ANY);
  if (field == nullptr || TIFFFieldDataType(field) != type || TIFFFieldPassCount(field) == 0) return {};
  std::uint32_t count32 = 0;
  std::uint16_t count16 = 0;
  const void* values = nullptr;
  const bool wide = TIFFFieldReadCount(field) == TIFF_VARIABLE2;
  const int found =
      wide ? TIFFGetField(tiff, tag, &count32, &values) : TIFFGetField(tiff, tag, &count16, &values);
  if (found != 1 || values == nullptr) return {};
  return {static_cast<const T*>(values), wide ? std::size_t{count32} : std::size_t{count16}};
}

// The GeoKey directory: four shorts a key, the first four are its header (19-008r4, 7.1.2).
class GeoKeys {
 public:
  explicit GeoKeys(TIFF* tiff)
      : directory_(tag_values<std::uint16_t>(tiff, kGeoKeyDirectoryTag, TIFF_SHORT)),
        doubles_(tag_values<double>(tiff, kGeoDoubleParamsTag, TIFF_DOUBLE)) {}

  std::optional<int> number(int key) const {
    const auto entry = find(key);
    if (entry.empty() || entry[1] != 0) return {};
    return entry[3];
  }
  std::optional<double> real(int key) const {
    const auto entry = find(key);
    if (entry.empty() || entry[1] != kGeoDoubleParamsTag || entry[3] >= doubles_.size()) return {};
    return doubles_[entry[3]];
  }

 private:
  std::span<const std::uint16_t> find(int key) const {
    for (std::size_t k = 4; k + 4 <= directory_.size(); k += 4) {
      if (directory_[k] == key) return directory_.subspan(k, 4);
    }
    return {};
  }

  std::span<const std::uint16_t> directory_;
  std::span<const double> doubles_;
};

Error failure(const std::string& path, const std::string& what) {
  return path + ": " + what;
}

Error metres_of_unit(const std::string& path, const char* field, int unit, double& metres) {
  switch (unit) {
    case kMetre:
      metres = 1.0;
      return {};
    case kFoot:
      metres = 0.3048;
      return {};
    case kUsSurveyFoot:
      metres = 1200.0 / 3937.0;
      return {};
    default:
      return failure(
          path, std::string(field) + ": unit " + std::to_string(unit) + " is not known; use --pixel-size M");
  }
}

// Model units of a column and a row, and the model y of row 0 where it is known.
struct ModelScale {
  double x = 0, y = 0;
  std::optional<double> north;
};

// result stays empty where the file says nothing.
Error model_scale(TIFF* tiff, const std::string& path, std::optional<ModelScale>& result) {
  const auto scale = tag_values<double>(tiff, kModelPixelScaleTag, TIFF_DOUBLE);
  if (!scale.empty()) {
    if (scale.size() < 2) return failure(path, "ModelPixelScaleTag: fewer than two values");
    result = ModelScale{scale[0], scale[1], {}};
    const auto tie = tag_values<double>(tiff, kModelTiepointTag, TIFF_DOUBLE);
    if (tie.size() >= 6) result->north = tie[4] + tie[1] * scale[1];
    return {};
  }
  const auto matrix = tag_values<double>(tiff, kModelTransformationTag, TIFF_DOUBLE);
  if (matrix.empty()) return {};
  if (matrix.size() != 16) return failure(path, "ModelTransformationTag: not 16 values");
  if (matrix[1] != 0 || matrix[4] != 0) return failure(path, "ModelTransformationTag: the image is rotated");
  result = ModelScale{matrix[0], -matrix[5], matrix[7]};
  return {};
}

Error apply_scale(const ModelScale& scale, const GeoKeys& keys, std::int64_t twice_middle,
                  const std::string& path, GeoTiffTags& tags) {
  const int model = keys.number(kModelTypeKey).value_or(0);
  tags.geographic = model == 2;
  if (tags.geographic) {
    if (const int unit = keys.number(kGeogAngularUnitsKey).value_or(kDegree);
        unit != kDegree && unit != kDegreeOfEpsg) {
      return failure(path, "GeogAngularUnitsGeoKey: unit " + std::to_string(unit) +
                               " is not degrees; use --pixel-size M");
    }
    if (!scale.north)
      return failure(path, "ModelTiepointTag: absent, so the latitude is not known; use --pixel-size M");
    const double latitude = *scale.north - 0.5 * scale.y * static_cast<double>(twice_middle);
    if (!(std::abs(latitude) <= 89))
      return failure(path, "ModelTiepointTag: the mean latitude is not within 89 degrees");
    const DegreeM degree = metres_per_degree(latitude);
    tags.spacing_x_m = scale.x * degree.x;
    tags.spacing_z_m = scale.y * degree.y;
    return {};
  }
  if (model == 3) return failure(path, "GTModelTypeGeoKey: geocentric coordinates; use --pixel-size M");
  if (keys.number(kProjectedTypeKey) == kWebMercator) {
    return failure(
        path,
        "ProjectedCSTypeGeoKey: Web Mercator stretches the ground with latitude; use --pixel-size M "
        "(its metres times the cosine of the latitude) or gdalwarp -t_srs to UTM");
  }
  const int unit = keys.number(kProjLinearUnitsKey).value_or(kMetre);
  double metres = keys.real(kProjLinearUnitSizeKey).value_or(0);
  if (unit != kUserDefined) {
    if (Error error = metres_of_unit(path, "ProjLinearUnitsGeoKey", unit, metres); !error.ok()) return error;
  }
  tags.spacing_x_m = scale.x * metres;
  tags.spacing_z_m = scale.y * metres;
  return {};
}

Error read_nodata(TIFF* tiff, const std::string& path, std::optional<double>& nodata) {
  const auto text = tag_values<char>(tiff, kGdalNodataTag, TIFF_ASCII);
  if (text.empty()) return {};
  std::string_view digits(text.data(), text.size());
  const std::size_t first = digits.find_first_not_of(" +");
  digits.remove_prefix(first == std::string_view::npos ? digits.size() : first);
  digits = digits.substr(0, digits.find_first_of(std::string_view(" \0\n", 3)));
  if (digits.empty()) return {};
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size())
    return failure(path, "GDAL_NODATA: not a number");
  nodata = value;
  return {};
}

// What would be read wrongly without a word.
Error check_samples(TIFF* tiff, const std::string& path) {
  const auto text = tag_values<char>(tiff, kGdalMetadataTag, TIFF_ASCII);
  const std::string_view metadata(text.data(), text.size());
  for (const std::string_view role : {"role=\"scale\"", "role=\"offset\""}) {
    if (metadata.find(role) != std::string_view::npos) {
      return failure(path,
                     "GDAL_METADATA: scaled samples are not read; gdal_translate -unscale -ot Float32 "
                     "makes heights of them");
    }
  }
  while (TIFFReadDirectory(tiff) != 0) {
    std::uint32_t kind = 0;
    if (TIFFGetField(tiff, TIFFTAG_SUBFILETYPE, &kind) == 1 && (kind & FILETYPE_MASK) != 0) {
      return failure(path,
                     "a mask inside the file is not read; gdal_calc.py or gdalwarp -dstnodata -9999 puts "
                     "its voids into the samples");
    }
  }
  return {};
}

}  // namespace

DegreeM metres_per_degree(double latitude_deg) {
  constexpr double kEquatorialRadiusM = 6'378'137.0;
  constexpr double kFlattening = 1 / 298.257223563;
  constexpr double kEccentricity2 = kFlattening * (2 - kFlattening);
  constexpr double kRadians = std::numbers::pi / 180;
  const double s = std::sin(latitude_deg * kRadians);
  const double w = std::sqrt(1 - kEccentricity2 * s * s);
  const double prime_vertical_m = kEquatorialRadiusM / w;
  const double meridian_m = kEquatorialRadiusM * (1 - kEccentricity2) / (w * w * w);
  return {prime_vertical_m * std::cos(latitude_deg * kRadians) * kRadians, meridian_m * kRadians};
}

Error read_geotiff_tags(const std::string& path, std::int64_t twice_middle, bool need_scale,
                        GeoTiffTags& tags) {
  tags = {};
  bool truncated = false;
  const TiffFile tiff = open_tiff(path, truncated);
  if (truncated) return failure(path, "truncated: a tag lies beyond the end of the file");
  if (tiff == nullptr) return failure(path, "not a readable TIFF file");
  const GeoKeys keys(tiff.get());
  if (Error error = read_nodata(tiff.get(), path, tags.nodata); !error.ok()) return error;
  if (const auto unit = keys.number(kVerticalUnitsKey); unit && *unit != kUserDefined) {
    Error error = metres_of_unit(path, "VerticalUnitsGeoKey", *unit, tags.metres_per_unit);
    if (!error.ok()) return error;
  }
  tags.geographic = keys.number(kModelTypeKey) == 2;
  const auto scale_of_file = [&]() -> Error {
    if (!need_scale) return {};
    std::optional<ModelScale> scale;
    if (Error error = model_scale(tiff.get(), path, scale); !error.ok()) return error;
    return scale ? apply_scale(*scale, keys, twice_middle, path, tags) : Error();
  };
  if (Error error = scale_of_file(); !error.ok()) return error;
  return check_samples(tiff.get(), path);  // leaves the first directory
}

}  // namespace karst::bake
