// SPDX-License-Identifier: MIT
// Images through GDAL, in a child: opened, placed on the ground, and warped to its grid window by window.
#include "bake/imagery/cube_way.h"
#include "bake/imagery/image_file.h"
#include "bake/rasters/gdal/gdal_session.h"
#include "bake/rasters/mosaic_check.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <gdal.h>
#include <gdal_alg.h>
#include <gdal_frmts.h>
#include <gdalwarper.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "terrain/imagery/image_tile.h"

namespace karst::bake {
using namespace core;
namespace {

constexpr std::uint64_t kCacheBytes = 64u << 20;
constexpr std::uint64_t kLargeBlockBytes = 4u << 20;  // from here on a block needs bytes in the file
constexpr std::uint64_t kMostBlockBytes = 128u << 20;
constexpr std::uint64_t kMostUnpacked = 256;  // bytes of a large block a byte of file
constexpr double kWarpBytes = 32u << 20;
constexpr double kApproximation = 0.05;  // pixels that the middle of a line may be off
constexpr int kOutline = 32;             // places along a side, of which extents are taken
constexpr double kEqualShape = 0.01;     // between sides of an image that is laid over all of the ground

struct DestroyTransformer {
  void operator()(void* transformer) const { GDALDestroyTransformer(transformer); }
};
using Transformer = std::unique_ptr<void, DestroyTransformer>;

struct DestroyWarp {
  void operator()(GDALWarpOptions* options) const { GDALDestroyWarpOptions(options); }
};

class Image {
 public:
  Image(const GroundGrid& ground, const std::string& path) : ground_(ground), path_(path) {}

