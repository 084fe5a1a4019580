// SPDX-License-Identifier: MIT
// The bed of a sea that an elevation image does not know.
#pragma once

#include "bake/elevation/elevation.h"

#include <cstddef>

namespace karst::bake {

// Images show a sea as a plain at its level. Samples as high as the water, give or take kFlatM, are sunk: the
// farther from land, the deeper, by kSlope of the distance down to kDepthM. Others keep their heights, those
// of a known bed too. Returns how many were sunk. A shore gets a slope by that, and a place, which a plain at
// the water's own level does not have.
struct SinkSea {
  static constexpr double kFlatM = 0.25;
  static constexpr double kSlope = 0.05;
  static constexpr double kDepthM = 40;

  double level_m = 0;
  std::size_t run(Elevation& elevation) const;
};

}  // namespace karst::bake
