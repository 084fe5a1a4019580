// SPDX-License-Identifier: MIT
#include "app/editor/aim.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace karst::app {
namespace {

glm::dvec3 vec(Vec3 v) {
  return {v.x, v.y, v.z};
}
Vec3 vec(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

// From the eye's axes to the world's.
glm::dvec3 to_world(const ViewState& view, const glm::dvec3& v) {
  const double* const m = view.view_from_world;
  return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[3] * v.x + m[4] * v.y + m[5] * v.z,
          m[6] * v.x + m[7] * v.y + m[8] * v.z};
}

}  // namespace

EyeRay eye_ray(const ViewState& view, int quarter_turns, const glm::dvec2& pointer) {
  glm::dvec2 ndc(2 * pointer.x - 1, 1 - 2 * pointer.y);
  for (int n = 0; n < (quarter_turns & 3); ++n) ndc = {-ndc.y, ndc.x};
  const double* const m = view.clip_from_view;
  const double area = m[0] * m[5] - m[4] * m[1];
  // One metre before the eye.
  const glm::dvec3 ahead((m[5] * ndc.x - m[4] * ndc.y) / area, (m[0] * ndc.y - m[1] * ndc.x) / area, -1);
  return {vec(view.eye), glm::normalize(to_world(view, ahead))};
}

Aim::Aim(const World& world, Query& query) : world_(&world), query_(&query) {}

Hit Aim::hit(const EyeRay& ray) const {
  const WorldInfo& info = world_->info();
  // To the farthest corner of all that is there.
  const glm::dvec3 way =
      glm::max(glm::abs(vec(info.low_m) - ray.from), glm::abs(vec(info.high_m) - ray.from));
  Hit hit;
  query_->ray(vec(ray.from), vec(ray.from + ray.along * glm::length(way)), Wait::for_file, hit);
  return hit;
}

Aimed Aim::at(const Brush& brush, const ViewState& view, int quarter_turns, const glm::dvec2& pointer) {
  const EyeRay ray = eye_ray(view, quarter_turns, pointer);
  Aimed aimed;
  const DrawOn draw_on = stroke_ ? stroke_->draw_on : DrawOn::surface;
  switch (draw_on) {
    case DrawOn::surface: {
      const Hit met = hit(ray);
      aimed.found = met.found;
      aimed.surface = vec(met.place);
      aimed.normal = vec(met.normal);
      break;
    }
    case DrawOn::old_surface:
      aimed.found = on_old_surface(ray, aimed.surface, aimed.normal);
      break;
    case DrawOn::level:
    case DrawOn::tangent:
    case DrawOn::camera:
      aimed.normal = stroke_->normal;
      aimed.found = on_plane(ray, aimed.surface);
      break;
  }
  aimed.place = aimed.surface + aimed.normal * (brush.offset() * brush.radius_m());
  if (brush.shape() == HandShape::voxel) aimed.found = find_voxel(brush, ray, aimed);
  if (stroke_ && aimed.found && (brush.tool() == Tool::flatten || brush.tool() == Tool::level)) {
    // On the plane that is made, above or below what the pointer is at.
    const glm::dvec3 way = aimed.place - stroke_->flat;
    const glm::dvec3& up = stroke_->flat_up;
    aimed.place.y = stroke_->flat.y - (way.x * up.x + way.z * up.z) / up.y;
  }
  last_ = aimed;
  last_ray_ = ray;
  last_view_ = view;
  last_turns_ = quarter_turns;
  return aimed;
}

// Of dig the first filled voxel (K algorithm 5.1); of fill the one before it, or where there is rock without
// voxels, that of the lattice which the place is in.
bool Aim::find_voxel(const Brush& brush, const EyeRay& ray, Aimed& aimed) {
  const WorldInfo& info = world_->info();
  const double side = std::ldexp(info.voxel_size_m, info.octree_depth - brush.octree_level());
  const bool plane = stroke_ && stroke_->draw_on != DrawOn::surface;
  const double fill = brush.tool() == Tool::fill ? 1.0 : -1.0;
  Voxel voxel;
  const glm::dvec3 way =
      glm::max(glm::abs(vec(info.low_m) - ray.from), glm::abs(vec(info.high_m) - ray.from));
  const glm::dvec3 end = ray.from + ray.along * glm::length(way);
  // Octrees are not looked for behind the ground that stands before them; patches are displaced by less.
  const auto is_behind = [&] {
    constexpr double kDisplaced = 4;  // voxels
    const double most_m = 2 * voxel.side_m + kDisplaced * info.voxel_size_m;
    return aimed.found && glm::dot(vec(voxel.centre) - aimed.surface, ray.along) > most_m;
  };
  if (!plane && query_->pick(vec(ray.from), vec(end), brush.octree_level(), voxel) && !is_behind()) {
    aimed.voxel_side_m = voxel.side_m;
    aimed.place = vec(voxel.centre);
    aimed.surface = aimed.place;
    if (brush.tool() != Tool::fill) return true;
    // Through the face that the ray entered last.
    int face = 0;
    double entered = -1e300;
    for (int axis = 0; axis < 3; ++axis) {
      if (ray.along[axis] == 0) continue;
      const double near = aimed.place[axis] - std::copysign(0.5 * voxel.side_m, ray.along[axis]);
      const double way_to = (near - ray.from[axis]) / ray.along[axis];
      if (way_to > entered) {
        entered = way_to;
        face = axis;
      }
    }
    if (entered <= 0) return false;  // the eye is in it
    aimed.place[face] -= std::copysign(voxel.side_m, ray.along[face]);
    return true;
  }
  if (!aimed.found) return false;
  const glm::dvec3 in = aimed.place + aimed.normal * (fill * 0.01 * side) - vec(info.origin_m);
  aimed.place = vec(info.origin_m) + (glm::floor(in / side) + 0.5) * side;
  aimed.voxel_side_m = side;
  return true;
}