  Error open() {
    messages_.start(plain_name(path_));
    prepare_gdal();
    GDALRegister_JPEG();
    GDALSetCacheMax64(kCacheBytes);
    if (is_mosaic(path_)) {
      if (Error error = check_mosaic(path_); !error.ok()) return error;
    }
    file_.reset(
        GDALOpenEx(plain_name(path_).c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
    if (file_ == nullptr) {
      if (!messages_.failures().empty() && !messages_.mentions("not recognized")) return unreadable();
      return failure("not an image that karst-bake reads: see DEM in karst-bake --help");
    }
    if (Error error = choose_bands(); !error.ok()) return error;
    return place();
  }

  Error describe(ImageFacts& facts) {
    facts = {};
    facts.width = width();
    facts.height = height();
    if (Error error = check_blocks(facts.block_bytes); !error.ok()) return error;
    if (is_cube()) {
      if (Error error = find_faces(facts); !error.ok()) return error;
    } else if (Error error = find_extent(facts); !error.ok()) {
      return error;
    }
    facts.is_opaque = alpha_ == 0;
    for (int k = 0; facts.is_opaque && k < colours_; ++k)
      facts.is_opaque = (GDALGetMaskFlags(band(bands_[k])) & GMF_ALL_VALID) != 0;
    facts.covers_all = covers_all();
    facts.kind = std::string(GDALGetDriverShortName(GDALGetDatasetDriver(file_.get()))) + ", " +
                 std::to_string(GDALGetRasterCount(file_.get())) + " bands" +
                 (laid_ ? ", laid over all" : "");
    for (const std::string& warning : messages_.warnings())
      facts.warnings.push_back(path_ + ": GDAL: " + warning);
    return {};
  }

  Error read(const TexelWindow& window, std::vector<std::byte>& rgba) {
    const std::size_t texels =
        static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height);
    rgba.assign(4 * texels, std::byte{0});
    const double texel = std::ldexp(1.0, window.size) / kTexelsPerSample;  // samples
    double to_geo[6] = {ground_.west + (static_cast<double>(window.column) * texel + 0.5) * ground_.step_x,
                        texel * ground_.step_x,
                        0,
                        ground_.north - (static_cast<double>(window.row) * texel + 0.5) * ground_.step_z,
                        0,
                        -texel * ground_.step_z};
    std::unique_ptr<GDALWarpOptions, DestroyWarp> options(GDALCreateWarpOptions());
    set_options(*options);
    const GdalFile source = laid_ ? laid_over() : GdalFile();
    GDALDatasetH const from = source ? source.get() : file_.get();
    options->hSrcDS = from;
    Transformer whole(make_transformer(from));
    if (whole == nullptr) return no_way();
    if (is_cube()) return read_face(from, whole.get(), window, std::move(options), rgba);
    GDALSetGenImgProjTransformerDstGeoTransform(whole.get(), to_geo);
    Transformer quick(GDALCreateApproxTransformer(GDALGenImgProjTransform, whole.get(), kApproximation));
    if (quick == nullptr) return no_way();
    options->pfnTransformer = GDALApproxTransform;
    options->pTransformerArg = quick.get();
    // The virtual raster owns its transformer.
    GDALApproxTransformerOwnsSubtransformer(quick.get(), TRUE);
    static_cast<void>(whole.release());
    GdalFile warped(GDALCreateWarpedVRT(from, window.width, window.height, to_geo, options.get()));
    if (warped == nullptr) return unreadable();
    static_cast<void>(quick.release());
    return read_texels(warped.get(), window, rgba);
  }

 private:
  // A window of a face, straight through longitudes and latitudes. degrees: pixels of from to them.
  Error read_face(GDALDatasetH from, void* degrees, const TexelWindow& window,
                  std::unique_ptr<GDALWarpOptions, DestroyWarp> options, std::vector<std::byte>& rgba) const {
    double plain[6] = {0, 1, 0, 0, 0, 1};
    GDALSetGenImgProjTransformerDstGeoTransform(degrees, plain);
    CubeWay way;
    if (!open_way(way, degrees, from)) return no_way();
    const double texel = std::ldexp(1.0, window.size) / kTexelsPerSample;
    way.face = window.face;
    way.texel = texel;
    way.column = static_cast<double>(window.column) * texel;
    way.row = static_cast<double>(window.row) * texel;
    set_scale(way, window, *options);
    options->pfnTransformer = way.head.pfnTransform;
    options->pTransformerArg = &way;
    GdalFile warped(GDALCreateWarpedVRT(from, window.width, window.height, plain, options.get()));
    if (warped == nullptr) return unreadable();
    return read_texels(warped.get(), window, rgba);
  }

  // How many pixels a texel is wide and high, for GDAL's filter: it would go by the window's outline, which
  // has all of an image's width where the window lies across the date line.
  static void set_scale(const CubeWay& way, const TexelWindow& window, GDALWarpOptions& options) {
    std::array<std::vector<double>, 2> widths;
    for (int n = 0; n < 9; ++n) {
      const double i = way.column + way.texel * window.width * (0.1 + 0.4 * (n % 3)),
                   k = way.row + way.texel * window.height * (0.1 + 0.4 * (n / 3));
      double x[3], y[3];
      bool known = true;
      for (int to = 0; to < 3; ++to) {
        known = known && way.pixel_of(way.face, i + (to == 1 ? way.texel : 0), k + (to == 2 ? way.texel : 0),
                                      x[to], y[to]);
      }
      if (!known) continue;
      const auto across = [&](double from, double there) {
        double way_px = there - from;
        if (way.turn_px > 0) way_px = std::remainder(way_px, way.turn_px);
        return way_px;
      };
      widths[0].push_back(std::hypot(across(x[0], x[1]), across(x[0], x[2])));
      widths[1].push_back(std::hypot(y[1] - y[0], y[2] - y[0]));
    }
    if (widths[0].empty()) return;
    // What of the image a window needs is found by places all over it, since poles and the date line lie
    // inside; between two of them lies as much more.
    constexpr int kPlaces = 128;
    const double widest = std::max(*std::max_element(widths[0].begin(), widths[0].end()),
                                   *std::max_element(widths[1].begin(), widths[1].end()));
    const double between = widest * std::max(window.width, window.height) / kPlaces;
    const std::string extra = std::to_string(8 + static_cast<int>(std::min(between, 2048.0)));
    options.papszWarpOptions = CSLSetNameValue(options.papszWarpOptions, "SAMPLE_GRID", "YES");
    options.papszWarpOptions =
        CSLSetNameValue(options.papszWarpOptions, "SAMPLE_STEPS", std::to_string(kPlaces).c_str());
    options.papszWarpOptions = CSLSetNameValue(options.papszWarpOptions, "SOURCE_EXTRA", extra.c_str());
    constexpr double kWidest = 64;
    const char* const names[2] = {"XSCALE", "YSCALE"};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      // In most of it: a pole would make all of its window as dim as itself.
      const auto middle = widths[axis].begin() + static_cast<std::ptrdiff_t>(widths[axis].size() / 2);
      std::nth_element(widths[axis].begin(), middle, widths[axis].end());
      const std::string scale = std::to_string(1 / std::clamp(*middle, 1.0, kWidest));
      options.papszWarpOptions = CSLSetNameValue(options.papszWarpOptions, names[axis], scale.c_str());
    }
  }

