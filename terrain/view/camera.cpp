// SPDX-License-Identifier: MIT
// Rounding a camera to the lattice, and its matrices. All of it in double: a frame has one camera.
#include "terrain/view/camera.h"

#include <cmath>

namespace karst::core {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr std::int64_t kFineUnits = std::int64_t{kStepsPerVoxel} << kCameraFractionBits;  // a voxel
static_assert(kFineUnits <= 1 << 24, "the fine part must be exact in float");

// False for NaN, because every comparison with it is.
constexpr bool inside(double value, double least, double most) {
  return value >= least && value <= most;
}

bool inside_reach(glm::dvec3 v) {
  return inside(v.x, -kCameraReach, kCameraReach) && inside(v.y, -kCameraReach, kCameraReach) &&
         inside(v.z, -kCameraReach, kCameraReach);
}

bool finite(glm::dvec3 v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// Sine and cosine of an angle within +-180 degrees, exact at the multiples of 90: views along an axis then
// have zeros in their matrices, not rounding residue.
struct SinCos {
  double sin, cos;
};
SinCos sin_cos_deg(double angle_deg) {
  const double quarter = std::nearbyint(angle_deg / 90.0);
  const double rest = (angle_deg - quarter * 90.0) * (kPi / 180.0);
  const double s = std::sin(rest);
  const double c = std::cos(rest);
  switch (static_cast<int>(quarter) & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

Status refuse(const char* what, const char* field) {
  return {StatusCode::invalid_argument, what, field};
}

}  // namespace

Status voxels_from_metres(const WorldFrame& frame, glm::dvec3 position_m, glm::dvec3& voxels) {
  if (!finite(frame.origin_m)) return refuse("not a finite number", "origin_m");
  if (!std::isfinite(frame.voxel_size_m) || !(frame.voxel_size_m > 0.0)) {
    return refuse("must be finite and above 0", "voxel_size_m");
  }
  if (!finite(position_m)) return refuse("not a finite number", "position");
  const glm::dvec3 result = (position_m - frame.origin_m) / frame.voxel_size_m;
  if (!inside_reach(result)) return refuse("more than 2^20 voxels from the world", "position");
  voxels = result;
  return {};
}

Status make_camera(const CameraSettings& s, Camera& camera) {
  if (!inside_reach(s.position)) return refuse("not within 2^20 voxels of the world", "position");
  if (!inside(s.yaw_deg, -1e6, 1e6)) return refuse("not within -1e6..1e6 degrees", "yaw_deg");
  if (!inside(s.pitch_deg, -90.0, 90.0)) return refuse("not within -90..90 degrees", "pitch_deg");
  if (!inside(s.fov_y_deg, 1.0, 170.0)) return refuse("not within 1..170 degrees", "fov_y_deg");
  if (!inside(s.aspect, 1.0 / 64, 64.0)) return refuse("not within 1/64..64", "aspect");
  if (!inside(s.near_voxels, kLeastNear, kCameraReach))
    return refuse("not within 1/8192..2^20 voxels", "near_voxels");
  if (!inside(s.far_voxels, kLeastNear, kCameraReach))
    return refuse("not within 1/8192..2^20 voxels", "far_voxels");
  if (s.near_voxels >= s.far_voxels) return refuse("not beyond near_voxels", "far_voxels");

  for (int axis = 0; axis < 3; ++axis) {
    const double units =
        std::floor(s.position[axis] * static_cast<double>(kFineUnits) + 0.5);  // below 2^38: exact
    const double voxel = std::floor(units / static_cast<double>(kFineUnits));
    camera.voxel[axis] = static_cast<std::int32_t>(voxel);
    camera.fine[axis] =
        static_cast<float>((units - voxel * static_cast<double>(kFineUnits)) / (1 << kCameraFractionBits));
  }
  camera.yaw_deg = std::remainder(s.yaw_deg, 360.0);
  camera.pitch_deg = s.pitch_deg;
  camera.fov_y_deg = s.fov_y_deg;
  camera.aspect = s.aspect;
  camera.near_voxels = s.near_voxels;
  camera.far_voxels = s.far_voxels;
  return {};
}

Status look_at(glm::dvec3 eye, glm::dvec3 target, double& yaw_deg, double& pitch_deg) {
  const glm::dvec3 d = target - eye;
  const double across = std::hypot(d.x, d.z);
  const double length = std::hypot(across, d.y);
  if (!std::isfinite(length) || length == 0.0) return refuse("no direction from the eye to it", "target");
  yaw_deg = across == 0.0 ? 0.0 : std::atan2(-d.x, -d.z) * (180.0 / kPi);
  pitch_deg = std::atan2(d.y, across) * (180.0 / kPi);
  return {};
}

glm::dmat3 world_from_view(const Camera& camera) {
  const SinCos yaw = sin_cos_deg(camera.yaw_deg);
  const SinCos pitch = sin_cos_deg(camera.pitch_deg);
  const glm::dvec3 right{yaw.cos, 0.0, -yaw.sin};
  const glm::dvec3 up{yaw.sin * pitch.sin, pitch.cos, yaw.cos * pitch.sin};
  const glm::dvec3 back{yaw.sin * pitch.cos, -pitch.sin, yaw.cos * pitch.cos};
  return {right, up, back};
}

glm::mat4 clip_from_lattice(const Camera& camera) {
  const glm::dmat3 axes = world_from_view(camera);
  const double scale = projection_scale(camera);
  const double near = camera.near_voxels;
  const double far = camera.far_voxels;
  // A step is 2^-13 voxel; taking that out of every row at once changes exponents only.
  const double voxels_per_step = 1.0 / kStepsPerVoxel;
  const glm::dvec3 forward = -axes[2] * voxels_per_step;
  const glm::dvec3 x = axes[0] * (scale / camera.aspect * voxels_per_step);
  const glm::dvec3 y = axes[1] * (scale * voxels_per_step);
  const glm::dvec3 z = forward * ((far + near) / (far - near));
  const glm::dvec3 rows[4] = {x, y, z, forward};
  const double depth_offset[4] = {0.0, 0.0, -2.0 * far * near / (far - near), 0.0};

  glm::mat4 m(0.0f);
  for (int r = 0; r < 4; ++r) {
    double moved = depth_offset[r];
    for (int c = 0; c < 3; ++c) {
      m[c][r] = static_cast<float>(rows[r][c]);
      moved -= rows[r][c] * static_cast<double>(camera.fine[c]);
    }
    m[3][r] = static_cast<float>(moved);
  }
  return m;
}

glm::dvec3 eye_lattice(const Camera& camera) {
  return glm::dvec3(camera.voxel) * static_cast<double>(kStepsPerVoxel) + glm::dvec3(camera.fine);
}

double projection_scale(const Camera& camera) {
  return 1.0 / std::tan(camera.fov_y_deg * (kPi / 360.0));
}

}  // namespace karst::core
