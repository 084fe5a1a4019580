// SPDX-License-Identifier: MIT
#include "app/stage/camera_view.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>

#include "app/motion/angles.h"

namespace karst::app {
namespace {

constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180.0;
// Farthest that a camera may be from the octree's corner on each axis, voxels.
constexpr double kReach = 1 << 20;

// The overview stands above the south-east corner and looks north-west: the two sides of the world that meet
// there then run along the borders of a wide picture, and the land fills it. Its height is this part of the
// ground's diagonal above the highest point, and the opposite corner is seen at this part of the picture's
// height above its centre.
constexpr double kOverviewHeight = 0.09;
constexpr double kOverviewYawDeg = 45.0;
constexpr double kOverviewHorizon = 0.31;
// Of a planet: radii from its centre, in the frame's axes.
const glm::dvec3 kPlanetView(0.9, 1.6, 3.1);

// Near planes within the world's box: this, or where surfaces are nearer, a half, a quarter, ... of it. No
// nearer than kLeastNear_m: at an arm's length from rock nothing is cut.
constexpr double kNearest = 1.0 / 32;    // voxels
constexpr double kLeastNear_m = 0.0625;  // or kNearest, where that is less
// Of the way to the nearest surface that the near plane's corners may go: what is drawn strays from what is
// asked for by the picture's error.
constexpr double kPartOfWay = 0.8;

glm::dvec3 vec(Vec3 v) {
  return {v.x, v.y, v.z};
}

void set_rotation(double yaw_deg, double pitch_deg, const LocalAxes* axes, ViewState& view) {
  const auto [sin_yaw, cos_yaw] = sin_cos_deg(yaw_deg);
  const auto [sin_pitch, cos_pitch] = sin_cos_deg(pitch_deg);
  const double rows[3][3] = {{cos_yaw, 0.0, -sin_yaw},
                             {sin_yaw * sin_pitch, cos_pitch, cos_yaw * sin_pitch},
                             {sin_yaw * cos_pitch, -sin_pitch, cos_yaw * cos_pitch}};
  for (int row = 0; row < 3; ++row) {
    glm::dvec3 in_world(rows[row][0], rows[row][1], rows[row][2]);
    if (axes != nullptr)
      in_world = vec(axes->east) * in_world.x + vec(axes->up) * in_world.y - vec(axes->north) * in_world.z;
    for (int column = 0; column < 3; ++column) view.view_from_world[column * 3 + row] = in_world[column];
  }
}

Status refuse(const char* what, const char* field) {
  return {StatusCode::invalid_argument, what, field};
}

}  // namespace

void turn_view(int quarter_turns, ViewState& view) {
  double* const m = view.clip_from_view;
  for (int n = 0; n < (quarter_turns & 3); ++n) {
    for (int column = 0; column < 4; ++column) {
      const double x = m[column * 4];
      m[column * 4] = -m[column * 4 + 1];
      m[column * 4 + 1] = x;
    }
  }
}

Status check_place(const CameraPlace& place, const WorldInfo& world) {
  const glm::dvec3 position = (place.position_m - vec(world.origin_m)) / double{world.voxel_size_m};
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(place.position_m[axis])) return refuse("not a finite number", "position");
    if (!(std::abs(position[axis]) <= kReach))
      return refuse("more than 2^20 voxels from the world", "position");
  }
  if (!(std::abs(place.yaw_deg) <= 1e6)) return refuse("not within -1e6..1e6 degrees", "yaw_deg");
  if (!(std::abs(place.pitch_deg) <= 90)) return refuse("not within -90..90 degrees", "pitch_deg");
  return {};
}