  bool is_cube() const { return ground_.face_quads > 0; }

  bool open_way(CubeWay& way, void* degrees, GDALDatasetH from) const {
    Basis basis;
    basis.kind = BasisKind::cube;
    basis.centred = true;
    basis.face_quads = ground_.face_quads;
    basis.radius_m = ground_.radius_m;
    basis.flattening = ground_.flattening;
    if (!basis.finish().ok()) return false;
    way.open(basis, degrees, from);
    return true;
  }

  // As find_extent(), by face.
  Error find_faces(ImageFacts& facts) const {
    const GdalFile source = laid_ ? laid_over() : GdalFile();
    GDALDatasetH const from = source ? source.get() : file_.get();
    const Transformer degrees(make_transformer(from));
    if (degrees == nullptr) return no_way();
    double plain[6] = {0, 1, 0, 0, 0, 1};
    GDALSetGenImgProjTransformerDstGeoTransform(degrees.get(), plain);
    CubeWay way;
    if (!open_way(way, degrees.get(), from)) return no_way();
    constexpr double kFar = std::numeric_limits<double>::infinity();
    for (int face = 0; face < kCubeFaces; ++face) {
      for (int axis = 0; axis < 2; ++axis) {
        facts.face_low[face][axis] = kFar;
        facts.face_high[face][axis] = -kFar;
      }
    }
    facts.pixel_samples = kFar;
    constexpr int kPlaces = 4 * kOutline;
    double farthest = 0;
    for (int k = 0; k <= kPlaces; ++k) {
      for (int i = 0; i <= kPlaces; ++i) {
        const double column = std::min(static_cast<double>(width()) * i / kPlaces, width() - 1.0);
        const double row = std::min(static_cast<double>(height()) * k / kPlaces, height() - 1.0);
        GridPlace here, east, south, next;
        if (!way.sample_of(column, row, here)) continue;
        const double at[2] = {here.i, here.k};
        for (int axis = 0; axis < 2; ++axis) {
          facts.face_low[here.face][axis] = std::min(facts.face_low[here.face][axis], at[axis]);
          facts.face_high[here.face][axis] = std::max(facts.face_high[here.face][axis], at[axis]);
        }
        if (!way.sample_of(column + 1, row, east) || !way.sample_of(column, row + 1, south)) continue;
        if (east.face != here.face || south.face != here.face) continue;
        const double sides[2] = {std::hypot(east.i - here.i, east.k - here.k),
                                 std::hypot(south.i - here.i, south.k - here.k)};
        // Beside a pole pixels are narrow without being fine.
        facts.pixel_samples = std::min(facts.pixel_samples, std::max(sides[0], sides[1]));
        if (way.sample_of(std::min(column + static_cast<double>(width()) / kPlaces, width() - 1.0),
                          std::min(row + static_cast<double>(height()) / kPlaces, height() - 1.0), next) &&
            next.face == here.face)
          farthest = std::max(farthest, std::hypot(next.i - here.i, next.k - here.k));
      }
    }
    if (!(facts.pixel_samples > 0) || !std::isfinite(facts.pixel_samples))
      return failure("no place of it has one on the planet");
    for (int axis = 0; axis < 2; ++axis) facts.low[axis] = 0, facts.high[axis] = 0;
    for (int face = 0; face < kCubeFaces; ++face) {
      for (int axis = 0; axis < 2; ++axis) {
        facts.face_low[face][axis] -= farthest;
        facts.face_high[face][axis] += farthest;
        facts.high[axis] = std::max(facts.high[axis], facts.face_high[face][axis]);
      }
    }
    return {};
  }

