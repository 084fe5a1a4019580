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
constexpr int kVerticalTypeKey = 4096;
constexpr int kVerticalUnitsKey = 4099;

// EPSG unit codes.
constexpr int kMetre = 9001, kFoot = 9002, kUsSurveyFoot = 9003, kDegree = 9102, kDegreeOfEpsg = 9122,
              kUserDefined = 32767;

// Units that files leave to the code of their system: a file may name it and no unit. EPSG dataset 10.
struct UnitOfCodes {
  int first, last;
  int unit;
};
constexpr UnitOfCodes kProjectedUnits[] = {
    {2056, 2056, kMetre},   {2154, 2154, kMetre},   {3031, 3031, kMetre},
    {3035, 3035, kMetre},   {3413, 3413, kMetre},   {3976, 3976, kMetre},
    {3995, 3996, kMetre},   {5070, 5070, kMetre},   {23028, 23038, kMetre},  // UTM on ED50
    {25828, 25838, kMetre},                                                  // ETRS89
    {26701, 26722, kMetre}, {26901, 26923, kMetre},                          // NAD27, NAD83
    {27700, 27700, kMetre}, {28992, 28992, kMetre}, {32201, 32260, kMetre},
    {32301, 32360, kMetre}, {32601, 32660, kMetre}, {32701, 32760, kMetre},  // WGS 84
};
constexpr UnitOfCodes kVerticalUnits[] = {
    {3855, 3855, kMetre},  // EGM2008
    {5001, 5033, kMetre},  // ellipsoids, as GeoTIFF 1.0 numbers them
    {5621, 5621, kMetre}, {5701, 5701, kMetre}, {5702, 5702, kUsSurveyFoot},  // EVRF2007, ODN, NGVD29
    {5703, 5703, kMetre}, {5709, 5711, kMetre}, {5714, 5714, kMetre},
    {5720, 5720, kMetre}, {5728, 5728, kMetre}, {5773, 5773, kMetre},
    {5783, 5783, kMetre}, {5798, 5798, kMetre}, {6360, 6360, kUsSurveyFoot},  // 6360: NAVD88
    {7837, 7837, kMetre}, {8228, 8228, kFoot},
};

std::optional<int> unit_of_code(std::span<const UnitOfCodes> table, int code) {
  for (const UnitOfCodes& codes : table) {
    if (code >= codes.first && code <= codes.last) return codes.unit;
  }
  return {};
}

// Without a system, numbers like these are degrees, whatever they may be meant for.
constexpr double kSurelyDegrees = 0.02;  // a column
constexpr double kMostLongitude = 360, kMostLatitude = 90;

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
  std::optional<double> west, north;  // of column 0, row 0
};

// Rows go from north to south here; a size given on the command line does not turn them.
Error check_orientation(const std::string& path, const ModelScale& scale) {
  if (scale.x >= 0 && scale.y >= 0) return {};
  return failure(path, std::string("pixel size: below 0, ") +
                           (scale.y < 0 ? "rows run from south to north" : "columns run from east to west") +
                           "; gdalwarp IN OUT turns the image");
}

// result stays empty where the file says nothing.
Error model_scale(TIFF* tiff, const std::string& path, std::optional<ModelScale>& result) {
  const auto scale = tag_values<double>(tiff, kModelPixelScaleTag, TIFF_DOUBLE);
  if (!scale.empty()) {
    if (scale.size() < 2) return failure(path, "ModelPixelScaleTag: fewer than two values");
    result = ModelScale{scale[0], scale[1], {}, {}};
    const auto tie = tag_values<double>(tiff, kModelTiepointTag, TIFF_DOUBLE);
    if (tie.size() >= 6) {
      result->west = tie[3] - tie[0] * scale[0];
      result->north = tie[4] + tie[1] * scale[1];
    }
    return check_orientation(path, *result);
  }
  const auto matrix = tag_values<double>(tiff, kModelTransformationTag, TIFF_DOUBLE);
  if (matrix.empty()) return {};
  if (matrix.size() != 16) return failure(path, "ModelTransformationTag: not 16 values");
  if (matrix[1] != 0 || matrix[4] != 0)
    return failure(path, "ModelTransformationTag: the image is rotated; gdalwarp IN OUT turns it");
  result = ModelScale{matrix[0], -matrix[5], matrix[3], matrix[7]};
  return check_orientation(path, *result);
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
  const int code = keys.number(kProjectedTypeKey).value_or(kUserDefined);
  std::optional<int> stated = keys.number(kProjLinearUnitsKey);
  if (!stated) stated = code == kUserDefined ? kMetre : unit_of_code(kProjectedUnits, code);
  if (!stated) {
    return failure(path, "ProjectedCSTypeGeoKey: the file names EPSG:" + std::to_string(code) +
                             " and no unit; give --pixel-size M, or gdalwarp -t_srs to UTM");
  }
  if (model == 0 && code == kUserDefined && scale.x < kSurelyDegrees && scale.west && scale.north &&
      std::abs(*scale.west) <= kMostLongitude && std::abs(*scale.north) <= kMostLatitude) {
    return failure(path,
                   "pixel size: " + std::to_string(scale.x) +
                       " of a system that the file does not name: degrees? gdal_translate -a_srs EPSG:4326 "
                       "says so, or give --pixel-size M");
  }
  const int unit = *stated;
  double metres = keys.real(kProjLinearUnitSizeKey).value_or(0);
  if (unit != kUserDefined) {
    if (Error error = metres_of_unit(path, "ProjLinearUnitsGeoKey", unit, metres); !error.ok()) return error;
  }
  tags.spacing_x_m = scale.x * metres;
  tags.spacing_z_m = scale.y * metres;
  return {};
}

// needed: nobody says how many metres a unit is.
Error read_height_unit(const GeoKeys& keys, const std::string& path, bool needed, double& metres) {
  if (const auto unit = keys.number(kVerticalUnitsKey))
    return *unit == kUserDefined ? Error() : metres_of_unit(path, "VerticalUnitsGeoKey", *unit, metres);
  const int code = keys.number(kVerticalTypeKey).value_or(kUserDefined);
  if (code == kUserDefined) return {};
  if (const auto unit = unit_of_code(kVerticalUnits, code))
    return metres_of_unit(path, "VerticalCSTypeGeoKey", *unit, metres);
  if (!needed) return {};
  return failure(path, "VerticalCSTypeGeoKey: the file names EPSG:" + std::to_string(code) +
                           " and no unit; give --z-scale S, the metres of a unit");
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

Error read_geotiff_tags(const std::string& path, const GeoTiffNeeds& needs, GeoTiffTags& tags) {
  tags = {};
  bool truncated = false;
  const TiffFile tiff = open_tiff(path, truncated);
  if (truncated) return failure(path, "truncated: a tag lies beyond the end of the file");
  if (tiff == nullptr) return failure(path, "not a readable TIFF file");
  const GeoKeys keys(tiff.get());
  if (Error error = read_nodata(tiff.get(), path, tags.nodata); !error.ok()) return error;
  if (Error error = read_height_unit(keys, path, needs.height_unit, tags.metres_per_unit); !error.ok())
    return error;
  tags.geographic = keys.number(kModelTypeKey) == 2;
  std::optional<ModelScale> scale;
  if (Error error = model_scale(tiff.get(), path, scale); !error.ok()) return error;
  if (needs.scale && scale) {
    if (Error error = apply_scale(*scale, keys, needs.twice_middle, path, tags); !error.ok()) return error;
  }
  return check_samples(tiff.get(), path);  // leaves the first directory
}

}  // namespace karst::bake
