// SPDX-License-Identifier: MIT
// The simulator's own things: boxes, in light and air as the terrain has them, in the same depth buffer; and
// the same boxes in karst's shadow maps.
#pragma once

#include <span>

#include <karst/renderer.h>

#include "matrix.h"

namespace simulator {

struct Box {
  Mat4 place{};  // axes, of unit length, and the middle
  Vec3 half;     // of its sides, metres
  float albedo[3] = {};
};

class Painter {
 public:
  // In the current context. False, with the driver's words on standard error, where a shader does not
  // compile.
  [[nodiscard]] bool create();

  // Into the framebuffer and viewport that are bound. air: of the same view.
  void draw(const karst::ViewState& view, const karst::Air& air, std::span<const Box> boxes) const;
  // Into a shadow map: karst::FrameInput::draw_casters.
  void cast(const double (&clip_from_world)[16], Vec3 eye, std::span<const Box> boxes) const;

 private:
  void draw_boxes(unsigned program, const Mat4& clip_from_eye, Vec3 eye, std::span<const Box> boxes) const;

  unsigned lit_ = 0, depth_ = 0, corners_ = 0;  // programs, vertex array
};

}  // namespace simulator