Status place_view(const CameraPlace& place, const WorldInfo& world, const LocalAxes& axes,
                  const PictureShape& shape, double clearance_m, ViewState& view) {
  if (const Status status = check_place(place, world); !status.ok()) return status;
  const double size = world.voxel_size_m;
  const bool on_its_side = (shape.quarter_turns & 1) != 0;
  const int upright_width = on_its_side ? shape.height : shape.width;
  const int upright_height = on_its_side ? shape.width : shape.height;
  const glm::dvec3 position = (place.position_m - vec(world.origin_m)) / size;
  const glm::dvec3 low = (vec(world.low_m) - vec(world.origin_m)) / size;
  const glm::dvec3 high = (vec(world.high_m) - vec(world.origin_m)) / size;
  const glm::dvec3 outside = glm::max(glm::max(low - position, position - high), glm::dvec3(0.0));
  double farthest = 0.0;
  for (int n = 0; n < 8; ++n) {
    const glm::dvec3 corner((n & 1) != 0 ? high.x : low.x, (n & 2) != 0 ? high.y : low.y,
                            (n & 4) != 0 ? high.z : low.z);
    farthest = std::max(farthest, glm::length(corner - position));
  }
  // A depth buffer of whole numbers has steps that grow with far / near: near is taken as far as the view
  // allows.
  const double up = std::tan(0.5 * shape.fov_y_deg * kRadiansPerDegree);
  const double across = up * upright_width / upright_height;
  const double part = kPartOfWay / std::sqrt(1 + up * up + across * across);
  double near = kNearest;
  while (near * size >= 2 * kLeastNear_m && near * size > part * clearance_m) near *= 0.5;
  near = std::max(near, part * glm::length(outside));
  const double far = std::min(std::max(farthest * 1.01, near * 2.0), kReach);
  near = std::min(near, far * 0.5);

  view.eye = {place.position_m.x, place.position_m.y, place.position_m.z};
  set_rotation(place.yaw_deg, place.pitch_deg, world.basis == Basis::plane ? nullptr : &axes, view);
  view.reversed_depth = shape.reversed_depth;
  view.width_px = static_cast<std::uint32_t>(upright_width);
  view.height_px = static_cast<std::uint32_t>(upright_height);
  set_perspective(view, shape.fov_y_deg, near * size, far * size);
  turn_view(shape.quarter_turns, view);
  view.width_px = static_cast<std::uint32_t>(shape.width);
  view.height_px = static_cast<std::uint32_t>(shape.height);
  return {};
}

ShownBox shown_box(const WorldInfo& world) {
  ShownBox box{world.low_m, world.high_m};
  // An elevation model is all shown, whatever caves it has.
  if (world.regions != 1 || world.epsg != 0 || world.is_geodetic || world.is_projected) return box;
  // The surface ends at the middle of the outermost voxels; the topmost one is air.
  const double size = world.voxel_size_m;
  box.low_m = {world.origin_m.x + 0.5 * size, std::max(world.origin_m.y, world.low_m.y),
               world.origin_m.z + 0.5 * size};
  box.high_m = {world.origin_m.x + (world.extent[0] - 0.5) * size,
                std::min(world.origin_m.y + (world.extent[1] - 1) * size, world.high_m.y),
                world.origin_m.z + (world.extent[2] - 0.5) * size};
  return box;
}

CameraPlace overview(const WorldInfo& world, double fov_y_deg) {
  const glm::dvec3 origin = vec(world.origin_m);
  if (world.basis == Basis::cube) {
    // All of it, over Africa and Europe.
    CameraPlace place;
    place.position_m = world.radius_m * kPlanetView;
    place.pitch_deg = -90;
    return place;
  }
  if (world.basis == Basis::cylinder) {
    // Along it: from above its south end, or from inside it there.
    CameraPlace place;
    const bool inside = world.radius_m < 0;
    const double radius_m = std::abs(world.radius_m);
    place.position_m = {0.0, inside ? 0.6 * radius_m : 1.5 * radius_m, vec(world.high_m).z};
    if (inside) place.position_m.z -= 0.1 * (world.high_m.z - world.low_m.z);
    place.pitch_deg = inside ? -5 : -35;
    return place;
  }
  const ShownBox box = shown_box(world);
  const glm::dvec3 low = (vec(box.low_m) - origin) / world.voxel_size_m;
  const glm::dvec3 high = (vec(box.high_m) - origin) / world.voxel_size_m;
  const double diagonal = std::hypot(high.x - low.x, high.z - low.z);
  // Whole 64ths of a voxel survive the way through metres and back, so that the view does not depend on the
  // origin.
  const glm::dvec3 eye =
      glm::floor(glm::dvec3(high.x, high.y + kOverviewHeight * diagonal, high.z) * 64.0 + 0.5) / 64.0;
  const double down_deg = std::atan2(eye.y - 0.5 * (low.y + high.y), diagonal) / kRadiansPerDegree;
  const double pitch_deg = -std::min(down_deg + kOverviewHorizon * fov_y_deg, 89.0);
  CameraPlace place;
  place.position_m = origin + eye * world.voxel_size_m;
  place.yaw_deg = kOverviewYawDeg;
  place.pitch_deg = pitch_deg;
  return place;
}

}  // namespace karst::app
