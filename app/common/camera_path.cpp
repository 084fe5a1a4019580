// SPDX-License-Identifier: MIT
#include "app/common/camera_path.h"

#include <span>

#include "app/common/arguments.h"
#include "platform/base/text.h"

namespace karst::app {
namespace {

constexpr char kOnMap = '@';

// Of five numbers which may have a ~ before it.
std::size_t height_of(std::string_view text) {
  return text.starts_with(kOnMap) ? 2 : 1;
}
std::string_view numbers_of(std::string_view text) {
  if (text.starts_with(kOnMap)) text.remove_prefix(1);
  return text;
}

void set_place(std::span<const double, 5> numbers, bool on_map, bool above_ground, CameraPlace& place) {
  place.on_map = on_map;
  place.position_m = {numbers[0], numbers[1], numbers[2]};
  place.yaw_deg = numbers[3];
  place.pitch_deg = numbers[4];
  place.above_ground = above_ground;
}

Error parse_place(std::string_view text, std::string_view what, char separator, CameraPlace& place) {
  double numbers[5];
  bool above_ground = false;
  if (Error error = parse_numbers(numbers_of(text), what, separator, numbers, height_of(text), &above_ground);
      !error.ok()) {
    return error;
  }
  set_place(numbers, text.starts_with(kOnMap), above_ground, place);
  return {};
}

}  // namespace

Error parse_camera(std::string_view text, std::string_view what, CameraPlace& place) {
  return parse_place(text, what, ',', place);
}

Error parse_camera_line(std::string_view line, std::string_view what, CameraPlace& place) {
  return parse_place(line, what, ' ', place);
}

bool read_camera_line(std::string_view line, CameraPlace& place) {
  double numbers[5];
  bool above_ground = false;
  const NumbersRead read = read_numbers(numbers_of(line), ' ', numbers, height_of(line), &above_ground);
  if (read.fault != NumbersFault::none) return false;
  set_place(numbers, line.starts_with(kOnMap), above_ground, place);
  return true;
}

Error parse_camera_path(std::string_view text, const std::string& file, std::vector<CameraPlace>& path) {
  path.clear();
  text = without_byte_order_mark(text);
  std::size_t line_number = 0;
  while (!text.empty()) {
    ++line_number;
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    line = line.substr(0, line.find('#'));
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
    const std::string what = file + ": line " + std::to_string(line_number);
    CameraPlace place;
    if (Error error = parse_camera_line(line, what, place); !error.ok()) {
      return error.text() + "; a line is X Y Z YAW PITCH";
    }
    if (path.size() == kMaxPathFrames)
      return what + ": more than " + std::to_string(kMaxPathFrames) + " frames";
    path.push_back(place);
  }
  return path.empty() ? file + ": no camera in it; a line is X Y Z YAW PITCH" : std::string();
}

}  // namespace karst::app
