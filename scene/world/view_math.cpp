// SPDX-License-Identifier: MIT
// Helpers of include/karst/renderer.h that fill in a ViewState.
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "karst/renderer.h"
#include "terrain/view/depth_ranges.h"

namespace karst {

bool look_at(ViewState& view, Vec3 target, Vec3 up) noexcept {
  const glm::dvec3 away(view.eye.x - target.x, view.eye.y - target.y, view.eye.z - target.z);
  const double distance = glm::length(away);
  if (!std::isfinite(distance) || !(distance > 0)) return false;
  const glm::dvec3 back = away / distance;
  const glm::dvec3 across = glm::cross(glm::dvec3(up.x, up.y, up.z), back);
  const double sine = glm::length(across);
  if (!std::isfinite(sine) || !(sine > 0)) return false;
  const glm::dvec3 right = across / sine;
  const glm::dvec3 rows[3] = {right, glm::cross(back, right), back};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) view.view_from_world[column * 3 + row] = rows[row][column];
  }
  return true;
}

void set_perspective(ViewState& view, double fov_y_deg, double near_m, double far_m) noexcept {
  constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180.0;
  const double scale = 1.0 / std::tan(fov_y_deg * (kRadiansPerDegree / 2));
  const double aspect = view.height_px == 0 ? 1.0 : double{view.width_px * 1.0} / view.height_px;
  const double sign = view.reversed_depth ? -1.0 : 1.0;
  for (double& entry : view.clip_from_view) entry = 0;
  view.clip_from_view[0] = scale / aspect;
  view.clip_from_view[5] = scale;
  view.clip_from_view[10] = -sign * (far_m + near_m) / (far_m - near_m);
  view.clip_from_view[11] = -1;
  view.clip_from_view[14] = -sign * 2 * far_m * near_m / (far_m - near_m);
}

std::uint32_t depth_ranges(const ViewState& view, DepthRange (&ranges)[2]) noexcept {
  glm::dmat4 clip;
  for (int n = 0; n < 16; ++n) clip[n / 4][n % 4] = view.clip_from_view[n];
  const core::DepthRanges inside = core::depth_ranges(clip, view.reversed_depth);
  ranges[0] = {inside.near, inside.far, 0, 1};
  if (inside.count == 1) return 1;
  ranges[0] = {inside.near_of(0), inside.far_of(0), 0.0f, 0.5f};
  ranges[1] = {inside.near_of(1), inside.far_of(1), 0.5f, 1.0f};
  return 2;
}

}  // namespace karst
