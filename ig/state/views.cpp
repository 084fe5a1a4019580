// SPDX-License-Identifier: MIT
#include "ig/state/views.h"

#include <algorithm>
#include <cmath>

#include "app/common/arguments.h"
#include "app/stage/camera_view.h"

namespace karst::ig {
namespace {

constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180.0;
constexpr double kWidest_deg = 89.5;  // of a half-angle

// Tangents of the half-angles.
struct Edges {
  double left, right, bottom, top;
};

Edges edges_of(const cigi::ViewDefinition& definition, double fov_y_deg, int width, int height) {
  const double up = std::tan(fov_y_deg * (kRadiansPerDegree / 2));
  const double across = up * width / height;
  const auto tangent = [](bool valid, float angle_deg, double otherwise) {
    return valid ? std::tan(double{angle_deg} * kRadiansPerDegree) : otherwise;
  };
  return {tangent(definition.left_valid, definition.left_deg, -across),
          tangent(definition.right_valid, definition.right_deg, across),
          tangent(definition.bottom_valid, definition.bottom_deg, -up),
          tangent(definition.top_valid, definition.top_deg, up)};
}

bool is_sound(const cigi::ViewDefinition& definition) {
  const Edges edges = edges_of(definition, 60, 1, 1);
  for (const float angle :
       {definition.left_deg, definition.right_deg, definition.bottom_deg, definition.top_deg})
    if (!(std::fabs(angle) <= kWidest_deg)) return false;
  if (definition.near_valid && !(definition.near_m > 0)) return false;
  const double near = definition.near_valid ? definition.near_m : 0;
  if (definition.far_valid && !(definition.far_m > near)) return false;
  return edges.left < edges.right - 1e-4 && edges.bottom < edges.top - 1e-4;
}

void set_projection(const Edges& e, bool parallel, double near, double far, ViewState& state) {
  double* const m = state.clip_from_view;
  std::fill_n(m, 16, 0.0);
  const double sign = state.reversed_depth ? -1.0 : 1.0;
  const double size = parallel ? near : 1;
  m[0] = 2 / (size * (e.right - e.left));
  m[5] = 2 / (size * (e.top - e.bottom));
  if (parallel) {
    m[10] = -sign * 2 / (far - near);
    m[12] = -(e.right + e.left) / (e.right - e.left);
    m[13] = -(e.top + e.bottom) / (e.top - e.bottom);
    m[14] = -sign * (far + near) / (far - near);
    m[15] = 1;
    return;
  }
  m[8] = (e.right + e.left) / (e.right - e.left);
  m[9] = (e.top + e.bottom) / (e.top - e.bottom);
  m[10] = -sign * (far + near) / (far - near);
  m[11] = -1;
  m[14] = -sign * 2 * far * near / (far - near);
}

}  // namespace

Error parse_view_layout(std::string_view text, std::string_view what, ViewLayout& layout) {
  layout = {};
  layout.count = 0;
  layout.rows = 0;
  while (true) {
    std::string_view row = text.substr(0, text.find('/'));
    const std::size_t row_size = row.size();
    const std::size_t first = layout.count;
    int column = 0;
    while (true) {
      const std::string_view id = row.substr(0, row.find(','));
      std::int64_t number = 0;
      if (Error error = app::parse_integer(id, what, 0, 65'535, number); !error.ok()) return error;
      if (layout.count == kMostViews) return std::string(what) + ": more than 8 views";
      const auto known = std::span(layout.ids).first(layout.count);
      if (std::find(known.begin(), known.end(), number) != known.end())
        return std::string(what) + ": view " + std::to_string(number) + " twice";
      layout.ids[layout.count] = static_cast<std::uint16_t>(number);
      layout.row[layout.count] = layout.rows;
      layout.column[layout.count] = column++;
      ++layout.count;
      if (id.size() == row.size()) break;
      row.remove_prefix(id.size() + 1);
    }
    for (std::size_t n = first; n < layout.count; ++n) layout.columns[n] = column;
    ++layout.rows;
    if (row_size == text.size()) return {};
    text.remove_prefix(row_size + 1);
  }
}

void Views::clear() {
  views_.fill({});
}

bool Views::take(const cigi::ViewControl& control) {
  bool any = false;
  for (std::size_t n = 0; n < layout_.count; ++n) {
    View& view = views_[n];
    if (control.group != 0 ? view.group != control.group : layout_.ids[n] != control.view) continue;
    any = true;
    cigi::ViewControl& own = view.control;
    own.entity = control.entity;
    if (control.x_valid) own.x_m = control.x_m;
    if (control.y_valid) own.y_m = control.y_m;
    if (control.z_valid) own.z_m = control.z_m;
    if (control.roll_valid) own.roll_deg = control.roll_deg;
    if (control.pitch_valid) own.pitch_deg = control.pitch_deg;
    if (control.yaw_valid) own.yaw_deg = control.yaw_deg;
  }
  return any;
}

bool Views::take(const cigi::ViewDefinition& definition, bool& bad) {
  bad = false;
  for (std::size_t n = 0; n < layout_.count; ++n) {
    if (layout_.ids[n] != definition.view) continue;
    cigi::ViewDefinition own = views_[n].definition;
    const auto take_over = [](bool valid, float value, bool& own_valid, float& own_value) {
      if (!valid) return;
      own_valid = true;
      own_value = value;
    };
    take_over(definition.near_valid, definition.near_m, own.near_valid, own.near_m);
    take_over(definition.far_valid, definition.far_m, own.far_valid, own.far_m);
    take_over(definition.left_valid, definition.left_deg, own.left_valid, own.left_deg);
    take_over(definition.right_valid, definition.right_deg, own.right_valid, own.right_deg);
    take_over(definition.top_valid, definition.top_deg, own.top_valid, own.top_deg);
    take_over(definition.bottom_valid, definition.bottom_deg, own.bottom_valid, own.bottom_deg);
    own.mirror = definition.mirror;
    own.parallel = definition.parallel;
    bad = !is_sound(own);
    views_[n].group = definition.group;
    if (!bad) views_[n].definition = own;
    return true;
  }
  return false;
}

void Views::place_eye(View& view, const Entities& entities, const WorldInfo& world, double fov_y_deg) {
  const Entity* const entity = entities.find(view.control.entity);
  if (entity != nullptr && entity->is_placed) {
    const cigi::ViewControl& on = view.control;
    app::CameraPlace place;
    place.position_m = entity->body.at({on.x_m, on.y_m, on.z_m});
    if (app::check_place(place, world).ok()) {
      view.eye.place = place.position_m;
      view.eye.axes = turned(entity->body.axes, on.yaw_deg, on.pitch_deg, on.roll_deg);
      view.has_eye = true;
    }
  }
  if (view.has_eye) return;
  const app::CameraPlace all = app::overview(world, fov_y_deg);
  view.eye.place = all.position_m;
  // The overview counts yaw to the left, in the world's axes: east, up, south.
  const glm::dmat3 axes(glm::dvec3(0, 0, -1), glm::dvec3(1, 0, 0), glm::dvec3(0, -1, 0));
  view.eye.axes = turned(axes, -all.yaw_deg, all.pitch_deg, 0);
}

void Views::project(const View& view, const WorldInfo& world, app::CameraGround& ground,
                    const Picture& picture, int width, int height, ViewState& state) const {
  const cigi::ViewDefinition& said = view.definition;
  const Edges edges = edges_of(said, picture.fov_y_deg, width, height);
  app::CameraPlace place;
  place.position_m = view.eye.place;
  // Near and far as they fit what is there.
  double near = 1, far = 1e5;
  const double reach_up =
      std::max({std::fabs(edges.bottom), std::fabs(edges.top),
                std::max(std::fabs(edges.left), std::fabs(edges.right)) * height / width});
  const app::PictureShape shape{width, height, 2 * std::atan(reach_up) / kRadiansPerDegree, 0, false};
  ViewState fitted;
  if (app::place_view(place, world, ground.axes_at(place.position_m), shape,
                      ground.clearance_m(place.position_m), fitted)
          .ok()) {
    const double* const m = fitted.clip_from_view;
    near = m[14] / (m[10] - 1);
    far = m[14] / (m[10] + 1);
  }
  if (said.near_valid) near = said.near_m;
  if (said.far_valid) far = said.far_m;
  if (!(far > near)) (said.far_valid ? near : far) = said.far_valid ? far / 2 : near * 2;
  state.eye = {view.eye.place.x, view.eye.place.y, view.eye.place.z};
  const bool across = said.mirror == cigi::Mirror::horizontal || said.mirror == cigi::Mirror::both;
  const bool upside_down = said.mirror == cigi::Mirror::vertical || said.mirror == cigi::Mirror::both;
  const glm::dvec3 rows[3] = {across ? -view.eye.axes[1] : view.eye.axes[1],
                              upside_down ? view.eye.axes[2] : -view.eye.axes[2], -view.eye.axes[0]};
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) state.view_from_world[column * 3 + row] = rows[row][column];
  state.reversed_depth = picture.reversed_depth;
  state.width_px = static_cast<std::uint32_t>(width);
  state.height_px = static_cast<std::uint32_t>(height);
  const bool plain = !(said.left_valid || said.right_valid || said.top_valid || said.bottom_valid);
  if (plain && !said.parallel) {
    set_perspective(state, picture.fov_y_deg, near, far);
  } else {
    set_projection(edges, said.parallel, near, far, state);
  }
}

void Views::advance(const Entities& entities, const WorldInfo& world, app::CameraGround& ground,
                    const Picture& picture, const ViewState& common) {
  const bool on_its_side = (picture.quarter_turns & 1) != 0;
  const int width = on_its_side ? picture.height : picture.width;
  const int height = on_its_side ? picture.width : picture.height;
  for (std::size_t n = 0; n < layout_.count; ++n) {
    // Of the upright picture, from its bottom left.
    const int left = width * layout_.column[n] / layout_.columns[n];
    const int right = width * (layout_.column[n] + 1) / layout_.columns[n];
    const int top = height - height * layout_.row[n] / layout_.rows;
    const int bottom = height - height * (layout_.row[n] + 1) / layout_.rows;
    Rect part{left, bottom, std::max(right - left, 1), std::max(top - bottom, 1)};
    ViewState& state = states_[n];
    state = common;
    place_eye(views_[n], entities, world, picture.fov_y_deg);
    project(views_[n], world, ground, picture, part.width, part.height, state);
    app::turn_view(picture.quarter_turns, state);
    int turned_width = width, turned_height = height;
    for (int turn = 0; turn < (picture.quarter_turns & 3); ++turn) {
      part = {turned_height - part.y - part.height, part.x, part.height, part.width};
      std::swap(turned_width, turned_height);
      std::swap(state.width_px, state.height_px);
    }
    parts_[n] = part;
  }
}

}  // namespace karst::ig
