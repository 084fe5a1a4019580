// SPDX-License-Identifier: MIT
// All of it in view space and in double; terms that are 0 in a plain perspective leave no trace.
#include "terrain/view/projection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace karst::core {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

// Determinants and products of vectors below this share of their lengths can't be told from 0.
constexpr double kFlat = 1e-9;

// The most that rounding makes square pixels differ from squares.
constexpr double kSquare = 1.0 + 1e-9;

glm::dvec3 view_row(const Camera& camera, int r) {
  const glm::dmat4& m = camera.clip_from_view;
  return {m[0][r], m[1][r], m[2][r]};
}

glm::dvec3 world_of(const Camera& camera, glm::dvec3 v) {
  const glm::dmat3 axes = world_from_view(camera);
  glm::dvec3 sum(0.0);
  bool empty = true;
  for (int k = 0; k < 3; ++k) {
    if (v[k] == 0.0) continue;
    sum = empty ? axes[k] * v[k] : sum + axes[k] * v[k];
    empty = false;
  }
  return sum;
}

// forward in view space. Perspective: w is of unit length. Parallel: along the direction in which neither x
// nor y changes.
glm::dvec3 view_forward(const Camera& camera) {
  if (!camera.parallel) return view_row(camera, 3);
  const glm::dvec3 along = glm::normalize(glm::cross(view_row(camera, 0), view_row(camera, 1)));
  const bool grows = glm::dot(view_row(camera, 2), along) > 0.0;
  return grows != camera.reversed_depth ? along : -along;
}

ViewRays rays_in_view(const Camera& camera) {
  const glm::dvec3 x = view_row(camera, 0);
  const glm::dvec3 y = view_row(camera, 1);
  const glm::dvec3 f = view_forward(camera);
  const double determinant = glm::dot(x, glm::cross(y, f));
  ViewRays rays;
  rays.right = glm::cross(y, f) / determinant;
  rays.up = glm::cross(f, x) / determinant;
  rays.middle = glm::cross(x, y) / determinant;
  rays.start = -(rays.right * camera.clip_from_view[3][0] + rays.up * camera.clip_from_view[3][1]);
  return rays;
}

constexpr std::array<glm::dvec2, 4> kCorners = {{{-1, -1}, {1, -1}, {-1, 1}, {1, 1}}};

// Where the ray through a corner crosses the plane on which depth is `ndc`: distance along forward. Infinite
// where it is not in front of a perspective's eye.
double crossing(const Camera& camera, const ViewRays& rays, glm::dvec2 corner, double ndc) {
  const glm::dvec3 z = view_row(camera, 2);
  const double at_eye = camera.clip_from_view[3][2];
  const glm::dvec3 aside = rays.right * corner.x + rays.up * corner.y;
  if (camera.parallel) {
    return (ndc - at_eye - glm::dot(z, rays.start + aside)) / glm::dot(z, rays.middle);
  }
  // z / w is grows + at_eye / depth.
  const double grows = glm::dot(z, rays.middle + aside);
  const double depth = at_eye / (ndc - grows);
  return depth > 0.0 && std::isfinite(depth) ? depth : kInfinite;
}

double nearest_ndc(const Camera& camera) {
  return camera.reversed_depth ? 1.0 : -1.0;
}

double reach(const Camera& camera, double ndc) {
  const ViewRays rays = rays_in_view(camera);
  double most = 0.0;
  for (const glm::dvec2 corner : kCorners) {
    const double depth = crossing(camera, rays, corner, ndc);
    const glm::dvec3 aside = rays.right * corner.x + rays.up * corner.y;
    const glm::dvec3 place =
        camera.parallel ? rays.start + aside + rays.middle * depth : (rays.middle + aside) * depth;
    const double distance = glm::length(place);
    if (!(distance <= most)) most = std::isfinite(distance) ? distance : kInfinite;
  }
  return most;
}

// What a row changes by across forward.
glm::dvec3 across(const Camera& camera, int r, glm::dvec3 forward) {
  const glm::dvec3 row = view_row(camera, r);
  return row - forward * glm::dot(row, forward);
}

// cos^2 of the angle between forward and a ray.
double least_cos2(const ViewRays& rays, glm::dvec3 forward) {
  double most_tan2 = 0.0;
  for (const glm::dvec2 corner : kCorners) {
    glm::dvec3 aside = rays.middle + rays.right * corner.x + rays.up * corner.y;
    aside -= forward * glm::dot(aside, forward);
    most_tan2 = std::max(most_tan2, glm::dot(aside, aside));
  }
  return 1.0 / (1.0 + most_tan2);
}

