// SPDX-License-Identifier: MIT
#include "terrain/basis/level_view.h"

#include <glm/geometric.hpp>

namespace karst::core {
namespace {

// Radius of what stands for a plane, voxels: beyond all that is drawn of one.
constexpr double kFlat = 1 << 24;

}  // namespace

double level_radius_m(const Basis& basis, double voxel_m) {
  return basis.kind == BasisKind::function ? kFlat * voxel_m : basis.radius_m;
}

LevelView make_level_view(const Basis& basis, glm::dvec3 eye_m, double voxel_m, double foot_m) {
  LevelShape shape;
  if (!level_shape(basis, shape)) {
    GridPlace at;
    const bool known = grid_of(basis, eye_m, at);
    const glm::dvec3 up = known ? up_at(basis, at) : glm::dvec3(0.0, 1.0, 0.0);
    const double radius_m = kFlat * voxel_m;
    shape.scale = glm::dmat3(1.0 / radius_m);
    shape.centre_m = eye_m - up * (radius_m + (known ? at.height_m : eye_m.y));
  }
  const glm::dvec3 q = shape.scale * (eye_m - shape.centre_m);
  const double length = glm::length(q);
  const double over = (length - 1.0) * (length + 1.0);
  const double gradient = glm::length(shape.scale * q);
  LevelView view;
  view.x = glm::vec4(glm::vec3(shape.scale[0] * voxel_m), static_cast<float>(q.x));
  view.y = glm::vec4(glm::vec3(shape.scale[1] * voxel_m), static_cast<float>(q.y));
  view.z = glm::vec4(glm::vec3(shape.scale[2] * voxel_m), static_cast<float>(q.z));
  const double height_m = gradient > 0 ? shape.sign * (length - 1.0) * length / gradient : 0.0;
  view.eye = {static_cast<float>(over), static_cast<float>(shape.sign), static_cast<float>(foot_m / voxel_m),
              static_cast<float>(height_m / voxel_m)};
  return view;
}

}  // namespace karst::core
