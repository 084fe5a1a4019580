// SPDX-License-Identifier: MIT
#include "app/overlay/overlay_mesh.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include "app/overlay/font.h"

namespace karst::app {
namespace {

constexpr double kNearer = 0.98;
constexpr double kLeastDepth_m = 1e-3;  // before the eye: what is behind is cut there

// Counter-clockwise by 90 degrees each.
glm::dvec2 turned(glm::dvec2 ndc, int quarter_turns) {
  for (int n = 0; n < (quarter_turns & 3); ++n) ndc = {-ndc.y, ndc.x};
  return ndc;
}

}  // namespace

std::vector<std::string_view> wrap_text(std::string_view text, std::size_t letters) {
  std::vector<std::string_view> lines;
  letters = std::max<std::size_t>(letters, 1);
  while (text.size() > letters) {
    std::size_t end = text.rfind(' ', letters);
    if (end == std::string_view::npos || end == 0) end = letters;
    lines.push_back(text.substr(0, end));
    text.remove_prefix(end);
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  }
  if (!text.empty()) lines.push_back(text);
  return lines;
}

void OverlayMesh::start(const ViewState& view, int quarter_turns) {
  view_ = view;
  turns_ = quarter_turns;
  const glm::ivec2 target(static_cast<int>(view.width_px), static_cast<int>(view.height_px));
  size_ = (quarter_turns & 1) != 0 ? glm::ivec2(target.y, target.x) : target;
  lines_.clear();
  screen_.clear();
}

void OverlayMesh::line(const glm::dvec3& from, const glm::dvec3& to, Rgba colour, double width_px) {
  const glm::dvec3 eye(view_.eye.x, view_.eye.y, view_.eye.z);
  const auto seen = [&](const glm::dvec3& place) {
    const glm::dvec3 p = place - eye;
    const double* const m = view_.view_from_world;
    return kNearer * glm::dvec3(m[0] * p.x + m[3] * p.y + m[6] * p.z, m[1] * p.x + m[4] * p.y + m[7] * p.z,
                                m[2] * p.x + m[5] * p.y + m[8] * p.z);
  };
  glm::dvec3 a = seen(from), b = seen(to);
  if (a.z > -kLeastDepth_m && b.z > -kLeastDepth_m) return;
  const auto cut = [](glm::dvec3& behind, const glm::dvec3& before) {
    behind += (before - behind) * ((-kLeastDepth_m - behind.z) / (before.z - behind.z));
  };
  if (a.z > -kLeastDepth_m) cut(a, b);
  if (b.z > -kLeastDepth_m) cut(b, a);
  lines_.push_back({a, b, colour, width_px});
}

std::vector<OverlayVertex> OverlayMesh::lines(const DepthRange& range) const {
  const double* const m = view_.clip_from_view;
  const double sign = view_.reversed_depth ? -1.0 : 1.0;
  const double depth = range.far_m - range.near_m;
  const bool own = !(depth > 0);
  const double scale_z = own ? m[10] : -sign * (range.far_m + range.near_m) / depth;
  const double move_z = own ? m[14] : -sign * 2 * range.far_m * range.near_m / depth;
  const glm::dvec2 pixels(view_.width_px, view_.height_px);
  const auto clip = [&](const glm::dvec3& p) {
    return glm::dvec4(m[0] * p.x + m[4] * p.y + m[8] * p.z, m[1] * p.x + m[5] * p.y + m[9] * p.z,
                      scale_z * p.z + move_z, -p.z);
  };
  std::vector<OverlayVertex> vertices;
  const std::size_t most = kMostVertices - std::min(kMostVertices, screen_.size());
  vertices.reserve(std::min(most, lines_.size() * 6));
  constexpr std::uint16_t u = kSolidCell % 16 * kCellSide + kCellSide / 2,
                          v = kSolidCell / 16 * kCellSide + kCellSide / 2;
  for (const Line& line : lines_) {
    if (vertices.size() + 6 > most) break;
    const glm::dvec4 ends[2] = {clip(line.from), clip(line.to)};
    glm::dvec2 along = (glm::dvec2(ends[1]) / ends[1].w - glm::dvec2(ends[0]) / ends[0].w) * pixels;
    const double length = glm::length(along);
    along = length > 0 ? along / length : glm::dvec2(1, 0);
    const glm::dvec2 side = glm::dvec2(-along.y, along.x) * line.width_px / pixels;
    constexpr int kCorners[6][2] = {{0, 0}, {0, 1}, {1, 0}, {1, 0}, {0, 1}, {1, 1}};
    for (const auto& corner : kCorners) {
      glm::dvec4 at = ends[corner[0]];
      const glm::dvec2 moved = side * ((corner[1] == 0 ? -1.0 : 1.0) * at.w);
      at.x += moved.x;
      at.y += moved.y;
      vertices.push_back({{static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z),
                           static_cast<float>(at.w)},
                          line.colour,
                          {u, v}});
    }
  }
  return vertices;
}

// low, high: pixels of the upright picture. Of the solid cell one texel's middle, else the glyph's dots.
void OverlayMesh::quad(const glm::dvec2& low, const glm::dvec2& high, int cell, Rgba colour) {
  if (screen_.size() + 6 > kMostVertices) return;
  const int left = cell % 16 * kCellSide, top = cell / 16 * kCellSide;
  const bool solid = cell == kSolidCell;
  const int half = kCellSide / 2;
  constexpr int kCorners[6][2] = {{0, 0}, {0, 1}, {1, 0}, {1, 0}, {0, 1}, {1, 1}};
  for (const auto& corner : kCorners) {
    const glm::dvec2 at(corner[0] == 0 ? low.x : high.x, corner[1] == 0 ? low.y : high.y);
    const glm::dvec2 ndc = turned({2 * at.x / size_.x - 1, 1 - 2 * at.y / size_.y}, turns_);
    const int u = left + (solid ? half : corner[0] * kGlyphWidth);
    const int v = top + (solid ? half : corner[1] * kGlyphHeight);
    screen_.push_back({{static_cast<float>(ndc.x), static_cast<float>(ndc.y), 0, 1},
                       colour,
                       {static_cast<std::uint16_t>(u), static_cast<std::uint16_t>(v)}});
  }
}

void OverlayMesh::box(double x, double y, double width, double height, Rgba colour) {
  quad({x, y}, {x + width, y + height}, kSolidCell, colour);
}

void OverlayMesh::text(double x, double y, int scale, std::string_view text, Rgba colour) {
  for (const char letter : text) {
    if (letter > ' ' && letter <= '~')
      quad({x, y}, {x + kGlyphWidth * scale, y + kGlyphHeight * scale}, letter, colour);
    x += kLetterAdvance * scale;
  }
}

}  // namespace karst::app