// The singular values of the matrix with these two rows.
PixelScale singular_values(glm::dvec3 a, glm::dvec3 b) {
  const double aa = glm::length(a);
  const double bb = glm::length(b);
  const double ab = glm::dot(a, b);
  if (std::abs(ab) <= 1e-12 * aa * bb) {
    if (aa <= bb * kSquare && bb <= aa * kSquare) return {bb, bb};
    return {std::max(aa, bb), std::min(aa, bb)};
  }
  const double sum = aa * aa + bb * bb;
  const double difference = aa * aa - bb * bb;
  const double most = std::sqrt(0.5 * (sum + std::sqrt(difference * difference + 4.0 * ab * ab)));
  return {most, glm::length(glm::cross(a, b)) / most};
}

Status refuse(const char* what, const char* field) {
  return {StatusCode::invalid_argument, what, field};
}

// Whether the projection maps neither space nor the picture to something flat.
bool is_solid(const Camera& camera) {
  const glm::dvec3 x = view_row(camera, 0);
  const glm::dvec3 y = view_row(camera, 1);
  const glm::dvec3 z = view_row(camera, 2);
  const glm::dvec3 normal = glm::cross(x, y);
  const double size = glm::length(x) * glm::length(y);
  if (!(glm::length(normal) > kFlat * size)) return false;
  const glm::dvec3 along = camera.parallel ? z : view_row(camera, 3);
  return std::abs(glm::dot(normal, along)) > kFlat * size * glm::length(along);
}

}  // namespace

ViewRays view_rays(const Camera& camera) {
  const ViewRays v = rays_in_view(camera);
  return {world_of(camera, v.right), world_of(camera, v.up), world_of(camera, v.middle),
          world_of(camera, v.start)};
}

double corner_cos2(const Camera& camera) {
  return camera.parallel ? 1.0 : least_cos2(rays_in_view(camera), view_forward(camera));
}

PixelScale pixel_scale(const Camera& camera, int width_px, int height_px) {
  const glm::dvec3 f = view_forward(camera);
  return singular_values(across(camera, 0, f) * (0.5 * width_px), across(camera, 1, f) * (0.5 * height_px));
}

double vertical_scale(const Camera& camera) {
  return glm::length(across(camera, 1, view_forward(camera)));
}

double near_reach(const Camera& camera) {
  return reach(camera, nearest_ndc(camera));
}

double far_reach(const Camera& camera) {
  return reach(camera, -nearest_ndc(camera));
}

double depth_near(const Camera& camera) {
  return std::min(camera.near_voxels, 0.5 * std::abs(camera.clip_from_view[3][2]));
}

Status derive_view(Camera& camera) {
  camera.parallel = view_row(camera, 3) == glm::dvec3(0.0);
  if (!is_solid(camera)) return refuse("not invertible", "clip_from_view");
  const glm::dvec3 f = view_forward(camera);
  const ViewRays rays = rays_in_view(camera);
  const PixelScale scale = singular_values(across(camera, 0, f), across(camera, 1, f));
  if (!(scale.most <= kNarrowestView)) return refuse("narrower than 2^-20 of its distance", "clip_from_view");
  if (!camera.parallel) {
    if (!(least_cos2(rays, f) >= 1.0 / (1.0 + kWidestCorner * kWidestCorner))) {
      return refuse("a corner is more than 1,024 times its distance off the axis", "clip_from_view");
    }
    const double at_eye = camera.clip_from_view[3][2];
    if (at_eye == 0.0) return refuse("depth does not change with distance", "clip_from_view");
    if ((at_eye > 0.0) != camera.reversed_depth) return refuse("depth runs the other way", "reversed_depth");
  }
  camera.near_voxels = kInfinite;
  camera.far_voxels = -kInfinite;
  for (const glm::dvec2 corner : kCorners) {
    const double near = crossing(camera, rays, corner, nearest_ndc(camera));
    const double far = crossing(camera, rays, corner, -nearest_ndc(camera));
    camera.near_voxels = std::min(camera.near_voxels, near);
    camera.far_voxels = std::max(camera.far_voxels, far);
  }
  if (!std::isfinite(camera.near_voxels)) return refuse("nothing is beyond the near plane", "clip_from_view");
  if (!camera.parallel && camera.near_voxels < kLeastMatrixNear) {
    return refuse("the near plane is nearer than 2^-24 voxel", "clip_from_view");
  }
  camera.forward = glm::normalize(world_of(camera, f));
  const double turned = glm::dot(view_row(camera, 0), glm::cross(view_row(camera, 1), f));
  camera.mirrored = (turned > 0.0) != (glm::determinant(camera.view_from_world) < 0.0);
  return {};
}

}  // namespace karst::core
