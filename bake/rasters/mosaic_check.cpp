// SPDX-License-Identifier: MIT
#include "bake/rasters/mosaic_check.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_minixml.h>
#include <gdal.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string_view>

namespace karst::bake {
namespace {

constexpr std::uintmax_t kMostBytes = 16 << 20;
constexpr int kMostSources = 10'000;
constexpr int kMostWithoutVoid = 200;  // sources whose gaps are looked for: GDAL's time grows with the square
constexpr int kMostDepth = 16;
// Samples of all parts of a band: so many, and so many times its own. Tiles overlap a little.
constexpr double kFreePartSamples = 1 << 22;
constexpr int kMostOverlap = 8;
// Of what is decoded of the parts' files: so many more for each byte of these.
constexpr double kDecodedPerByte = 16;
constexpr std::size_t kStartBytes = 1'024;  // GDAL looks at as many

// What gdalbuildvrt and gdal_translate -of VRT write of a raster that is made of parts of files.
constexpr std::string_view kElements[] = {"VRTDataset",    "SRS",
                                          "GeoTransform",  "Metadata",
                                          "MDI",           "VRTRasterBand",
                                          "MaskBand",      "NoDataValue",
                                          "ColorInterp",   "Description",
                                          "UnitType",      "Offset",
                                          "Scale",         "SimpleSource",
                                          "ComplexSource", "SourceBand",
                                          "SrcRect",       "SourceProperties",
                                          "DstRect",       "SourceFilename",
                                          "NODATA",        "UseMaskBand",
                                          "BlockXSize",    "BlockYSize",
                                          "Histograms",    "HideNoDataValue"};
constexpr std::string_view kSubClasses = "subClass";  // of bands that compute, warp or sharpen

struct DestroyXml {
  void operator()(CPLXMLNode* node) const { CPLDestroyXMLNode(node); }
};

// What a part's file says of its samples. Of one that cannot be opened, which GDAL tells later: nothing.
struct SourceSize {
  double width = 0, height = 0;              // samples
  double block_width = 1, block_height = 1;  // which are decoded together

  static SourceSize of(const std::string& path) {
    SourceSize size;
    const std::unique_ptr<void, decltype(&GDALClose)> file(GDALOpen(path.c_str(), GA_ReadOnly), GDALClose);
    const GDALRasterBandH band = file == nullptr ? nullptr : GDALGetRasterBand(file.get(), 1);
    if (band == nullptr) return size;
    int width = 0, height = 0;
    GDALGetBlockSize(band, &width, &height);
    size.width = GDALGetRasterXSize(file.get());
    size.height = GDALGetRasterYSize(file.get());
    size.block_width = std::max(width, 1);
    size.block_height = std::max(height, 1);
    return size;
  }

  // In whole blocks.
  double decoded(double columns, double rows) const {
    return std::ceil(std::min(columns, width) / block_width) * block_width *
           (std::ceil(std::min(rows, height) / block_height) * block_height);
  }
};

std::filesystem::path real(const std::filesystem::path& path) {
  std::error_code failed;
  std::filesystem::path result = std::filesystem::canonical(path, failed);
  return failed ? std::filesystem::path() : result;
}

bool lies_below(const std::filesystem::path& path, const std::filesystem::path& folder) {
  const auto [in_folder, in_path] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  return in_folder == folder.end() && in_path != path.end();
}

class Checker {
 public:
  explicit Checker(const std::string& path)
      : path_(path), parent_(std::filesystem::path(path).parent_path()) {
    folder_ = real(parent_.empty() ? "." : parent_);
  }

  // mosaic: the whole; null where there is none, which GDAL tells.
  Error check_all(const CPLXMLNode* root, const CPLXMLNode* mosaic) {
    width_ = CPLAtof(CPLGetXMLValue(mosaic, "rasterXSize", "0"));
    height_ = CPLAtof(CPLGetXMLValue(mosaic, "rasterYSize", "0"));
    return check(root, 0);
  }

  // After check_all(): parts may have voids, which the mosaic has to tell from heights.
  Error check_voids() const {
    if (has_void_ || (!parts_have_voids_ && sources_ <= kMostWithoutVoid)) return {};
    return path_ +
           ": the VRT has no <NoDataValue>, and parts that have voids or may leave gaps; gdalbuildvrt "
           "-vrtnodata -9999 gives it one";
  }

