// SPDX-License-Identifier: MIT
// Fitting in double, rounded to float once at the end.
#include "terrain/shadow/cascades.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "terrain/base/check.h"
#include "terrain/lod/morph.h"

namespace karst::core {
namespace {

// The share of the logarithmic split. At 1 the smallest box would be a few voxels and at 0 the largest ones
// alike; 0.8 gives the first of two boxes about a fifth of the reach.
constexpr double kLogarithmic = 0.8;

// Boxes move in this many steps over their side. The eye is within half a step of the middle on each axis.
constexpr int kSteps = 8;

// Texels at the sides of a box around the whole world: one more than the border, and one for rounding.
constexpr int kWorldBorder = kCascadeBorder + 2;

glm::dvec3 corner(const LatticeBox& box, int n) {
  const glm::ivec3 p((n & 1) != 0 ? box.max.x : box.min.x, (n & 2) != 0 ? box.max.y : box.min.y,
                     (n & 4) != 0 ? box.max.z : box.min.z);
  return glm::dvec3(p) / static_cast<double>(kStepsPerVoxel);
}

struct WorldExtent {
  glm::dvec3 low{1e300};
  glm::dvec3 high{-1e300};
};

glm::dvec3 in_light(const LightSpace& light, glm::dvec3 p) {
  return {glm::dot(light.x, p), glm::dot(light.y, p), glm::dot(light.z, p)};
}

double snap(double value, double step) {
  return std::floor(value / step + 0.5) * step;
}

double split(int n, int count, double nearest, double reach) {
  const double part = static_cast<double>(n) / count;
  return kLogarithmic * nearest * std::pow(reach / nearest, part) +
         (1 - kLogarithmic) * (nearest + (reach - nearest) * part);
}

// The four sides, two of them twice: a frustum has six planes. margin: steps that they are moved outwards.
Frustum sides(const LightSpace& light, const Cascade& cascade, double margin) {
  const auto plane = [&](glm::dvec3 inward, double at) {
    return Plane{glm::vec3(inward), static_cast<float>(margin - at * kStepsPerVoxel)};
  };
  const Plane left = plane(light.x, cascade.low.x);
  const Plane right = plane(-light.x, -(cascade.low.x + cascade.side));
  const Plane bottom = plane(light.y, cascade.low.y);
  const Plane top = plane(-light.y, -(cascade.low.y + cascade.side));
  return {{left, left, right, bottom, top, right}};
}

glm::mat4 make_matrix(const LightSpace& light, const Cascade& cascade) {
  const glm::dvec3 origin(cascade.eye.voxel);
  const double scale = 2.0 / cascade.side;
  const double depth = -2.0 / (light.near_z - light.far_z);
  const glm::dvec3 rows[3] = {light.x * scale, light.y * scale, light.z * depth};
  const double offsets[3] = {-scale * cascade.low.x - 1, -scale * cascade.low.y - 1,
                             -depth * light.near_z - 1};
  glm::mat4 m(0.0f);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) m[c][r] = static_cast<float>(rows[r][c] / kStepsPerVoxel);
    m[3][r] = static_cast<float>(glm::dot(rows[r], origin) + offsets[r]);
  }
  m[3][3] = 1.0f;
  return m;
}

// around: in light space, voxels.
Camera camera_at(const LightSpace& light, glm::dvec3 around) {
  CameraSettings settings;
  settings.position = light.x * around.x + light.y * around.y + light.z * around.z;
  settings.position = glm::clamp(settings.position, -kCameraReach, kCameraReach);
  Camera camera;
  static_cast<void>(make_camera(settings, camera));  // within its ranges
  return camera;
}

}  // namespace

