// SPDX-License-Identifier: MIT
#include "bake/rasters/checks/mosaic_parts.h"

#include <cpl_conv.h>
#include <cpl_minixml.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include "bake/rasters/checks/height_unit.h"

namespace karst::bake {
namespace {

struct DestroyXml {
  void operator()(CPLXMLNode* node) const { CPLDestroyXMLNode(node); }
};
struct CloseFile {
  void operator()(void* file) const { GDALClose(file); }
};

bool holds(GDALDataType mosaic, GDALDataType part) {
  return GDALDataTypeIsFloating(mosaic) != 0 || GDALDataTypeUnion(mosaic, part) == mosaic;
}

bool is_masked(GDALRasterBandH band) {
  return (GDALGetMaskFlags(band) & (GMF_ALL_VALID | GMF_NODATA)) == 0;
}

double metres_of_unit(const CheckedRaster& raster) {
  const HeightUnit unit = height_unit(raster, GDALGetSpatialRef(raster.file));
  const double metres = unit.metres > 0 ? unit.metres : 1;
  return unit.is_depth ? -metres : metres;
}

// What is wrong with a part, in words that follow its name; empty: nothing.
std::string difference(const CheckedRaster& mosaic, const CheckedRaster& part, const CPLXMLNode* source) {
  const GDALDataType type = GDALGetRasterDataType(part.band), taken = GDALGetRasterDataType(mosaic.band);
  if (!holds(taken, type)) {
    return std::string("has samples of ") + GDALGetDataTypeName(type) + ", which are cut to " +
           GDALGetDataTypeName(taken);
  }
  if (GDALGetRasterScale(part.band, nullptr) != GDALGetRasterScale(mosaic.band, nullptr) ||
      GDALGetRasterOffset(part.band, nullptr) != GDALGetRasterOffset(mosaic.band, nullptr))
    return "has another scale or offset than the VRT";
  if (std::abs(metres_of_unit(part) - metres_of_unit(mosaic)) > 1e-9)
    return "has another unit of heights than the VRT";
  int has_void = 0, has_own = 0;
  const double value = GDALGetRasterNoDataValue(part.band, &has_void);
  const double own = GDALGetRasterNoDataValue(mosaic.band, &has_own);
  const bool is_told = CPLGetXMLValue(source, "NODATA", nullptr) != nullptr;
  const bool is_same = has_own != 0 && (own == value || (std::isnan(own) && std::isnan(value)));
  if (has_void != 0 && !is_told && !is_same && !std::isnan(value))
    return "has voids, which the VRT takes for heights";
  const bool asks_mask = std::string_view(CPLGetXMLValue(source, "UseMaskBand", "false")) == "true";
  if (is_masked(part.band) && !is_masked(mosaic.band) && !asks_mask)
    return "has a mask, which the VRT leaves out";
  return {};
}

}  // namespace

Error check_mosaic_parts(const CheckedRaster& mosaic) {
  const std::unique_ptr<CPLXMLNode, DestroyXml> root(CPLParseXMLFile(mosaic.path.c_str()));
  const CPLXMLNode* const whole = CPLSearchXMLNode(root.get(), "=VRTDataset");
  if (whole == nullptr) return mosaic.path + ": damaged VRT";
  const int number = GDALGetBandNumber(mosaic.band);
  const std::filesystem::path folder = std::filesystem::path(mosaic.path).parent_path();
  int bands = 0;
  for (const CPLXMLNode* band = whole->psChild; band != nullptr; band = band->psNext) {
    if (band->eType != CXT_Element || std::string_view(band->pszValue) != "VRTRasterBand") continue;
    if (++bands != number) continue;
    for (const CPLXMLNode* source = band->psChild; source != nullptr; source = source->psNext) {
      const CPLXMLNode* const file = CPLGetXMLNode(source, "SourceFilename");
      if (source->eType != CXT_Element || file == nullptr) continue;
      const bool relative = std::string_view(CPLGetXMLValue(file, "relativeToVRT", "0")) != "0";
      const std::string name = CPLGetXMLValue(file, nullptr, "");
      std::string path = relative ? (folder / name).string() : name;
      if (!path.starts_with('/')) path.insert(0, "./");
      const std::unique_ptr<void, CloseFile> opened(
          GDALOpenEx(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
      const GDALRasterBandH part =
          opened == nullptr
              ? nullptr
              : GDALGetRasterBand(opened.get(), std::atoi(CPLGetXMLValue(source, "SourceBand", "1")));
      const std::string wrong = part == nullptr ? std::string("cannot be read")
                                                : difference(mosaic, {opened.get(), part, path}, source);
      if (!wrong.empty()) {
        return mosaic.path + ": its part '" + name + "' " + wrong +
               "; gdalbuildvrt makes one of parts that are alike";
      }
    }
  }
  return {};
}

}  // namespace karst::bake