 private:
  Error check(const CPLXMLNode* node, int depth) {
    if (depth > kMostDepth) return failure("is nested too deep");
    for (; node != nullptr; node = node->psNext) {
      if (node->eType == CXT_Attribute && node->pszValue == kSubClasses)
        return failure(std::string("has a band that is computed (") + CPLGetXMLValue(node, nullptr, "") +
                       ")");
      if (node->eType != CXT_Element) continue;
      const std::string_view name = node->pszValue;
      if (name.starts_with('?')) continue;  // <?xml ...?>
      // Statistics and the like: GDAL reads no file for them.
      if (name == "Metadata" || name == "Histograms") continue;
      if (std::find(std::begin(kElements), std::end(kElements), name) == std::end(kElements))
        return failure("has a <" + std::string(name.substr(0, 40)) + ">");
      parts_have_voids_ = parts_have_voids_ || name == "NODATA";
      has_void_ = has_void_ || name == "NoDataValue";
      if (name == "VRTRasterBand") part_samples_ = decoded_samples_ = 0;
      if (name == "SimpleSource" || name == "ComplexSource") {
        if (Error error = check_part(node); !error.ok()) return error;
      }
      if (name == "SourceFilename") {
        std::string path;
        if (Error error = check_source(node, path); !error.ok()) return error;
      }
      if (Error error = check(node->psChild, depth + 1); !error.ok()) return error;
    }
    return {};
  }

  Error failure(const std::string& what) const {
    return path_ + ": the VRT " + what + "; gdal_translate makes a GeoTIFF of it";
  }

  // Where it lies in the band, and what of its file is decoded for it; without a place it is all of either.
  Error check_part(const CPLXMLNode* part) {
    const auto side = [part](const char* name, double most) {
      const char* const text = CPLGetXMLValue(part, name, nullptr);
      return text == nullptr ? most : std::clamp(CPLAtof(text), 0.0, most);
    };
    part_samples_ += side("DstRect.xSize", width_) * side("DstRect.ySize", height_);
    if (++sources_ > kMostSources) return failure("has more than " + std::to_string(kMostSources) + " parts");
    const double free = kFreePartSamples + kMostOverlap * width_ * height_;
    if (part_samples_ > free) {
      return failure("has parts that lie over each other more than " + std::to_string(kMostOverlap) +
                     " times");
    }
    const CPLXMLNode* const named = CPLGetXMLNode(const_cast<CPLXMLNode*>(part), "SourceFilename");
    if (named == nullptr) return failure("has a part that names no file");
    std::string path;
    if (Error error = check_source(named, path); !error.ok()) return error;
    const auto [known, is_new] = files_.try_emplace(path);
    if (is_new) {
      known->second = SourceSize::of(path);
      std::error_code failed;
      const std::uintmax_t bytes = std::filesystem::file_size(path, failed);
      if (!failed) file_bytes_ += static_cast<double>(bytes);
    }
    const SourceSize& source = known->second;
    decoded_samples_ +=
        source.decoded(side("SrcRect.xSize", source.width), side("SrcRect.ySize", source.height));
    if (decoded_samples_ > free + kDecodedPerByte * file_bytes_)
      return failure("has parts whose files are decoded to much more than it shows of them");
    return {};
  }

  // path: of the file.
  Error check_source(const CPLXMLNode* node, std::string& path) const {
    const std::string name = CPLGetXMLValue(node, nullptr, "");
    const bool relative = std::string_view(CPLGetXMLValue(node, "relativeToVRT", "0")) != "0";
    const std::filesystem::path source = relative ? parent_ / name : std::filesystem::path(name);
    const std::filesystem::path found = name.starts_with("/vsi") ? std::filesystem::path() : real(source);
    std::error_code failed;
    if (found.empty() || !std::filesystem::is_regular_file(found, failed))
      return failure("names '" + name + "', which is no file");
    if (!lies_below(found, folder_)) return failure("names '" + name + "', which is not in its folder");
    path = found.string();
    if (is_mosaic(path)) return failure("names another VRT, '" + name + "'");
    return {};
  }

  const std::string& path_;
  std::filesystem::path parent_, folder_;
  double width_ = 0, height_ = 0;                  // of the mosaic
  double part_samples_ = 0, decoded_samples_ = 0;  // of the band in hand
  std::map<std::string, SourceSize> files_;        // of parts
  double file_bytes_ = 0;
  int sources_ = 0;
  bool parts_have_voids_ = false, has_void_ = false;
};

}  // namespace

bool is_mosaic(const std::string& path) {
  std::string start(kStartBytes, '\0');
  std::ifstream(path, std::ios::binary).read(start.data(), static_cast<std::streamsize>(start.size()));
  return start.find("<VRTDataset") != std::string::npos;
}

Error check_mosaic(const std::string& path) {
  std::error_code failed;
  const std::uintmax_t bytes = std::filesystem::file_size(path, failed);
  if (failed || bytes > kMostBytes) return path + ": the VRT is longer than 16 MiB";
  const std::unique_ptr<CPLXMLNode, DestroyXml> root(CPLParseXMLFile(path.c_str()));
  if (root == nullptr) return path + ": damaged VRT: " + CPLGetLastErrorMsg();
  Checker checker(path);
  Error error = checker.check_all(root.get(), CPLSearchXMLNode(root.get(), "=VRTDataset"));
  return error.ok() ? checker.check_voids() : error;
}

}  // namespace karst::bake
