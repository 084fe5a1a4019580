// SPDX-License-Identifier: MIT
#include "app/common/camera_path.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "app/common/arguments.h"

namespace karst::app {
namespace {

constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180.0;

// The overview stands above the south-east corner and looks north-west: the two sides of the world that meet
// there then run along the borders of a wide picture, and the land fills it. Its height is this part of the
// ground's diagonal above the highest point, and the opposite corner is seen at this part of the picture's
// height above its centre.
constexpr double kOverviewHeight = 0.09;
constexpr double kOverviewYawDeg = 45.0;
constexpr double kOverviewHorizon = 0.31;

// From here on nearer things are cut: small enough to walk through a cave with.
constexpr double kNearest = 1.0 / 32;  // voxels

Error parse_place(std::string_view text, std::string_view what, char separator, CameraPlace& place) {
  double numbers[5];
  bool above_ground = false;
  if (Error error = parse_numbers(text, what, separator, numbers, 1, &above_ground); !error.ok()) {
    return error;
  }
  place.position_m = {numbers[0], numbers[1], numbers[2]};
  place.yaw_deg = numbers[3];
  place.pitch_deg = numbers[4];
  place.above_ground = above_ground;
  return {};
}

glm::dvec3 voxels(glm::ivec3 lattice) {
  return glm::dvec3(lattice) / static_cast<double>(kStepsPerVoxel);
}

glm::dvec3 corner(const LatticeBox& box, int n) {
  const glm::dvec3 low = voxels(box.min);
  const glm::dvec3 high = voxels(box.max);
  return {(n & 1) != 0 ? high.x : low.x, (n & 2) != 0 ? high.y : low.y, (n & 4) != 0 ? high.z : low.z};
}

}  // namespace

Error parse_camera(std::string_view text, std::string_view what, CameraPlace& place) {
  return parse_place(text, what, ',', place);
}

Error parse_camera_line(std::string_view line, std::string_view what, CameraPlace& place) {
  return parse_place(line, what, ' ', place);
}

Error parse_camera_path(std::string_view text, const std::string& file, std::vector<CameraPlace>& path) {
  path.clear();
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

Status place_camera(const CameraPlace& place, const WorldFrame& frame, const LatticeBox& box,
                    double fov_y_deg, double aspect, Camera& camera) {
  CameraSettings settings;
  if (const Status status = voxels_from_metres(frame, place.position_m, settings.position); !status.ok()) {
    return status;
  }
  settings.yaw_deg = place.yaw_deg;
  settings.pitch_deg = place.pitch_deg;
  settings.fov_y_deg = fov_y_deg;
  settings.aspect = aspect;
  // A depth buffer's steps grow with far / near: take near as far as the view allows, a half of what lies
  // between the eye and the box.
  const glm::dvec3 outside = glm::max(
      glm::max(voxels(box.min) - settings.position, settings.position - voxels(box.max)), glm::dvec3(0.0));
  double farthest = 0.0;
  for (int n = 0; n < 8; ++n) farthest = std::max(farthest, glm::length(corner(box, n) - settings.position));
  settings.near_voxels = std::max(kNearest, 0.5 * glm::length(outside));
  settings.far_voxels = std::min(std::max(farthest * 1.01, settings.near_voxels * 2.0), kCameraReach);
  settings.near_voxels = std::min(settings.near_voxels, settings.far_voxels * 0.5);
  return make_camera(settings, camera);
}

CameraPlace overview(const WorldFrame& frame, const LatticeBox& box, double fov_y_deg) {
  const glm::dvec3 low = voxels(box.min);
  const glm::dvec3 high = voxels(box.max);
  const double diagonal = std::hypot(high.x - low.x, high.z - low.z);
  // Whole 64ths of a voxel survive the way through metres and back, so that the view does not depend on the
  // origin.
  const glm::dvec3 eye =
      glm::floor(glm::dvec3(high.x, high.y + kOverviewHeight * diagonal, high.z) * 64.0 + 0.5) / 64.0;
  const double down_deg = std::atan2(eye.y - 0.5 * (low.y + high.y), diagonal) / kRadiansPerDegree;
  const double pitch_deg = -std::min(down_deg + kOverviewHorizon * fov_y_deg, 89.0);
  return {frame.origin_m + eye * frame.voxel_size_m, kOverviewYawDeg, pitch_deg};
}

}  // namespace karst::app
