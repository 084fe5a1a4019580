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
//    sum. A side row is perpendicular to row w, so the lengths add up to at most sqrt(2) times that of the
//    sum: 9 u (|p|1 + |c|1). The near plane's rows are parallel: 6 u. The far plane's are opposite and nearly
//    cancel: far / near times 6 u.
// 16 u (|p|1 + |c|1 + |offset|), times far / near for the far plane, is more than both together. For an eye
// inside the world that is about 25 steps, 0.003 voxel, and at the default near and far 25 voxels of the far
// 1,024. A patch that is listed for it alone costs some vertices and changes no pixel.
#include "terrain/view/frustum.h"

#include <cmath>

#include <glm/geometric.hpp>

namespace karst::core {
namespace {

constexpr double kMargin = 16.0 / (1 << 24);

// inward: any length above 0. distance: how far the eye is on the plane's inner side, in lattice steps.
// looseness: how many times the error of a side plane the GPU's is.
Plane make_plane(glm::dvec3 inward, glm::dvec3 eye, double distance, double looseness) {
  const glm::dvec3 normal = glm::normalize(inward);
  const double offset = distance - glm::dot(normal, eye);
  const double reach =
      3.0 * kBoxReach + std::abs(eye.x) + std::abs(eye.y) + std::abs(eye.z) + std::abs(offset);
  return {glm::vec3(normal), static_cast<float>(offset + kMargin * looseness * reach)};
}

}  // namespace

Frustum make_frustum(const Camera& camera) {
  const glm::dmat3 axes = world_from_view(camera);
  const glm::dvec3 eye = eye_lattice(camera);
  const glm::dvec3 forward = -axes[2];
  const glm::dvec3 x = axes[0] * (projection_scale(camera) / camera.aspect);
  const glm::dvec3 y = axes[1] * projection_scale(camera);
  const double near = camera.near_voxels * kStepsPerVoxel;
  const double far = camera.far_voxels * kStepsPerVoxel;
  return {{make_plane(forward, eye, -near, 1.0), make_plane(forward + x, eye, 0.0, 1.0),
           make_plane(forward - x, eye, 0.0, 1.0), make_plane(forward + y, eye, 0.0, 1.0),
           make_plane(forward - y, eye, 0.0, 1.0), make_plane(-forward, eye, far, far / near)}};
}

}  // namespace karst::core
