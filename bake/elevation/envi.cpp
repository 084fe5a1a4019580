// SPDX-License-Identifier: MIT
#include "bake/elevation/envi.h"

#include "bake/elevation/elevation.h"
#include "bake/elevation/geo_scale.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <vector>

namespace karst::bake {
namespace {

constexpr std::uint64_t kMaxOffset =
    1u << 20;  // bytes of a header inside the raw file; real ones are a few hundred

std::string_view trim(std::string_view s) {
  const auto space = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
  while (!s.empty() && space(s.front())) s.remove_prefix(1);
  while (!s.empty() && space(s.back())) s.remove_suffix(1);
  return s;
}

std::string lower(std::string_view s) {
  std::string result(s);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

// Reading goes on after an error, with values that mean nothing; the first error is kept.
class Header {
 public:
  Header(std::string_view text, const std::string& name) : name_(name) {
    if (!text.starts_with("ENVI") || !trim(text.substr(4, text.find('\n') - 4)).empty()) {
      error_ = name_ + ": the first line is not ENVI";
      return;
    }
    text.remove_prefix(std::min(text.size(), text.find('\n')));
    while (error_.ok() && !(text = trim(text)).empty()) take_entry(text);
  }

  const Error& error() const { return error_; }
  void fail(const std::string& key, const std::string& what) const {
    if (error_.ok()) error_ = name_ + ": " + key + ": " + what;
  }

  const std::string* find(const std::string& key) const {
    const auto it = values_.find(key);
    return it == values_.end() ? nullptr : &it->second;
  }

  std::uint64_t integer(const std::string& key, std::uint64_t low, std::uint64_t high,
                        std::optional<std::uint64_t> otherwise = {}) const {
    const std::string* text = find(key);
    if (text == nullptr) {
      if (!otherwise) fail(key, "missing");
      return otherwise.value_or(low);
    }
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
    if (error != std::errc() || end != text->data() + text->size() || value < low || value > high) {
      fail(key, "'" + *text + "' is not in " + std::to_string(low) + " to " + std::to_string(high));
      return low;
    }
    return value;
  }

  double real(const std::string& key, std::string_view text) const {
    text = trim(text);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) {
      std::string what = "'";
      what.append(text).append("' is not a number");
      fail(key, what);
    }
    return value;
  }

 private:
  // One `key = value` from the front of text; a braced value ends at its closing brace.
  void take_entry(std::string_view& text) {
    if (text.front() == ';') {  // a comment line
      text.remove_prefix(std::min(text.size(), text.find('\n')));
      return;
    }
    const std::size_t line = std::min(text.size(), text.find('\n'));
    const std::size_t equals = text.find('=');
    if (equals >= line) {
      fail(std::string(trim(text.substr(0, std::min<std::size_t>(line, 40)))), "a line without '='");
      return;
    }
    const std::string key = lower(trim(text.substr(0, equals)));
    std::string_view value = text.substr(equals + 1);
    const std::size_t start = value.find_first_not_of(" \t");
    if (start != std::string_view::npos && value[start] == '{') {
      const std::size_t end = value.find('}');
      if (end == std::string_view::npos) {
        fail(key, "'{' is not closed");
        return;
      }
      text = value.substr(end + 1);
      value = value.substr(start + 1, end - start - 1);
    } else {
      text.remove_prefix(line);
      value = value.substr(0, value.find('\n'));
    }
    if (!values_.emplace(key, trim(value)).second) fail(key, "given twice");
  }

  std::string name_;
  std::map<std::string, std::string> values_;
  mutable Error error_;
};

std::vector<std::string_view> split_list(std::string_view list) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t comma = list.find(',');
    parts.push_back(trim(list.substr(0, comma)));
    if (comma == std::string_view::npos) return parts;
    list.remove_prefix(comma + 1);
  }
}

// "map info": projection, reference column and row (1-based), their x and y, column and row size, then zone,
// datum and `units=...`.
void read_map_info(const Header& header, EnviHeader& result) {
  const std::string key = "map info";
  const std::string* text = header.find(key);
  if (text == nullptr) return;
  const auto parts = split_list(*text);
  if (parts.size() < 7) {
    header.fail(key, "fewer than seven values");
    return;
  }
  const double size_x = header.real(key, parts[5]);
  const double size_y = header.real(key, parts[6]);
  std::string unit;
  for (const std::string_view part : parts) {
    const std::string word = lower(part);
    if (word.starts_with("units=")) unit = trim(std::string_view(word).substr(6));
  }
  result.geographic = lower(parts[0]) == "geographic lat/lon" || unit == "degrees";
  if (!result.geographic) {
    double metres = 1;
    if (unit == "feet") {
      metres = 0.3048;
    } else if (!unit.empty() && unit != "meters" && unit != "metres") {
      header.fail(key, "units '" + unit + "' are not known; use --pixel-size M");
    }
    result.spacing_x_m = size_x * metres;
    result.spacing_z_m = size_y * metres;
    return;
  }
  const double row = header.real(key, parts[2]);
  const double north = header.real(key, parts[4]) + (row - 1) * size_y;
  const double latitude = north - 0.5 * size_y * result.height;
  if (!(std::abs(latitude) <= 89)) {
    header.fail(key, "the mean latitude is not within 89 degrees");
    return;
  }
  const DegreeM degree = metres_per_degree(latitude);
  result.spacing_x_m = size_x * degree.x;
  result.spacing_z_m = size_y * degree.y;
}

}  // namespace

Error parse_envi_header(std::string_view text, const std::string& name, bool need_scale, EnviHeader& result) {
  const Header header(text, name);
  result = {};
  result.width = static_cast<int>(header.integer("samples", 2, kMaxElevationSide));
  result.height = static_cast<int>(header.integer("lines", 2, kMaxElevationSide));
  header.integer("bands", 1, 1, 1);
  result.offset = header.integer("header offset", 0, kMaxOffset, 0);
  const std::uint64_t type = header.integer("data type", 1, 15);
  if (type != 1 && type != 2 && type != 4 && type != 12) {
    header.fail("data type", std::to_string(type) + " is not 1, 2, 4 or 12 (8-bit, int16, float, uint16)");
  }
  result.type = static_cast<EnviType>(type);
  // With one band, bil, bip and bsq are the same bytes.
  if (const std::string* order = header.find("interleave")) {
    const std::string word = lower(*order);
    if (word != "bil" && word != "bip" && word != "bsq")
      header.fail("interleave", "'" + *order + "' is not known");
  }
  const bool many_bytes = result.type != EnviType::u8;
  result.big_endian = (many_bytes ? header.integer("byte order", 0, 1) : 0) == 1;
  if (const std::string* value = header.find("data ignore value")) {
    result.nodata = header.real("data ignore value", *value);
  }
  if (need_scale) read_map_info(header, result);
  return header.error();
}

std::string find_envi_header(const std::string& path) {
  std::error_code ignored;
  const std::filesystem::path swapped = std::filesystem::path(path).replace_extension(".hdr");
  if (swapped != path && std::filesystem::is_regular_file(swapped, ignored)) return swapped.string();
  std::string appended = path + ".hdr";
  if (std::filesystem::is_regular_file(appended, ignored)) return appended;
  return {};
}

}  // namespace karst::bake