  Error read_texels(GDALDatasetH warped, const TexelWindow& window, std::vector<std::byte>& rgba) const {
    if (is_palette_) return read_palette(warped, window, rgba);
    const int row = 4 * window.width;
    auto* const out = reinterpret_cast<unsigned char*>(rgba.data());
    int from_bands[4] = {1, 2, 3, colours_ + 1};
    if (colours_ == 1) from_bands[1] = from_bands[2] = 1;
    if (GDALDatasetRasterIO(warped, GF_Read, 0, 0, window.width, window.height, out, window.width,
                            window.height, GDT_Byte, 4, from_bands, 4, row, 1) != CE_None)
      return unreadable();
    return {};
  }

  Error failure(const std::string& what) const { return path_ + ": " + what; }
  Error unreadable() const {
    return failure("unreadable image: " +
                   (messages_.failures().empty() ? "truncated or damaged" : messages_.failures().front()));
  }
  Error no_way() const {
    return failure("its coordinate reference system cannot be turned into the ground's: " +
                   (messages_.failures().empty() ? "PROJ knows no way" : messages_.failures().front()));
  }
  int width() const { return GDALGetRasterXSize(file_.get()); }
  int height() const { return GDALGetRasterYSize(file_.get()); }
  GDALRasterBandH band(int n) const { return GDALGetRasterBand(file_.get(), n); }

  Error choose_bands() {
    const int count = GDALGetRasterCount(file_.get());
    for (int n = 1; n <= count; ++n) {
      const GDALColorInterp meaning = GDALGetRasterColorInterpretation(band(n));
      if (GDALGetRasterDataType(band(n)) != GDT_Byte) {
        return failure(std::string("sample type: ") + GDALGetDataTypeName(GDALGetRasterDataType(band(n))) +
                       "; colours have 8 bits: gdal_translate -ot Byte -scale makes them");
      }
      if (meaning == GCI_AlphaBand) {
        alpha_ = n;
      } else if (meaning == GCI_CyanBand) {
        return failure("colours: of inks (CMYK); gdal_translate makes red, green and blue of them");
      } else if (colours_ < 3) {
        bands_[colours_++] = n;
      }
    }
    if (colours_ == 0) return failure("bands: none has colours");
    if (colours_ == 2) colours_ = 1;
    is_palette_ = colours_ == 1 && GDALGetRasterColorTable(band(bands_[0])) != nullptr;
    return {};
  }

  Error check_blocks(std::uint64_t& row_bytes) const {
    std::uint64_t file_bytes = 0;
    char** const files = GDALGetFileList(file_.get());
    for (char** name = files; name != nullptr && *name != nullptr; ++name) {
      std::error_code failed;
      const std::uintmax_t bytes = std::filesystem::file_size(*name, failed);
      if (!failed) file_bytes += bytes;
    }
    CSLDestroy(files);
    const auto bands = static_cast<std::uint64_t>(colours_ + (alpha_ > 0 ? 1 : 0));
    int block[2] = {1, 1};
    GDALGetBlockSize(band(bands_[0]), &block[0], &block[1]);
    const auto side = [](int n) { return static_cast<std::uint64_t>(std::max(1, n)); };
    const std::uint64_t bytes = side(block[0]) * side(block[1]) * bands;
    if (bytes > kMostBlockBytes || (bytes > kLargeBlockBytes && bytes / kMostUnpacked > file_bytes)) {
      return failure("blocks: one is " + std::to_string(block[0]) + " x " + std::to_string(block[1]) +
                     " pixels in a file of " + std::to_string(file_bytes) +
                     " bytes; gdal_translate -co TILED=YES makes smaller ones");
    }
    row_bytes = side(std::max(block[0], width())) * side(block[1]) * bands;
    return {};
  }