double Aim::apart_m(const glm::dvec3& place) const {
  return glm::length(glm::cross(place - last_ray_.from, last_ray_.along));
}

bool Aim::begin_stroke(const Brush& brush) {
  if (!last_.found) return false;
  Stroke stroke;
  stroke.draw_on = brush.draw_on();
  stroke.place = last_.surface;
  stroke.normal = last_.normal;
  if (stroke.draw_on == DrawOn::level) stroke.normal = {0, 1, 0};
  if (stroke.draw_on == DrawOn::camera) stroke.normal = to_world(last_view_, {0, 0, 1});
  if (glm::dot(stroke.normal, last_ray_.along) > 0) stroke.normal = -stroke.normal;
  stroke.flat = last_.place;
  // Uphill is away from the eye.
  const double slope = glm::radians(brush.tool() == Tool::flatten ? brush.slope_deg() : 0.0);
  glm::dvec2 away(last_ray_.along.x, last_ray_.along.z);
  away = glm::length(away) > 1e-9 ? glm::normalize(away) : glm::dvec2(0);
  stroke.flat_up = {-std::sin(slope) * away.x, std::cos(slope), -std::sin(slope) * away.y};
  stroke.view = last_view_;
  stroke.turns = last_turns_;
  if (stroke.draw_on == DrawOn::old_surface) keep_old_surface(last_view_, last_turns_);
  stroke_ = stroke;
  return true;
}

void Aim::keep_old_surface(const ViewState& view, int quarter_turns) {
  old_.resize(std::size_t{kOldWidth} * kOldHeight);
  for (int y = 0; y < kOldHeight; ++y) {
    for (int x = 0; x < kOldWidth; ++x) {
      const glm::dvec2 at(double{1.0} * x / (kOldWidth - 1), double{1.0} * y / (kOldHeight - 1));
      old_[static_cast<std::size_t>(y * kOldWidth + x)] = hit(eye_ray(view, quarter_turns, at));
    }
  }
}

// The plane of the ray of the stroke's beginning that passes nearest, which is exact where the camera stands
// still and the old surface is flat between rays.
bool Aim::on_old_surface(const EyeRay& ray, glm::dvec3& place, glm::dvec3& normal) const {
  const glm::dvec3 eye = vec(stroke_->view.eye);
  const double* const v = stroke_->view.view_from_world;
  const double* const m = stroke_->view.clip_from_view;
  // Step by step, where the camera has moved: the place found, seen from the old eye, says which ray is
  // nearest.
  glm::dvec3 target = glm::length(ray.from - eye) < 1e-9 ? eye + ray.along : stroke_->place;
  for (int n = 0; n < 4; ++n) {
    const glm::dvec3 p = target - eye;
    const glm::dvec3 seen(v[0] * p.x + v[3] * p.y + v[6] * p.z, v[1] * p.x + v[4] * p.y + v[7] * p.z,
                          v[2] * p.x + v[5] * p.y + v[8] * p.z);
    if (seen.z >= 0) return false;
    glm::dvec2 ndc = glm::dvec2(m[0] * seen.x + m[4] * seen.y, m[1] * seen.x + m[5] * seen.y) / -seen.z;
    for (int turn = 0; turn < (4 - (stroke_->turns & 3)) % 4; ++turn) ndc = {-ndc.y, ndc.x};
    const double x = (ndc.x + 1) / 2 * (kOldWidth - 1), y = (1 - ndc.y) / 2 * (kOldHeight - 1);
    if (!(x > -1 && x < kOldWidth && y > -1 && y < kOldHeight)) return false;
    const int column = std::clamp(static_cast<int>(std::lround(x)), 0, kOldWidth - 1);
    const int row = std::clamp(static_cast<int>(std::lround(y)), 0, kOldHeight - 1);
    const Hit& old = old_[static_cast<std::size_t>(row * kOldWidth + column)];
    if (!old.found) return false;
    normal = vec(old.normal);
    const double along = glm::dot(ray.along, normal);
    const double way = glm::dot(vec(old.place) - ray.from, normal);
    // Seen along the surface the ray's own place is better.
    place = std::abs(along) > 0.02 && way / along > 0 ? ray.from + ray.along * (way / along) : vec(old.place);
    target = place;
  }
  return true;
}

bool Aim::on_plane(const EyeRay& ray, glm::dvec3& place) const {
  const double along = glm::dot(ray.along, stroke_->normal);
  const double way = glm::dot(stroke_->place - ray.from, stroke_->normal);
  if (std::abs(along) < 1e-6 || way / along <= 0) return false;
  place = ray.from + ray.along * (way / along);
  // Beyond the world there is nothing to edit.
  const WorldInfo& info = world_->info();
  return glm::length(place - ray.from) <= 4 * glm::length(vec(info.high_m) - vec(info.low_m));
}

}  // namespace karst::app
