// SPDX-License-Identifier: MIT
// What is drawn over a picture of the terrain, as triangles: lines in the world, and boxes and text on the
// screen. Pure arithmetic; Overlay (overlay.h) gives it to OpenGL.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "karst/renderer.h"

namespace karst::app {

struct Rgba {
  std::uint8_t r = 255, g = 255, b = 255, a = 255;
};

struct OverlayVertex {
  float clip[4];
  Rgba colour;
  std::uint16_t texel[2];  // of the font's atlas
};
static_assert(sizeof(OverlayVertex) == 24);

// Letters are six dots apart and lines of text ten, each of `scale` pixels.
inline constexpr int kLetterAdvance = 6, kLineAdvance = 10;

// A line of words, broken so that none is longer than so many letters; words that are longer are cut.
std::vector<std::string_view> wrap_text(std::string_view text, std::size_t letters);

class OverlayMesh {
 public:
  // Of one picture, all of screen and world together; what is more is left out, the last first.
  static constexpr std::size_t kMostVertices = 16'384;

  // Forgets all. The view is that of the picture; quarter_turns as PictureShape has it.
  void start(const ViewState& view, int quarter_turns);

  // From place to place, metres of the world's own axes.
  void line(const glm::dvec3& from, const glm::dvec3& to, Rgba colour, double width_px = 2);
  // On the upright picture, pixels from its top left.
  void box(double x, double y, double width, double height, Rgba colour);
  void text(double x, double y, int scale, std::string_view text, Rgba colour);

  glm::ivec2 size() const { return size_; }  // of the upright picture
  // Of the lines, for a range of depth of the view (depth_ranges()), or by the view's own projection where
  // that is empty. Each is a 50th of its way nearer to the eye than it is said to be, so that it lies over
  // the surface that it was laid on.
  std::vector<OverlayVertex> lines(const DepthRange& range) const;
  std::span<const OverlayVertex> screen() const { return screen_; }

 private:
  struct Line {
    glm::dvec3 from, to;  // of the eye: x right, y up, z backwards
    Rgba colour;
    double width_px;
  };
  void quad(const glm::dvec2& low, const glm::dvec2& high, int cell, Rgba colour);

  ViewState view_;
  int turns_ = 0;
  glm::ivec2 size_{1};
  std::vector<Line> lines_;
  std::vector<OverlayVertex> screen_;
};

}  // namespace karst::app