Status CascadeSettings::validate() const {
  const auto refuse = [](const char* what, const char* field) {
    return Status{StatusCode::invalid_argument, what, field};
  };
  if (count < 0 || count > kMostCascades) return refuse("not within 0..3", "count");
  if (size < kLeastCascadeSize || size > kMostCascadeSize || size % kCascadeSizeStep != 0) {
    return refuse("not a multiple of 16 within 512..2048 texels", "size");
  }
  if (!(reach_voxels >= 4 && reach_voxels <= kCameraReach)) {
    return refuse("not within 4..2^20 voxels", "reach_voxels");
  }
  if (!(nearest_voxels > 0 && nearest_voxels <= reach_voxels / 4))
    return refuse("not above 0 and at most a quarter of reach_voxels", "nearest_voxels");
  return {};
}

Status FitCascades::validate() const {
  if (const Status status = settings.validate(); !status.ok()) return status;
  const auto refuse = [](const char* what, const char* field) {
    return Status{StatusCode::invalid_argument, what, field};
  };
  if (camera == nullptr) return refuse("missing", "camera");
  if (!(std::abs(glm::dot(to_sun, to_sun) - 1) < 1e-6)) return refuse("not of unit length", "to_sun");
  for (int axis = 0; axis < 3; ++axis) {
    if (world.min[axis] > world.max[axis]) return refuse("empty", "world");
  }
  if (light == nullptr) return refuse("missing", "light");
  if (cascades.size() < static_cast<std::size_t>(settings.count)) return refuse("too short", "cascades");
  return {};
}

void FitCascades::run() const {
  KARST_ASSERT(validate().ok());
  light->z = to_sun;
  // Right of the sun along the horizon; a sun in the zenith has no horizon.
  const glm::dvec3 up = std::abs(to_sun.y) < 0.9999 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
  light->x = glm::normalize(glm::cross(up, to_sun));
  light->y = glm::cross(light->z, light->x);
  WorldExtent extent;
  for (int n = 0; n < 8; ++n) {
    const glm::dvec3 p = in_light(*light, corner(world, n));
    extent.low = glm::min(extent.low, p);
    extent.high = glm::max(extent.high, p);
  }
  // A hundredth of a voxel, so that nothing is cut off at either end.
  light->near_z = extent.high.z + 0.01;
  light->far_z = extent.low.z - 0.01;

  const glm::dvec3 eye = in_light(*light, eye_lattice(*camera) / static_cast<double>(kStepsPerVoxel));
  const double across = std::max({extent.high.x - extent.low.x, extent.high.y - extent.low.y, 1.0});
  const double reach = std::min(settings.reach_voxels, std::max(2.0 * settings.nearest_voxels, across));
  for (int n = 0; n < settings.count; ++n) {
    Cascade& cascade = cascades[static_cast<std::size_t>(n)];
    const double radius = split(n + 1, settings.count, settings.nearest_voxels, reach);
    cascade.side = 2 * radius * kSteps / (kSteps - 1);
    double step = cascade.side / kSteps;
    glm::dvec2 middle(snap(eye.x, step), snap(eye.y, step));
    const glm::dvec3 around(middle, snap(eye.z, step));
    const double world_side = across * settings.size / (settings.size - 2 * kWorldBorder);
    const bool whole_world = n + 1 == settings.count && world_side <= cascade.side;
    if (whole_world) cascade.side = world_side;
    cascade.texel = cascade.side / settings.size;
    if (whole_world) {
      middle = {snap(0.5 * (extent.low.x + extent.high.x), cascade.texel),
                snap(0.5 * (extent.low.y + extent.high.y), cascade.texel)};
    }
    cascade.low = middle - 0.5 * cascade.side;
    cascade.eye = camera_at(*light, around);
    cascade.least_cos2 = camera->parallel ? -kParallelDistance : 1.0f;
    // A texel for the filter; and more than classify() and the GPU round away.
    const double texel = cascade.texel * kStepsPerVoxel;
    const double rounding = 0.01 * kStepsPerVoxel;
    cascade.frustum = sides(*light, cascade, texel + rounding);
    cascade.inner = sides(*light, cascade, -(kCascadeBorder + 1) * texel - rounding);
    cascade.clip_from_lattice = make_matrix(*light, cascade);
  }
}

}  // namespace karst::core