  // Which way of laying it holds.
  Error place() {
    double to_geo[6];
    const bool placed =
        GDALGetGeoTransform(file_.get(), to_geo) == CE_None || GDALGetGCPCount(file_.get()) > 0;
    const bool has_crs =
        GDALGetSpatialRef(file_.get()) != nullptr || GDALGetGCPSpatialRef(file_.get()) != nullptr;
    if (placed && !ground_.placed)
      return failure(
          "the DEM does not say where it lies, so that no image can be laid over it by its place; "
          "gdal_edit.py -unsetgt lays it over all of the ground");
    if (placed && has_crs && ground_.crs.empty())
      return failure("the DEM has no coordinate reference system; gdal_translate -a_srs gives it one");
    if (placed && !has_crs && !ground_.crs.empty())
      return failure("has no coordinate reference system; gdal_translate -a_srs gives it one");
    if (placed) return {};
    // Without a place: over all of the ground, if it has its shape.
    const double along = static_cast<double>(ground_.samples[0]) / width();
    const double down = static_cast<double>(ground_.samples[1]) / height();
    if (!(std::abs(along - down) <= kEqualShape * along)) {
      return failure("does not say where it lies, and " + std::to_string(width()) + " x " +
                     std::to_string(height()) + " pixels have not the shape of " +
                     std::to_string(ground_.samples[0]) + " x " + std::to_string(ground_.samples[1]) +
                     " samples; gdal_translate -a_srs and -a_ullr say it");
    }
    laid_ = true;
    return {};
  }

  // The image as one that lies over all samples of the ground: a copy without pixels of its own.
  GdalFile laid_over() const {
    GDALDriverH const driver = GDALGetDriverByName("VRT");
    GdalFile copy(GDALCreateCopy(driver, "", file_.get(), FALSE, nullptr, nullptr, nullptr));
    if (copy == nullptr) return copy;
    double to_geo[6] = {ground_.west,
                        ground_.step_x * static_cast<double>(ground_.samples[0]) / width(),
                        0,
                        ground_.north,
                        0,
                        -ground_.step_z * static_cast<double>(ground_.samples[1]) / height()};
    GDALSetGeoTransform(copy.get(), to_geo);
    if (!ground_.crs.empty()) GDALSetProjection(copy.get(), ground_.crs.c_str());
    return copy;
  }

  // Pixels of file to coordinates of the ground's system.
  void* make_transformer(GDALDatasetH file) const {
    char** words = nullptr;
    if (!ground_.crs.empty()) words = CSLSetNameValue(words, "DST_SRS", ground_.crs.c_str());
    void* const made = GDALCreateGenImgProjTransformer2(file, nullptr, words);
    CSLDestroy(words);
    return made;
  }

