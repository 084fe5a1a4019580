// SPDX-License-Identifier: MIT
// How far the surface in a picture is from what it stands for, in pixels, from the picture's depth.
//
// Against elevation: every covered pixel is brought back to its world point P; its error is the distance in
// pixels between P and the point of the elevation above or below it, both projected. Either way to cut a cell
// of the elevation into triangles is accepted. Points in the outer two cells are left out: the border of a
// world is not the border of its elevation.
//
// Against a reference picture from the same place (the full level): at each pixel, the distance from the
// nearer of the two points to the other picture's surface, times what a length covers there on the screen at
// most: pixels per radian over the apparent distance of terrain/lod/morph.h, the measure that error_px
// bounds. The farther point may lie on what the other picture hides. A picture's surface is a disc for each
// pixel, large enough to meet its neighbours; all pixels that could hold the nearest one are looked at, so
// that a ridge's outline that moved by a few pixels counts as those few pixels and not as the distance to the
// hill behind it.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "bench/measure/elevation_grid.h"
#include "terrain/view/camera.h"

namespace karst::bench {
using core::Camera;
using core::WorldFrame;

// Pixels; NaN where nothing was measured.
struct ErrorSummary {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::uint64_t pixels = 0;
  double mean = kNone, rms = kNone, p50 = kNone, p95 = kNone, p99 = kNone, p999 = kNone, max = kNone;
};

// Sorts px.
ErrorSummary summarise_errors(std::vector<float>& px);

struct DepthPicture {
  Camera camera;
  int width = 0, height = 0;
  std::span<const float> depth;  // as Renderer::read_depth leaves it: row 0 at the top, 0 near, 1 far or sky
};

// Both append a value for each pixel that is measured.
void errors_against_elevation(const DepthPicture& picture, const WorldFrame& frame, const ElevationGrid& grid,
                              std::vector<float>& px);
// reference: same camera and size.
void errors_against_picture(const DepthPicture& picture, std::span<const float> reference,
                            std::vector<float>& px);

// Mean over pixels and the three colours, in steps of 1/255. Both: 4 bytes a pixel, the same size.
double mean_colour_difference(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b);

}  // namespace karst::bench
