// SPDX-License-Identifier: MIT
#include "scene/world/placement.h"

#include <cmath>

#include <glm/matrix.hpp>

#include "terrain/base/angles.h"

namespace karst::core {
namespace {

Status refuse(const char* what, const char* field) {
  return {StatusCode::invalid_argument, what, field};
}

// East, up and south of a frame's axes, as columns.
bool sim_from_compass(Axes axes, glm::dmat3& out) {
  switch (axes) {
    case Axes::east_up_south:
      out = glm::dmat3(1.0);
      return true;
    case Axes::east_north_up:
      out = {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
      return true;
    case Axes::north_east_down:
      out = {{0, 1, 0}, {0, 0, -1}, {-1, 0, 0}};
      return true;
  }
  return false;
}

}  // namespace

Status PlacementFrame::create(const Placement& placement, const WorldFrame& frame, int fraction_bits) {
  glm::dmat3 axes(1.0);
  if (!sim_from_compass(placement.axes, axes)) return refuse("not one of the frames", "axes");
  const glm::dvec3 origin = to_glm(placement.origin);
  for (int n = 0; n < 3; ++n) {
    if (!(std::abs(origin[n]) <= 1e12)) return refuse("not within +-1e12 metres", "origin");
  }
  if (!(std::abs(placement.turn_deg) <= 360.0)) return refuse("not within -360..360 degrees", "turn_deg");
  const auto [s, c] = sin_cos_deg(placement.turn_deg);
  // The world's east, up and south among the simulator's compass points.
  const glm::dmat3 turned{{c, 0.0, s}, {0.0, 1.0, 0.0}, {-s, 0.0, c}};
  sim_from_world_ = axes * turned;
  world_from_sim_ = glm::transpose(sim_from_world_);
  origin_ = origin;
  frame_ = frame;
  fraction_bits_ = fraction_bits;
  return {};
}

Status PlacementFrame::make_camera(const karst::ViewState& view, Camera& camera) const {
  if (!std::isfinite(view.eye.x) || !std::isfinite(view.eye.y) || !std::isfinite(view.eye.z))
    return refuse("not a finite place", "eye");
  glm::dmat3 rotation(1.0);
  for (int n = 0; n < 9; ++n) rotation[n / 3][n % 3] = view.view_from_world[n];
  glm::dmat4 projection(1.0);
  // The eye's space is in voxels inside; scaling all of a clip position changes nothing.
  for (int n = 0; n < 16; ++n) {
    projection[n / 4][n % 4] = n < 12 ? view.clip_from_view[n] : view.clip_from_view[n] / frame_.voxel_size_m;
  }
  CameraMatrices matrices;
  matrices.fraction_bits = fraction_bits_;
  matrices.position = voxels(view.eye);
  matrices.view_from_world = rotation * sim_from_world_;
  matrices.clip_from_view = projection;
  matrices.reversed_depth = view.reversed_depth;
  return core::make_camera(matrices, camera);
}

}  // namespace karst::core