  // How far it reaches, by places along its sides and across; and how large its pixels are.
  Error find_extent(ImageFacts& facts) {
    const GdalFile source = laid_ ? laid_over() : GdalFile();
    const Transformer way(make_transformer(source ? source.get() : file_.get()));
    if (way == nullptr) return no_way();
    constexpr double kFar = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 2; ++axis) {
      facts.low[axis] = kFar;
      facts.high[axis] = -kFar;
    }
    facts.pixel_samples = kFar;
    int known = 0;
    for (int k = 0; k <= kOutline; ++k) {
      for (int i = 0; i <= kOutline; ++i) {
        // A place, and those a pixel to the east and to the south.
        const double column = std::min(static_cast<double>(width()) * i / kOutline, width() - 1.0);
        const double row = std::min(static_cast<double>(height()) * k / kOutline, height() - 1.0);
        double x[3] = {column, column + 1, column};
        double y[3] = {row, row, row + 1};
        double z[3] = {};
        int good[3] = {};
        if (GDALGenImgProjTransform(way.get(), FALSE, 3, x, y, z, good) == FALSE) continue;
        if (good[0] == 0 || good[1] == 0 || good[2] == 0) continue;
        ++known;
        double at[2][3];
        for (int n = 0; n < 3; ++n) {
          at[0][n] = (x[n] - ground_.west) / ground_.step_x - 0.5;
          at[1][n] = (ground_.north - y[n]) / ground_.step_z - 0.5;
          for (int axis = 0; axis < 2; ++axis) {
            facts.low[axis] = std::min(facts.low[axis], at[axis][n]);
            facts.high[axis] = std::max(facts.high[axis], at[axis][n]);
          }
        }
        for (int n = 1; n < 3; ++n) {
          const double side = std::hypot(at[0][n] - at[0][0], at[1][n] - at[1][0]);
          facts.pixel_samples = std::min(facts.pixel_samples, side);
        }
      }
    }
    if (known == 0 || !(facts.pixel_samples > 0) || !std::isfinite(facts.pixel_samples))
      return failure("no place of it has one in the ground's coordinate reference system");
    // Between places sides may bend outwards.
    for (int axis = 0; axis < 2; ++axis) {
      const double bend = (facts.high[axis] - facts.low[axis]) / kOutline;
      facts.low[axis] -= bend;
      facts.high[axis] += bend;
    }
    const bool apart = facts.low[0] > static_cast<double>(ground_.samples[0]) || facts.high[0] < 0 ||
                       facts.low[1] > static_cast<double>(ground_.samples[1]) || facts.high[1] < 0;
    if (apart) return failure("does not lie over the ground: no place of it is over a sample");
    return {};
  }

  // Whether all places of the ground lie in it, by many along its sides and across.
  bool covers_all() const {
    if (is_cube()) return covers_planet();
    const GdalFile source = laid_ ? laid_over() : GdalFile();
    const Transformer way(make_transformer(source ? source.get() : file_.get()));
    if (way == nullptr) return false;
    for (int k = 0; k <= kOutline; ++k) {
      for (int i = 0; i <= kOutline; ++i) {
        const double column = static_cast<double>(ground_.samples[0] - 1) * i / kOutline;
        const double row = static_cast<double>(ground_.samples[1] - 1) * k / kOutline;
        double x = ground_.west + (column + 0.5) * ground_.step_x;
        double y = ground_.north - (row + 0.5) * ground_.step_z;
        double z = 0;
        int good = 0;
        if (GDALGenImgProjTransform(way.get(), TRUE, 1, &x, &y, &z, &good) == FALSE || good == 0)
          return false;
        // A filter has half a pixel around to look at.
        if (!(x >= 0.5 && y >= 0.5 && x <= width() - 0.5 && y <= height() - 0.5)) return false;
      }
    }
    return true;
  }

  // Only what goes once around from pole to pole can.
  bool covers_planet() const {
    const GdalFile source = laid_ ? laid_over() : GdalFile();
    GDALDatasetH const from = source ? source.get() : file_.get();
    const Transformer degrees(make_transformer(from));
    if (degrees == nullptr) return false;
    double plain[6] = {0, 1, 0, 0, 0, 1};
    GDALSetGenImgProjTransformerDstGeoTransform(degrees.get(), plain);
    CubeWay way;
    if (!open_way(way, degrees.get(), from) || way.turn_px <= 0) return false;
    if (way.turn_px > way.width_px + 0.5) return false;
    double x[2] = {0.5 * way.width_px, 0.5 * way.width_px}, y[2] = {0, static_cast<double>(height())};
    double z[2] = {};
    int good[2] = {};
    return GDALGenImgProjTransform(degrees.get(), FALSE, 2, x, y, z, good) != FALSE && good[0] != 0 &&
           good[1] != 0 && y[0] >= 90 - 1e-6 && y[1] <= -90 + 1e-6;
  }

