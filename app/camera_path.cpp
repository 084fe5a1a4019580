// SPDX-License-Identifier: MIT
#include "app/camera_path.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "app/common/arguments.h"

namespace karst::app {
namespace {

constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180.0;

// From the south-east, 27 degrees down: three quarters of a relief's sides are seen, and the sky fills a
// fifth.
constexpr double kOverviewYawDeg = 38.0;
constexpr double kOverviewPitchDeg = -27.0;
constexpr double kOverviewFill = 0.96;  // of the picture, by the box's silhouette

// From here on nearer things are cut: small enough to walk through a cave with.
constexpr double kNearest = 1.0 / 32;  // voxels

void set_place(const double (&numbers)[5], CameraPlace& place) {
  place.position_m = {numbers[0], numbers[1], numbers[2]};
  place.yaw_deg = numbers[3];
  place.pitch_deg = numbers[4];
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

std::string parse_camera(std::string_view text, std::string_view what, CameraPlace& place) {
  double numbers[5];
  if (std::string error = parse_numbers(text, what, ',', numbers); !error.empty()) return error;
  set_place(numbers, place);
  return {};
}

std::string parse_camera_path(std::string_view text, const std::string& file,
                              std::vector<CameraPlace>& path) {
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
    double numbers[5];
    if (std::string error = parse_numbers(line, what, ' ', numbers); !error.empty()) {
      return error + "; a line is X Y Z YAW PITCH";
    }
    if (path.size() == kMaxPathFrames)
      return what + ": more than " + std::to_string(kMaxPathFrames) + " frames";
    set_place(numbers, path.emplace_back());
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

CameraPlace overview(const WorldFrame& frame, const LatticeBox& box, double fov_y_deg, double aspect) {
  const double yaw = kOverviewYawDeg * kRadiansPerDegree;
  const double pitch = kOverviewPitchDeg * kRadiansPerDegree;
  const glm::dvec3 forward{-std::sin(yaw) * std::cos(pitch), std::sin(pitch),
                           -std::cos(yaw) * std::cos(pitch)};
  const glm::dvec3 right{std::cos(yaw), 0.0, -std::sin(yaw)};
  const glm::dvec3 up = glm::cross(right, forward);
  const double half_height = std::tan(0.5 * fov_y_deg * kRadiansPerDegree) * kOverviewFill;
  const double half_width = half_height * aspect;

  // The eye moves along the view plane and back until each of the box's corners lies inside: in each of the
  // two directions the two outermost corners touch the picture's border.
  const glm::dvec3 centre = 0.5 * (voxels(box.min) + voxels(box.max));
  const auto fit = [&](glm::dvec3 axis, double half, double& shift, double& back) {
    double high = -1e9;  // greatest of (a - half * depth), and of (-a - half * depth), over the corners
    double low = -1e9;
    for (int n = 0; n < 8; ++n) {
      const glm::dvec3 p = corner(box, n) - centre;
      high = std::max(high, glm::dot(p, axis) - half * glm::dot(p, forward));
      low = std::max(low, -glm::dot(p, axis) - half * glm::dot(p, forward));
    }
    shift = 0.5 * (high - low);
    back = 0.5 * (high + low) / half;
  };
  double shift_right = 0.0;
  double shift_up = 0.0;
  double back_for_width = 0.0;
  double back_for_height = 0.0;
  fit(right, half_width, shift_right, back_for_width);
  fit(up, half_height, shift_up, back_for_height);
  const double back = std::max(back_for_width, back_for_height);
  // Whole 64ths of a voxel survive the way through metres and back, so that the view does not depend on the
  // origin.
  const glm::dvec3 eye =
      glm::floor((centre + right * shift_right + up * shift_up - forward * back) * 64.0 + 0.5) / 64.0;
  return {frame.origin_m + eye * frame.voxel_size_m, kOverviewYawDeg, kOverviewPitchDeg};
}

}  // namespace karst::app
