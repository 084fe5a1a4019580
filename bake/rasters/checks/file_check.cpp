// SPDX-License-Identifier: MIT
#include "bake/rasters/checks/file_check.h"

#include <cpl_string.h>
#include <gdal_priv.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>

namespace karst::bake {
namespace {

constexpr std::size_t kHeaderBytes = 1 << 16;  // that are looked at; most have a few hundred
constexpr std::size_t kTextBytes = 1 << 20;    // of a text grid, at once
constexpr std::size_t kMostWordBytes = 64;

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

class RawFile {
 public:
  explicit RawFile(const CheckedRaster& raster) : raster_(raster), type_(GDALGetRasterDataType(raster.band)) {
    const GDALDriverH driver = GDALGetDatasetDriver(raster.file);
    kind_ = driver == nullptr ? "" : GDALGetDriverShortName(driver);
  }

  Error check(bool is_sized, std::vector<std::string>& warnings) {
    GDALDataset* const file = GDALDataset::FromHandle(raster_.file);
    if (!file->GetRawBinaryLayout(layout_)) return {};
    // Samples of other lengths than their type's, which GDAL unpacks.
    if (GDALGetMetadataItem(raster_.band, "NBITS", "IMAGE_STRUCTURE") != nullptr) return {};
    if (Error error = check_length(warnings); !error.ok()) return error;
    if (kind_ == "EHdr") return check_esri_order();
    if (kind_ != "ENVI") return {};
    if (Error error = check_envi_order(); !error.ok()) return error;
    return is_sized ? Error() : check_envi_unit();
  }

 private:
  Error failure(const std::string& what) const { return raster_.path + ": " + what; }

  // What is behind the file's end GDAL reads as 0.
  Error check_length(std::vector<std::string>& warnings) const {
    const auto last = [](int count, GIntBig step) {
      return static_cast<double>(count - 1) * static_cast<double>(step);
    };
    const double end = static_cast<double>(layout_.nImageOffset) +
                       last(GDALGetRasterCount(raster_.file), layout_.nBandOffset) +
                       last(GDALGetRasterYSize(raster_.file), layout_.nLineOffset) +
                       last(GDALGetRasterXSize(raster_.file), layout_.nPixelOffset) +
                       GDALGetDataTypeSizeBytes(type_);
    std::error_code failed;
    const auto bytes = static_cast<double>(std::filesystem::file_size(
        layout_.osRawFilename.empty() ? raster_.path : layout_.osRawFilename, failed));
    if (failed || end > bytes)
      return failure("truncated: its header says " + number(end) + " bytes, and it has " + number(bytes));
    if (end < bytes && (kind_ == "EHdr" || kind_ == "ENVI")) {
      warnings.push_back("its header says " + number(end) + " bytes, and it has " + number(bytes) +
                         ": heights are wrong unless they begin where " +
                         (kind_ == "EHdr" ? "SKIPBYTES" : "header offset") + " says");
    }
    return {};
  }

  // GDAL takes samples whose header does not say for those of another machine.
  Error check_esri_order() const {
    if (GDALGetDataTypeSizeBytes(type_) == 1) return {};
    const std::string text = lower_case(text_beside(raster_.file, ".hdr"));
    const std::size_t key = text.find("byteorder");
    const std::size_t at = key == std::string::npos ? key : text.find_first_not_of(" \t", key + 9);
    if (at != std::string::npos && std::string_view("iml").find(text[at]) != std::string_view::npos)
      return {};
    return failure("byte order: its header says neither BYTEORDER I (the lower byte first) nor M");
  }

  Error check_envi_order() const {
    const auto item = [&](const char* key) {
      const char* const text = GDALGetMetadataItem(raster_.file, key, "ENVI");
      return std::string(text == nullptr ? "" : text);
    };
    const std::string offset = item("header_offset");
    if (!offset.empty() && offset != std::to_string(layout_.nImageOffset))
      return failure("header offset: '" + offset + "' is not a number of bytes in the file");
    if (type_ != GDT_Byte && item("byte_order") != "0" && item("byte_order") != "1")
      return failure("byte order: its header says neither 0 (the lower byte first) nor 1");
    return {};
  }

