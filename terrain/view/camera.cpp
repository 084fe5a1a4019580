// SPDX-License-Identifier: MIT
// Rounding a camera to the lattice, and its matrices. All of it in double: a frame has one camera.
#include "terrain/view/camera.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "terrain/base/angles.h"
#include "terrain/view/projection.h"

namespace karst::core {
namespace {

constexpr double kPi = 3.14159265358979323846;
static_assert(std::int64_t{kStepsPerVoxel} << kFinestCameraFractionBits <= 1 << 24,
              "the fine part must be exact in float");

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

Status refuse(const char* what, const char* field) {
  return {StatusCode::invalid_argument, what, field};
}

// Columns: right, up and backward in world axes.
glm::dmat3 axes_of(const CameraSettings& s) {
  const SinCos yaw = sin_cos_deg(std::remainder(s.yaw_deg, 360.0));
  const SinCos pitch = sin_cos_deg(s.pitch_deg);
  const glm::dvec3 right{yaw.cos, 0.0, -yaw.sin};
  const glm::dvec3 up{yaw.sin * pitch.sin, pitch.cos, yaw.cos * pitch.sin};
  const glm::dvec3 back{yaw.sin * pitch.cos, -pitch.sin, yaw.cos * pitch.cos};
  const double roll_deg = std::remainder(s.roll_deg, 360.0);
  if (roll_deg == 0.0) return {right, up, back};
  const SinCos roll = sin_cos_deg(roll_deg);
  return {right * roll.cos - up * roll.sin, up * roll.cos + right * roll.sin, back};
}

glm::dmat4 perspective(const CameraSettings& s) {
  const double scale = 1.0 / std::tan(s.fov_y_deg * (kPi / 360.0));
  const double near = s.near_voxels;
  const double far = s.far_voxels;
  glm::dmat4 m(0.0);
  m[0][0] = scale / s.aspect;
  m[1][1] = scale;
  m[2][2] = -((far + near) / (far - near));
  m[2][3] = -1.0;
  m[3][2] = -2.0 * far * near / (far - near);
  if (s.reversed_depth) {
    m[2][2] = -m[2][2];
    m[3][2] = -m[3][2];
  }
  return m;
}

void set_place(glm::dvec3 position, int fraction_bits, Camera& camera) {
  const auto units_a_voxel = static_cast<double>(std::int64_t{kStepsPerVoxel} << fraction_bits);
  for (int axis = 0; axis < 3; ++axis) {
    const double units = std::floor(position[axis] * units_a_voxel + 0.5);  // below 2^44: exact
    const double voxel = std::floor(units / units_a_voxel);
    camera.voxel[axis] = static_cast<std::int32_t>(voxel);
    camera.fine[axis] = static_cast<float>((units - voxel * units_a_voxel) / (1 << fraction_bits));
  }
}

// The orthonormal matrix next to one that nearly is; false where it is not.
bool make_rotation(const glm::dmat3& given, glm::dmat3& made) {
  const glm::dmat3 rows = glm::transpose(given);
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b <= a; ++b) {
      const double wanted = a == b ? 1.0 : 0.0;
      if (!inside(glm::dot(rows[a], rows[b]), wanted - kRotationSlack, wanted + kRotationSlack)) return false;
    }
  }
  glm::dmat3 exact(0.0);
  exact[0] = glm::normalize(rows[0]);
  exact[1] = glm::normalize(rows[1] - exact[0] * glm::dot(exact[0], rows[1]));
  const glm::dvec3 third = glm::cross(exact[0], exact[1]);
  exact[2] = glm::dot(third, rows[2]) > 0.0 ? third : -third;
  made = glm::transpose(exact);
  return true;
}

