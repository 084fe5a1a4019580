// SPDX-License-Identifier: MIT
// Where the brush is: under the pointer or the picture's middle, on what its stroke is drawn on.
#pragma once

#include <optional>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "app/editor/brush.h"
#include "karst/query.h"
#include "karst/renderer.h"
#include "karst/world.h"

namespace karst::app {

// A way from the eye, in the world's own metres.
struct EyeRay {
  glm::dvec3 from{0}, along{0, 0, -1};  // unit length
};
// pointer: 0..1 of the upright picture from its top left; quarter_turns as PictureShape has them.
EyeRay eye_ray(const ViewState& view, int quarter_turns, const glm::dvec2& pointer);

struct Aimed {
  bool found = false;
  glm::dvec3 surface{0};       // what the pointer is at, or the place of the stroke's plane
  glm::dvec3 normal{0, 1, 0};  // there, unit length
  glm::dvec3 place{0};         // the brush's middle: with the offset; of voxels, the voxel's
  double voxel_side_m = 0;     // of HandShape::voxel
};

class Aim {
 public:
  // Both outlive this object.
  Aim(const World& world, Query& query);

  // Where the brush would be, or is, for a picture of this view.
  Aimed at(const Brush& brush, const ViewState& view, int quarter_turns, const glm::dvec2& pointer);

  // From here on the brush stays on what it is drawn on, as at() had it last. False: it was nowhere.
  bool begin_stroke(const Brush& brush);
  void end_stroke() { stroke_.reset(); }
  // How far a place is from the way that at() looked along last.
  double apart_m(const glm::dvec3& place) const;
  const glm::dvec3& eye() const { return last_ray_.from; }
  // Of the stroke: the plane that flatten and level make.
  glm::dvec3 plane_up() const { return stroke_ ? stroke_->flat_up : glm::dvec3(0, 1, 0); }

 private:
  struct Stroke {
    DrawOn draw_on = DrawOn::surface;
    glm::dvec3 place, normal;  // of the plane
    glm::dvec3 flat, flat_up;  // of flatten and level
    ViewState view;            // that the old surface was seen in
    int turns = 0;
  };
  static constexpr int kOldWidth = 96, kOldHeight = 54;  // rays that the old surface is known by

  Hit hit(const EyeRay& ray) const;
  void keep_old_surface(const ViewState& view, int quarter_turns);
  bool on_old_surface(const EyeRay& ray, glm::dvec3& place, glm::dvec3& normal) const;
  bool on_plane(const EyeRay& ray, glm::dvec3& place) const;
  bool find_voxel(const Brush& brush, const EyeRay& ray, Aimed& aimed);

  const World* world_;
  Query* query_;
  std::optional<Stroke> stroke_;
  std::vector<Hit> old_;  // kOldWidth x kOldHeight
  Aimed last_;
  EyeRay last_ray_;
  ViewState last_view_;
  int last_turns_ = 0;
};

}  // namespace karst::app
