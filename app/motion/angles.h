// SPDX-License-Identifier: MIT
// Sines and cosines of degrees, exact for multiples of 90.
#pragma once

#include <cmath>
#include <utility>

namespace karst::app {

inline std::pair<double, double> sin_cos_deg(double angle_deg) {
  constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180.0;
  const double within = std::remainder(angle_deg, 360.0);
  const double quarter = std::nearbyint(within / 90.0);
  const double rest = (within - quarter * 90.0) * kRadiansPerDegree;
  const double s = std::sin(rest), c = std::cos(rest);
  switch (static_cast<int>(quarter) & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

}  // namespace karst::app