  // GDAL takes units that it does not know for metres, and does not tell.
  Error check_envi_unit() const {
    const std::string text = lower_case(text_beside(raster_.file, ".hdr"));
    const std::size_t map = text.find("map info"), end = text.find('}', map);
    if (map == std::string::npos) return {};
    const std::size_t at = text.substr(0, end).find("units=", map);
    if (at == std::string::npos) return {};
    const std::string unit = text.substr(at + 6, text.find_first_of(",}\r\n", at) - at - 6);
    static constexpr std::string_view kKnown[] = {"meters",  "feet",    "yards",   "miles", "nautical miles",
                                                  "degrees", "minutes", "seconds", "km",    "radians"};
    if (std::find(std::begin(kKnown), std::end(kKnown), unit) != std::end(kKnown)) return {};
    return failure("map info: units '" + unit + "' are not known; give --pixel-size M");
  }

  const CheckedRaster& raster_;
  GDALDataType type_;
  std::string_view kind_;
  GDALDataset::RawBinaryLayout layout_;
};

// GDAL reads words that are no numbers as 0, and does not look behind the last sample of its header.
class TextGrid {
 public:
  explicit TextGrid(const CheckedRaster& raster) : raster_(raster) {}

  Error check() {
    std::ifstream in(raster_.path, std::ios::binary);
    std::vector<char> bytes(kTextBytes);
    std::string word;
    for (bool more = true; more;) {
      in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
      const auto count = static_cast<std::size_t>(in.gcount());
      more = count > 0;
      for (std::size_t n = 0; n < count; ++n) {
        const char c = bytes[n];
        if (c != ' ' && c != '\n' && c != '\r' && c != '\t') {
          if (word.size() < kMostWordBytes) word += c;
        } else if (!word.empty() && !take(word)) {
          return failure(word);
        }
      }
    }
    if (!word.empty() && !take(word)) return failure(word);
    const auto expected = static_cast<std::uint64_t>(GDALGetRasterXSize(raster_.file)) *
                          static_cast<std::uint64_t>(GDALGetRasterYSize(raster_.file));
    if (count_ == expected) return {};
    return raster_.path + ": holds " + std::to_string(count_) + " heights, and its header says " +
           std::to_string(GDALGetRasterXSize(raster_.file)) + " x " +
           std::to_string(GDALGetRasterYSize(raster_.file));
  }

 private:
  Error failure(const std::string& word) const {
    return raster_.path + ": height " + std::to_string(count_ + 1) + ": '" + word + "' is not a number";
  }

  // The header is names with a value each. Clears the word; false: it is no number.
  bool take(std::string& word) {
    const auto is_number = [](std::string_view text) {
      return text.find_first_not_of("0123456789+-.,eE") == std::string_view::npos &&
             text.find_first_of("0123456789") != std::string_view::npos;
    };
    bool good = true;
    if (in_value_) {
      if (name_.starts_with("nodata") || name_.starts_with("null")) void_ = lower_case(word);
      in_value_ = false;
    } else if (!is_number(word)) {
      const std::string lower = lower_case(word);
      const bool is_void = lower == "*" || lower == void_ || lower == "nan" || lower == "-nan" ||
                           lower == "null" || lower == "inf" || lower == "-inf";
      const bool is_name = count_ == 0 && !is_void && std::isalpha(static_cast<unsigned char>(word[0])) != 0;
      good = is_void || is_name;
      if (is_name) {
        name_ = lower;
        in_value_ = true;
      } else if (is_void) {
        ++count_;
      }
    } else {
      ++count_;
    }
    if (good) word.clear();
    return good;
  }

  const CheckedRaster& raster_;
  std::string name_, void_;  // lower case; name_: of the header's value that comes next
  bool in_value_ = false;
  std::uint64_t count_ = 0;  // of heights
};

}  // namespace

Error check_raw_file(const CheckedRaster& raster, bool is_sized, std::vector<std::string>& warnings) {
  return RawFile(raster).check(is_sized, warnings);
}

Error check_text_grid(const CheckedRaster& raster) {
  return TextGrid(raster).check();
}

std::string text_beside(GDALDatasetH file, std::string_view ending) {
  char** const files = GDALGetFileList(file);
  std::string text(kHeaderBytes, '\0');
  for (char** name = files; name != nullptr && *name != nullptr; ++name) {
    if (!lower_case(*name).ends_with(ending)) continue;
    std::ifstream(*name, std::ios::binary).read(text.data(), static_cast<std::streamsize>(text.size()));
  }
  CSLDestroy(files);
  return text.c_str();
}

std::string lower_case(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

}  // namespace karst::bake
