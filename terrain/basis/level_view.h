// SPDX-License-Identifier: MIT
// Up and height of what an eye sees on a curved basis, in float, as shaders compute them
// (gles_shaders/level.glsl repeats the formulas): LevelShape from the eye, in voxels.
#pragma once

#include <algorithm>
#include <cmath>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "terrain/basis/basis.h"

namespace karst::core {

struct LevelView {
  // Rows of scale, 1/voxels; w: q of the eye.
  glm::vec4 x{0.0f}, y{0.0f}, z{0.0f};
  // x: |q|^2 - 1 of the eye; y: sign; z: the height at which walls end, w: the eye's height, voxels.
  glm::vec4 eye{0.0f};
};

// Metres by which a height is a share of |q|; below 0 of what is level inside.
double level_radius_m(const Basis& basis, double voxel_m);
// voxel_m: metres of a voxel. Where no shape is known, level is a plane across up at the eye.
LevelView make_level_view(const Basis& basis, glm::dvec3 eye_m, double voxel_m, double foot_m);

// from_eye: voxels.
inline glm::vec3 level_step(const LevelView& view, glm::vec3 from_eye) {
  const auto row = [&](const glm::vec4& r) { return r.x * from_eye.x + r.y * from_eye.y + r.z * from_eye.z; };
  return {row(view.x), row(view.y), row(view.z)};
}
// The gradient of |q|, times |q|.
inline glm::vec3 level_gradient(const LevelView& view, glm::vec3 step) {
  return level_step(view, glm::vec3(view.x.w + step.x, view.y.w + step.y, view.z.w + step.z));
}
inline glm::vec3 level_up(const LevelView& view, glm::vec3 from_eye) {
  const glm::vec3 g = level_gradient(view, level_step(view, from_eye));
  const float length = std::sqrt(g.x * g.x + g.y * g.y + g.z * g.z);
  return {g.x / length * view.eye.y, g.y / length * view.eye.y, g.z / length * view.eye.y};
}
// Voxels above height 0.
inline float level_height(const LevelView& view, glm::vec3 from_eye) {
  const glm::vec3 s = level_step(view, from_eye);
  const float over = view.eye.x + 2.0f * (view.x.w * s.x + view.y.w * s.y + view.z.w * s.z) +
                     (s.x * s.x + s.y * s.y + s.z * s.z);
  const float q = std::sqrt(std::max(1.0f + over, 0.0f));
  const glm::vec3 g = level_gradient(view, s);
  const float length = std::sqrt(g.x * g.x + g.y * g.y + g.z * g.z);
  return view.eye.y * (over / (q + 1.0f)) * (q / length);
}

}  // namespace karst::core