  void set_options(GDALWarpOptions& options) const {
    options.hDstDS = nullptr;
    options.nBandCount = colours_;
    options.panSrcBands = static_cast<int*>(CPLMalloc(sizeof(int) * 3));
    options.panDstBands = static_cast<int*>(CPLMalloc(sizeof(int) * 3));
    for (int k = 0; k < colours_; ++k) {
      options.panSrcBands[k] = bands_[k];
      options.panDstBands[k] = k + 1;
    }
    options.nSrcAlphaBand = alpha_;
    options.nDstAlphaBand = colours_ + 1;
    options.dfWarpMemoryLimit = kWarpBytes;
    // It filters by as many pixels as a texel covers.
    options.eResampleAlg = is_palette_ ? GRA_NearestNeighbour : GRA_Cubic;
    options.eWorkingDataType = GDT_Byte;
    options.papszWarpOptions = CSLSetNameValue(options.papszWarpOptions, "INIT_DEST", "0");
    options.papszWarpOptions = CSLSetNameValue(options.papszWarpOptions, "UNIFIED_SRC_NODATA", "YES");
    int known = 0;
    const double nodata = GDALGetRasterNoDataValue(band(bands_[0]), &known);
    if (known == 0) return;
    options.padfSrcNoDataReal = static_cast<double*>(CPLMalloc(sizeof(double) * 3));
    for (int k = 0; k < colours_; ++k) {
      int own = 0;
      const double value = GDALGetRasterNoDataValue(band(bands_[k]), &own);
      options.padfSrcNoDataReal[k] = own != 0 ? value : nodata;
    }
  }

  Error read_palette(GDALDatasetH warped, const TexelWindow& window, std::vector<std::byte>& rgba) const {
    auto* const out = reinterpret_cast<unsigned char*>(rgba.data());
    int bands[2] = {1, 2};
    const int row = 4 * window.width;
    // The index where red comes to lie, and alpha in its place.
    if (GDALDatasetRasterIO(warped, GF_Read, 0, 0, window.width, window.height, out, window.width,
                            window.height, GDT_Byte, 2, bands, 4, row, 3) != CE_None)
      return unreadable();
    GDALColorTableH const table = GDALGetRasterColorTable(band(bands_[0]));
    const int entries = GDALGetColorEntryCount(table);
    for (std::size_t at = 0; at < rgba.size(); at += 4) {
      const int index = out[at];
      GDALColorEntry entry{0, 0, 0, 0};
      if (index < entries) GDALGetColorEntryAsRGB(table, index, &entry);
      out[at] = static_cast<unsigned char>(entry.c1);
      out[at + 1] = static_cast<unsigned char>(entry.c2);
      out[at + 2] = static_cast<unsigned char>(entry.c3);
      out[at + 3] = static_cast<unsigned char>(out[at + 3] * entry.c4 / 255);
    }
    return {};
  }

  const GroundGrid& ground_;
  const std::string& path_;
  GdalMessages& messages_ = GdalMessages::of_process();
  GdalFile file_;
  int bands_[3] = {};
  int colours_ = 0;  // 1: grey, or a palette; 3
  int alpha_ = 0;    // the band; 0: none
  bool is_palette_ = false;
  bool laid_ = false;  // over all of the ground
};

}  // namespace

Error describe_image_here(const GroundGrid& ground, const std::string& path, ImageFacts& facts) {
  Image image(ground, path);
  if (Error error = image.open(); !error.ok()) return error;
  return image.describe(facts);
}

// The file stays open for the next window: some kinds can only be read from their beginning.
Error read_image_window_here(const GroundGrid& ground, const std::string& path, const TexelWindow& window,
                             std::vector<std::byte>& rgba) {
  struct Open {
    GroundGrid ground;
    std::string path;
    std::optional<Image> image;
  };
  static Open open;
  if (!open.image || open.path != path) {
    open.image.reset();
    open.ground = ground;
    open.path = path;
    open.image.emplace(open.ground, open.path);
    if (Error error = open.image->open(); !error.ok()) {
      open.image.reset();
      return error;
    }
  }
  return open.image->read(window, rgba);
}

}  // namespace karst::bake
