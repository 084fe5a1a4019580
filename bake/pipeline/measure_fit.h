// SPDX-License-Identifier: MIT
// How far the drawn surface of a height field is from the elevation it was made from, seen from above.
#pragma once

#include "bake/elevation/elevation_solid.h"
#include "bake/elevation/solid.h"
#include "terrain/patch/heights.h"
#include "terrain/surface/patch.h"

#include <cstdint>
#include <functional>

namespace karst::bake {
using namespace core;

// All triangles of the full level, with the integer positions that are drawn, are rasterised from above at a
// regular grid of points, in integers and with a tie rule, so that a point on an edge belongs to exactly one
// of the triangles that share it. Points are half a sample apart, or further where that would be more than
// kMostPoints.
struct MeasureFit {
  static constexpr std::size_t kMostPoints = 1u << 26;

  const ElevationSolid* solid = nullptr;
  double spacing_x_m = 1, spacing_z_m = 1;  // of the elevation's samples
  WorldGrid grid;
  Surface surface;
  Heights heights;
  // Places (world metres) that are no height field: near holes and carved shapes. May be empty.
  std::function<bool(double x_m, double z_m)> excluded;
  // One run of `chunk` patches in `every` is measured: what they cover, so that holes mean nothing if it is
  // not 1.
  std::size_t chunk = 1, every = 1;

  struct Result {
    double rms_m = 0, p999_m = 0, max_m = 0;  // vertical distance at the points
    std::uint64_t points = 0;                 // measured
    std::uint64_t holes = 0;                  // points that no triangle covers
    std::uint64_t folded = 0;                 // triangles that face sideways or down
    double covered_area = 0;                  // of all triangles seen from above, over the content's area
    double point_spacing_m = 0;               // the larger of x and z
  };
  Result run() const;
};

}  // namespace karst::bake
