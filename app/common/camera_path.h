// SPDX-License-Identifier: MIT
// Where pictures are taken from, as it is given or read from a path file.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

#include "platform/base/error.h"

namespace karst::app {

// A camera as users state it: metres to the east, up and to the south; degrees. Yaw 0 looks north (-z) and
// grows to the left, pitch grows upwards; on a curved basis by north and up at the place.
struct CameraPlace {
  // Where on_map: longitude, latitude and altitude in metres, or coordinates of the world's reference system,
  // which camera_ground.h places.
  glm::dvec3 position_m{0.0};
  double yaw_deg = 0.0;
  double pitch_deg = 0.0;
  bool on_map = false;
  bool above_ground = false;  // y is metres above the highest ground at x, z, which camera_ground.h finds
};

inline constexpr std::size_t kMaxPathFrames = 1'000'000;

// "X,Y,Z,YAW,PITCH", or "X,~H,Z,YAW,PITCH" for H metres above the ground; "@LON,LAT,ALT,YAW,PITCH" or
// "@LON,LAT,~H,YAW,PITCH" by longitude and latitude. The error names `what`.
Error parse_camera(std::string_view text, std::string_view what, CameraPlace& place);
// The same with blanks in place of the commas, as lines of paths and poses have it.
Error parse_camera_line(std::string_view line, std::string_view what, CameraPlace& place);
// The same without words, for floods of lines: whether it is one.
bool read_camera_line(std::string_view line, CameraPlace& place);

// A path: a line "X Y Z YAW PITCH" a frame; empty lines and what follows a # are left out. Messages name file
// and line.
Error parse_camera_path(std::string_view text, const std::string& file, std::vector<CameraPlace>& path);

}  // namespace karst::app
