// SPDX-License-Identifier: MIT
// Views of a host: what it last said of each, and what karst is asked to draw for it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "app/stage/camera_ground.h"
#include "ig/cigi/packets.h"
#include "ig/state/entities.h"
#include "karst/renderer.h"
#include "platform/base/error.h"

namespace karst::ig {

// Which views there are and where they lie in the picture: rows from the top, views from the left.
struct ViewLayout {
  std::array<std::uint16_t, kMostViews> ids{};
  std::array<int, kMostViews> row{}, column{}, columns{};  // its row, its place in it, and how many are there
  std::size_t count = 1;
  int rows = 1;

  ViewLayout() { columns[0] = 1; }
};
// "0", "0,1,2", "0,1/2,3".
Error parse_view_layout(std::string_view text, std::string_view what, ViewLayout& layout);

struct Picture {
  int width = 0, height = 0;  // pixels of the target
  int quarter_turns = 0;      // counter-clockwise
  bool reversed_depth = false;
  double fov_y_deg = 60;  // where the host says nothing
};

class Views {
 public:
  explicit Views(const ViewLayout& layout) : layout_(layout) { clear(); }
  void clear();

  // False: there is no such view or group.
  bool take(const cigi::ViewControl& control);
  // bad: half-angles that are none, and the view stays as it was.
  bool take(const cigi::ViewDefinition& definition, bool& bad);

  // Makes states() and parts() for a picture. A view whose entity is nowhere, or out of the world's reach,
  // stays where it was; before it was anywhere it shows all of the world. views: as they are now, for what
  // each wants beside its place.
  void advance(const Entities& entities, const WorldInfo& world, app::CameraGround& ground,
               const Picture& picture, const ViewState& common);
  std::span<const ViewState> states() const { return {states_.data(), layout_.count}; }
  std::span<const Rect> parts() const { return {parts_.data(), layout_.count}; }

 private:
  struct View {
    std::uint8_t group = 0;
    cigi::ViewControl control;        // what is valid has been taken over, flags or not
    cigi::ViewDefinition definition;  // flags: the host has said it
    Body eye;
    bool has_eye = false;
  };

  void place_eye(View& view, const Entities& entities, const WorldInfo& world, double fov_y_deg);
  void project(const View& view, const WorldInfo& world, app::CameraGround& ground, const Picture& picture,
               int width, int height, ViewState& state) const;

  ViewLayout layout_;
  std::array<View, kMostViews> views_;
  std::array<ViewState, kMostViews> states_{};
  std::array<Rect, kMostViews> parts_{};
};

}  // namespace karst::ig
