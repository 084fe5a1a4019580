// SPDX-License-Identifier: MIT
// The planes of a view, made in double, moved outwards by a margin, and rounded to float.
//
// The margin covers two roundings. With u = 2^-24, a box corner p (exact in float) and the eye c:
//  - classify: the normal's components are off by u/2 each, the products by u of themselves, three additions
//  by u
//    of a partial sum each, the offset by u/2 of itself: at most 5 u (|p|1 + |offset|), |.|1 being the sum of
//    absolute components.
//  - The GPU: a clip coordinate is a sum of four products, made with rounded coefficients and a rounded
//  position
//    relative to the eye: at most 6 u times the row's length times (|p|1 + |c|1). A plane is the sum or
//    difference of row w and another row; the error in steps is that of both rows over the length of their
//    sum: L 6 u (|p|1 + |c|1), L being the rows' lengths added up over the length of their sum. In a plain
//    perspective a side row is perpendicular to row w: L is at most sqrt(2). The near plane's rows are
//    parallel: L is 1. The far plane's are opposite and nearly cancel: L is far / near. In a parallel view
//    row w has no length, L is 1, and what is added to a row, at most |c|1 + |offset|, is off by u.
// 16 u (|p|1 + |c|1 + |offset|), times L where that is above sqrt(2), is more than both together. For an eye
// inside the world that is about 25 steps, 0.003 voxel, and at the default near and far 25 voxels of the far
// 1,024. A patch that is listed for it alone costs some vertices and changes no pixel.
//
// Rows that cancel wholly make no plane: a far plane at infinity culls nothing.
#include "terrain/view/frustum.h"

#include <cmath>

#include <glm/geometric.hpp>

namespace karst::core {
namespace {

constexpr double kMargin = 16.0 / (1 << 24);
constexpr double kPerpendicular = 1.4143;  // L of rows that are; sqrt(2), rounded up

// The plane on whose inner side row w plus sign times row r is above 0.
Plane make_plane(const Camera& camera, int r, double sign, glm::dvec3 eye) {
  const glm::dmat4& m = camera.clip_from_view;
  const glm::dvec3 w(m[0][3], m[1][3], m[2][3]);
  const glm::dvec3 row(m[0][r], m[1][r], m[2][r]);
  const glm::dvec3 sum = w + row * sign;
  const double length = glm::length(sum);
  const double added = m[3][3] + m[3][r] * sign;
  // Everything in view space is on the inner side (make_camera).
  if (length == 0.0) return {glm::vec3(0.0f), 1.0f};
  glm::dvec3 inward = clip_row(camera, 3) + clip_row(camera, r) * sign;
  if (sum.x == 0.0 && sum.y == 0.0) inward = world_from_view(camera)[2] * (sum.z < 0.0 ? -1.0 : 1.0);
  const glm::dvec3 normal = glm::normalize(inward);
  const double distance = added / length * kStepsPerVoxel;
  const double offset = distance - glm::dot(normal, eye);
  const double looseness = (glm::length(w) + glm::length(row)) / length;
  const double reach =
      3.0 * kBoxReach + std::abs(eye.x) + std::abs(eye.y) + std::abs(eye.z) + std::abs(offset);
  const double margin = kMargin * (looseness > kPerpendicular ? looseness : 1.0) * reach;
  return {glm::vec3(normal), static_cast<float>(offset + margin)};
}

}  // namespace

Frustum make_frustum(const Camera& camera) {
  const glm::dvec3 eye = eye_lattice(camera);
  const double near = camera.reversed_depth ? -1.0 : 1.0;
  return {{make_plane(camera, 2, near, eye), make_plane(camera, 0, 1.0, eye),
           make_plane(camera, 0, -1.0, eye), make_plane(camera, 1, 1.0, eye),
           make_plane(camera, 1, -1.0, eye), make_plane(camera, 2, -near, eye)}};
}

}  // namespace karst::core