// Makes w the distance in voxels, or 1, and moves view space so that a perspective's centre is its origin.
// centre: of the perspective in the view space given.
Status normalise_projection(glm::dmat4& m, glm::dvec3& centre) {
  const glm::dvec3 w(m[0][3], m[1][3], m[2][3]);
  const double length = glm::length(w);
  if (length == 0.0) {
    if (!(m[3][3] > 0.0)) return refuse("its w is nowhere above 0", "clip_from_view");
    m = m * (1.0 / m[3][3]);
    m[3][3] = 1.0;
    return {};
  }
  if (length != 1.0) m = m * (1.0 / length);
  const glm::dvec3 lost(m[3][0], m[3][1], m[3][3]);
  if (lost == glm::dvec3(0.0)) return {};
  // The centre is where x, y and w are 0.
  const glm::dmat3 rows(m[0][0], m[0][1], m[0][3], m[1][0], m[1][1], m[1][3], m[2][0], m[2][1], m[2][3]);
  centre = -(glm::inverse(rows) * lost);
  if (!finite(centre)) return refuse("not invertible", "clip_from_view");
  m[3] = {0.0, 0.0, m[3][2] + m[0][2] * centre.x + m[1][2] * centre.y + m[2][2] * centre.z, 0.0};
  return {};
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
  if (!inside(s.roll_deg, -1e6, 1e6)) return refuse("not within -1e6..1e6 degrees", "roll_deg");
  if (!inside(s.fov_y_deg, 1.0, 170.0)) return refuse("not within 1..170 degrees", "fov_y_deg");
  if (!inside(s.aspect, 1.0 / 64, 64.0)) return refuse("not within 1/64..64", "aspect");
  if (!inside(s.near_voxels, kLeastNear, kCameraReach))
    return refuse("not within 1/8192..2^20 voxels", "near_voxels");
  if (!inside(s.far_voxels, kLeastNear, kCameraReach))
    return refuse("not within 1/8192..2^20 voxels", "far_voxels");
  if (s.near_voxels >= s.far_voxels) return refuse("not beyond near_voxels", "far_voxels");

  set_place(s.position, kCameraFractionBits, camera);
  camera.view_from_world = glm::transpose(axes_of(s));
  camera.clip_from_view = perspective(s);
  camera.reversed_depth = s.reversed_depth;
  camera.parallel = false;
  camera.mirrored = false;
  camera.forward = -world_from_view(camera)[2];
  camera.near_voxels = s.near_voxels;
  camera.far_voxels = s.far_voxels;
  return {};
}

Status make_camera(const CameraMatrices& m, Camera& camera) {
  if (!inside_reach(m.position)) return refuse("not within 2^20 voxels of the world", "position");
  Camera made;
  if (!make_rotation(m.view_from_world, made.view_from_world)) {
    return refuse("not an orthonormal matrix", "view_from_world");
  }
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      if (!std::isfinite(m.clip_from_view[column][row])) return refuse("not finite", "clip_from_view");
    }
  }
  made.clip_from_view = m.clip_from_view;
  made.reversed_depth = m.reversed_depth;
  glm::dvec3 centre(0.0);
  if (const Status status = normalise_projection(made.clip_from_view, centre); !status.ok()) return status;
  const glm::dvec3 position = m.position + world_from_view(made) * centre;
  if (!inside_reach(position)) return refuse("its centre is not within 2^20 voxels of the world", "position");
  set_place(position, m.fraction_bits, made);
  if (const Status status = derive_view(made); !status.ok()) return status;
  camera = made;
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
  return glm::transpose(camera.view_from_world);
}

// Zeros are left out, so that they leave no trace: not even the sign of a zero.
glm::dvec3 clip_row(const Camera& camera, int r) {
  const glm::dmat3 axes = world_from_view(camera);
  glm::dvec3 row(0.0);
  bool empty = true;
  for (int k = 0; k < 3; ++k) {
    const double factor = camera.clip_from_view[k][r];
    if (factor == 0.0) continue;
    row = empty ? axes[k] * factor : row + axes[k] * factor;
    empty = false;
  }
  return row;
}

glm::mat4 clip_from_lattice(const Camera& camera) {
  glm::mat4 m(0.0f);
  for (int r = 0; r < 4; ++r) {
    // A step is 2^-13 voxel, which changes exponents only.
    const glm::dvec3 row = clip_row(camera, r) * (1.0 / kStepsPerVoxel);
    double moved = camera.clip_from_view[3][r];
    for (int c = 0; c < 3; ++c) {
      m[c][r] = static_cast<float>(row[c]);
      moved -= row[c] * static_cast<double>(camera.fine[c]);
    }
    m[3][r] = static_cast<float>(moved);
  }
  return m;
}

glm::dvec3 eye_lattice(const Camera& camera) {
  return glm::dvec3(camera.voxel) * static_cast<double>(kStepsPerVoxel) + glm::dvec3(camera.fine);
}

}  // namespace karst::core
