// SPDX-License-Identifier: MIT
// Elevation through GDAL: all kinds of raster of a list that is stated here, and no other.
#include "bake/rasters/elevation_file.h"

#include "bake/rasters/checks/file_check.h"
#include "bake/rasters/checks/height_unit.h"
#include "bake/rasters/checks/mosaic_parts.h"
#include "bake/rasters/gdal/gdal_session.h"
#include "bake/rasters/ground_size.h"
#include "bake/rasters/mosaic_check.h"
#include "bake/rasters/sample_sink.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <gdal.h>
#include <gdal_frmts.h>
#include <gdal_priv.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <string_view>
#include <utility>

namespace karst::bake {
namespace {

constexpr std::uint64_t kLargeBlockBytes = 4u << 20;  // from here on a block needs bytes in the file
constexpr std::uint64_t kMostBlockBytes = 128u << 20;
constexpr std::uint64_t kMostUnpacked = 64;  // bytes of a large block a byte of file
constexpr std::uint64_t kCacheBytes = 32u << 20;
constexpr std::uint64_t kBandBytes = 16u << 20;  // of rows that are read together, as doubles
constexpr int kBandRows = 64;

struct DestroySrs {
  void operator()(void* srs) const { OSRRelease(srs); }
};

// An open raster, and the band of it that holds the heights.
class Raster {
 public:
  // Both outlive it.
  Raster(const ReadElevation& settings, const std::string& path) : settings_(settings), path_(path) {}

  Error open() {
    messages_.start(plain_name(path_));
    prepare_gdal();
    GDALSetCacheMax64(kCacheBytes);
    if (is_mosaic(path_)) {
      if (Error error = check_mosaic(path_); !error.ok()) return error;
    }
    file_.reset(
        GDALOpenEx(plain_name(path_).c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
    if (file_ == nullptr) {
      if (!messages_.failures().empty() && !messages_.mentions("not recognized")) return unreadable();
      return failure("not a raster that karst-bake reads: see DEM in karst-bake --help");
    }
    if (Error error = choose_band(); !error.ok()) return error;
    if (Error error = read_format(); !error.ok()) return error;
    if (Error error = check_raw(); !error.ok()) return error;
    if (Error error = choose_crs(); !error.ok()) return error;
    const Error turned = placement_.read(file_.get());
    if (!turned.ok()) return failure(turned.text());
    if (settings_.bounds) {
      if (Error error = placement_.set_bounds(file_.get(), *settings_.bounds); !error.ok())
        return failure(error.text());
    }
    return check_messages();
  }

  // After open(): what takes a look at all of the file, or at files that it names.
  Error check_contents() const {
    const CheckedRaster checked = {file_.get(), band_, path_};
    if (is_driver("AAIGrid") || is_driver("GRASSASCIIGrid")) return check_text_grid(checked);
    return is_driver("VRT") ? check_mosaic_parts(checked) : Error();
  }

  Error describe(ElevationGrid& grid) {
    grid = {};
    grid.width = GDALGetRasterXSize(file_.get());
    grid.height = GDALGetRasterYSize(file_.get());
    grid.placed = placement_.placed;
    if (grid.placed) {
      grid.west = placement_.to_crs[0];
      grid.north = placement_.to_crs[3];
      grid.step_x = placement_.to_crs[1];
      grid.step_z = -placement_.to_crs[5];
    }
    grid.earth = earth_of(srs_, placement_);
    if (const OGRSpatialReferenceH srs = srs_) {
      char* text = nullptr;
      if (OSRExportToWkt(srs, &text) == OGRERR_NONE && text != nullptr) grid.crs = text;
      CPLFree(text);
    }
    char** const files = GDALGetFileList(file_.get());
    for (char** name = files; name != nullptr && *name != nullptr; ++name) grid.files.emplace_back(*name);
    CSLDestroy(files);
    return check_blocks(grid);
  }

  Error read(const Window& whole, const Window& part, ElevationPart& result) {
    GroundSize size;
    if (Error error = size.read(file_.get(), srs_, placement_, whole, settings_.pixel_size_m); !error.ok())
      return failure(error.text());
    if (Error error = read_height_unit(size); !error.ok()) return error;
    result.spacing_x_m = size.x_m;
    result.spacing_z_m = size.z_m;
    for (const std::vector<std::string>* list : {&warnings_, &size.warnings}) {
      for (const std::string& warning : *list) result.warnings.push_back(path_ + ": " + warning);
    }
    if (GDALGetMetadata(file_.get(), "SUBDATASETS") != nullptr) {
      result.warnings.push_back(
          path_ + ": the file holds several rasters, and the first is taken; gdalinfo names them");
    }
    if (!size.note.empty()) format_.kind += ", " + size.note;
    ElevationGrid grid;
    if (Error error = describe(grid); !error.ok()) return error;
    GDALSetCacheMax64(static_cast<GIntBig>(kCacheBytes + grid.block_row_bytes));
    SampleSink sink(settings_, path_, format_, result);
    if (Error error = read_rows(part, sink); !error.ok()) return error;
    if (Error error = check_messages(); !error.ok()) return error;
    for (const std::string& warning : messages_.warnings())
      result.warnings.push_back(path_ + ": GDAL: " + warning);
    return sink.finish();
  }

 private:
  static std::string number(double value) { return short_number(value); }
  Error failure(const std::string& what) const { return path_ + ": " + what; }
  bool is_driver(std::string_view name) const {
    return name == GDALGetDriverShortName(GDALGetDatasetDriver(file_.get()));
  }
  Error unreadable() const {
    return failure("unreadable raster: " +
                   (messages_.failures().empty() ? "truncated or damaged" : messages_.failures().front()));
  }

  // The file's coordinate reference system, or what the user says instead.
  Error choose_crs() {
    srs_ = GDALGetSpatialRef(file_.get());
    if (settings_.crs.empty()) return {};
    given_srs_.reset(OSRNewSpatialReference(nullptr));
    const int code = std::atoi(settings_.crs.c_str() + std::string_view("EPSG:").size());
    if (OSRImportFromEPSG(given_srs_.get(), code) != OGRERR_NONE)
      return "--crs: " + settings_.crs + " is not known to PROJ";
    OSRSetAxisMappingStrategy(given_srs_.get(), OAMS_TRADITIONAL_GIS_ORDER);
    srs_ = given_srs_.get();
    return {};
  }

  // What GDAL goes on without, and what files mean two things by.
  Error check_messages() const {
    if (messages_.mentions("IO error")) return failure("truncated: what the file says of itself is cut off");
    if (messages_.mentions("ScaleY")) {
      return failure(
          "pixel size: below 0; gdal_translate -a_ullr LEFT TOP RIGHT BOTTOM says where its corners are");
    }
    const OGRSpatialReferenceH srs = srs_;
    if (messages_.mentions("not found") && !settings_.z_scale) {
      return failure(
          "units: it names a coordinate reference system or a unit that PROJ does not know; give "
          "--z-scale S, the metres of a unit of height" +
          std::string(srs == nullptr || OSRIsLocal(srs) != 0 ? ", and --pixel-size M" : ""));
    }
    return {};
  }

  Error check_raw() {
    const CheckedRaster checked = {file_.get(), band_, path_};
    return check_raw_file(checked, settings_.pixel_size_m > 0, warnings_);
  }

  Error choose_band() {
    const int count = GDALGetRasterCount(file_.get());
    int bands = 0, first = 0, alpha = 0;  // bands: without those that mask another
    for (int k = count; k > 0; --k) {
      const bool is_alpha =
          GDALGetRasterColorInterpretation(GDALGetRasterBand(file_.get(), k)) == GCI_AlphaBand;
      (is_alpha ? alpha : first) = k;
      bands += is_alpha ? 0 : 1;
    }
    if (settings_.band > count || count == 0) {
      return failure(count == 0
                         ? std::string("bands: none; it is a collection of rasters: gdalinfo names them")
                         : "--band: the raster has " + std::to_string(count));
    }
    if (settings_.band == 0 && bands != 1) {
      return failure("bands: " + std::to_string(count) + "; --band N takes one of them as the elevation");
    }
    const int chosen = settings_.band > 0 ? settings_.band : first;
    band_ = GDALGetRasterBand(file_.get(), chosen);
    if (alpha > 0 && alpha != chosen) {
      mask_ = GDALGetRasterBand(file_.get(), alpha);
    } else if ((GDALGetMaskFlags(band_) & (GMF_ALL_VALID | GMF_NODATA)) == 0) {
      mask_ = GDALGetMaskBand(band_);
    }
    const GDALDataType type = GDALGetRasterDataType(band_);
    if (GDALDataTypeIsComplex(type) != 0 || type == GDT_Unknown)
      return failure(std::string("sample type: ") + GDALGetDataTypeName(type) + " is no height");
    const char* const bits = GDALGetMetadataItem(band_, "NBITS", "IMAGE_STRUCTURE");
    const char* const signs = GDALGetMetadataItem(band_, "PIXELTYPE", "IMAGE_STRUCTURE");
    if (signs != nullptr && std::string_view(signs) == "SIGNEDBYTE")
      return failure("sample type: signed bytes are not read; gdal_translate -ot Int16 makes whole numbers");
    const bool few_bits = bits != nullptr && std::atoi(bits) <= 8;
    return check_8bit(settings_, path_, type == GDT_Byte || few_bits);
  }

  Error read_format() {
    const GDALDataType type = GDALGetRasterDataType(band_);
    format_.kind = std::string(GDALGetDriverShortName(GDALGetDatasetDriver(file_.get()))) + " " +
                   GDALGetDataTypeName(type);
    format_.is_8bit = type == GDT_Byte;
    format_.is_signed_16bit = type == GDT_Int16;
    format_.is_whole = type != GDT_Float32 && type != GDT_Float64;
    format_.is_float = type == GDT_Float32;
    format_.is_unsigned = type == GDT_UInt16 || type == GDT_UInt32 || type == GDT_UInt64;
    int known = 0;
    if (type == GDT_Int64) {
      const auto value = GDALGetRasterNoDataValueAsInt64(band_, &known);
      if (known != 0) format_.nodata = static_cast<double>(value);
    } else if (type == GDT_UInt64) {
      const auto value = GDALGetRasterNoDataValueAsUInt64(band_, &known);
      if (known != 0) format_.nodata = static_cast<double>(value);
    } else {
      const double value = GDALGetRasterNoDataValue(band_, &known);
      if (known != 0) format_.nodata = value;
    }
    format_.scale = GDALGetRasterScale(band_, nullptr);
    format_.offset = GDALGetRasterOffset(band_, nullptr);
    if (format_.scale == 0 || !std::isfinite(format_.scale) || !std::isfinite(format_.offset))
      return failure("scale and offset of the samples: " + number(format_.scale) + ", " +
                     number(format_.offset) + "; gdal_translate -a_scale 1 -a_offset 0 takes them away");
    return {};
  }

  Error read_height_unit(GroundSize& size) {
    const HeightUnit unit = height_unit({file_.get(), band_, path_}, srs_);
    if (unit.is_said && !(unit.metres > 0) && !settings_.z_scale) {
      return failure("heights: their unit '" + unit.name +
                     "' is not known; give --z-scale S, the metres of a unit");
    }
    format_.metres_per_unit = unit.metres > 0 ? unit.metres : 1;
    format_.is_unit_said = unit.is_said;
    if (unit.is_depth) {
      format_.metres_per_unit *= -1;
      warnings_.emplace_back(
          "its vertical coordinate system counts depths: taken as heights below 0; --z-scale -1 turns them");
    }
    if (!unit.is_said && size.in_feet && !settings_.z_scale) {
      size.warnings.emplace_back(
          "its axes are in feet and nothing says what heights are in: taken as metres; --z-scale 0.3048 "
          "takes "
          "them as feet, --z-scale 1 says that they are metres");
    }
    return {};
  }

  // Blocks are decoded whole.
  Error check_blocks(ElevationGrid& grid) const {
    std::uint64_t file_bytes = 0;
    for (const std::string& name : grid.files) {
      std::error_code failed;
      const std::uintmax_t bytes = std::filesystem::file_size(name, failed);
      if (!failed) file_bytes += bytes;
    }
    for (const GDALRasterBandH band : {band_, mask_}) {
      if (band == nullptr) continue;
      int width = 0, height = 0;
      GDALGetBlockSize(band, &width, &height);
      const auto side = [](int n) { return static_cast<std::uint64_t>(std::max(1, n)); };
      const std::uint64_t sample =
          static_cast<std::uint64_t>(GDALGetDataTypeSizeBytes(GDALGetRasterDataType(band)));
      const std::uint64_t block = side(width) * side(height) * sample;
      if (block > kMostBlockBytes || (block > kLargeBlockBytes && block / kMostUnpacked > file_bytes)) {
        return failure("blocks: one is " + std::to_string(width) + " x " + std::to_string(height) +
                       " samples in a file of " + std::to_string(file_bytes) +
                       " bytes; gdal_translate -co TILED=YES makes smaller ones");
      }
      grid.block_row_bytes += side(std::max(width, grid.width)) * side(height) * sample;
    }
    return {};
  }

  int coverage(const Window& window) const {
    return GDALGetDataCoverageStatus(band_, window.column, window.row, window.width, window.height, 0,
                                     nullptr);
  }

  // Where a file has no block GDAL reads 0. Here it is NaN, a void. window: of the
  // file as it is; samples: its rows, stride apart.
  void mark_absent(const Window& window, double* samples, std::size_t stride) const {
    const int status = coverage(window);
    if ((status & GDAL_DATA_COVERAGE_STATUS_EMPTY) == 0) return;
    const bool has_data = (status & GDAL_DATA_COVERAGE_STATUS_DATA) != 0;
    if (has_data && window.width * window.height > 1) {
      const bool across = window.width >= window.height;
      int block[2] = {1, 1};
      GDALGetBlockSize(band_, &block[0], &block[1]);
      const int first = across ? window.column : window.row, size = across ? window.width : window.height;
      const int middle = first + size / 2, edge = middle - middle % std::max(1, block[across ? 0 : 1]);
      const int half = (edge > first ? edge : middle) - first;
      Window near = window, far = window;
      if (across) {
        near.width = half;
        far.column += half;
        far.width -= half;
      } else {
        near.height = half;
        far.row += half;
        far.height -= half;
      }
      mark_absent(near, samples, stride);
      mark_absent(far, samples + static_cast<std::size_t>(half) * (across ? 1 : stride), stride);
      return;
    }
    if (has_data) return;
    for (int row = 0; row < window.height; ++row) {
      double* const start = samples + static_cast<std::size_t>(row) * stride;
      std::fill(start, start + window.width, std::numeric_limits<double>::quiet_NaN());
    }
  }

  Error read_rows(const Window& part, SampleSink& sink) {
    const int raster_width = GDALGetRasterXSize(file_.get()), raster_height = GDALGetRasterYSize(file_.get());
    const int column = placement_.columns_from_east ? raster_width - part.column - part.width : part.column;
    const int last_row = placement_.rows_from_south ? raster_height - part.row - part.height : part.row;
    const bool may_lack = !format_.nodata && (coverage({column, last_row, part.width, part.height}) &
                                              GDAL_DATA_COVERAGE_STATUS_EMPTY) != 0;
    if (may_lack && is_driver("VRT")) {
      return failure(
          "has places that no part of it covers, and no value for them; gdalbuildvrt -vrtnodata "
          "-9999 gives them one, --crop takes what is covered");
    }
    const auto width = static_cast<std::size_t>(part.width);
    const auto most_rows =
        static_cast<int>(std::max<std::uint64_t>(1, kBandBytes / (width * sizeof(double))));
    const int band_rows = std::min(kBandRows, most_rows);
    std::vector<double> samples;
    std::vector<unsigned char> mask;
    for (int first = part.row; first < part.row + part.height; first += band_rows) {
      const int rows = std::min(band_rows, part.row + part.height - first);
      const int file_row = placement_.rows_from_south ? raster_height - first - rows : first;
      samples.resize(width * static_cast<std::size_t>(rows));
      if (GDALRasterIO(band_, GF_Read, column, file_row, part.width, rows, samples.data(), part.width, rows,
                       GDT_Float64, 0, 0) != CE_None)
        return unreadable();
      if (may_lack) mark_absent({column, file_row, part.width, rows}, samples.data(), width);
      if (mask_ != nullptr) {
        mask.resize(samples.size());
        if (GDALRasterIO(mask_, GF_Read, column, file_row, part.width, rows, mask.data(), part.width, rows,
                         GDT_Byte, 0, 0) != CE_None)
          return unreadable();
      }
      for (int k = 0; k < rows; ++k) {
        const int from = placement_.rows_from_south ? rows - 1 - k : k;
        const std::size_t start = width * static_cast<std::size_t>(from);
        const std::span<double> row = std::span(samples).subspan(start, width);
        const std::span<unsigned char> row_mask =
            mask_ != nullptr ? std::span(mask).subspan(start, width) : std::span<unsigned char>();
        if (placement_.columns_from_east) {
          std::reverse(row.begin(), row.end());
          std::reverse(row_mask.begin(), row_mask.end());
        }
        if (Error error = sink.take_row(first + k, part.column, row, row_mask); !error.ok()) return error;
      }
    }
    return {};
  }

  const ReadElevation& settings_;
  const std::string& path_;
  GdalMessages& messages_ = GdalMessages::of_process();
  GdalFile file_;
  GDALRasterBandH band_ = nullptr;
  GDALRasterBandH mask_ = nullptr;  // 0 where band_ is void; null: it is nowhere
  SampleFormat format_;
  Placement placement_;
  std::unique_ptr<void, DestroySrs> given_srs_;
  OGRSpatialReferenceH srs_ = nullptr;  // null: none
  std::vector<std::string> warnings_;   // without the file's name
};

}  // namespace

Error describe_raster(const ReadElevation& settings, const std::string& path, ElevationGrid& grid) {
  Raster raster(settings, path);
  if (Error error = raster.open(); !error.ok()) return error;
  if (Error error = raster.check_contents(); !error.ok()) return error;
  return raster.describe(grid);
}

Error read_raster(const ReadElevation& settings, const std::string& path, const Window& whole,
                  const Window& part, ElevationPart& result) {
  Raster raster(settings, path);
  if (Error error = raster.open(); !error.ok()) return error;
  return raster.read(whole, part, result);
}

}  // namespace karst::bake
