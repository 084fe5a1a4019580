// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

namespace karst::core {

struct SinCos {
  double sin, cos;
};

// Of an angle, exact at the multiples of 90 degrees: views along an axis then have zeros in their matrices,
// not rounding residue. Precondition: |angle_deg| <= 2^30.
inline SinCos sin_cos_deg(double angle_deg) {
  constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180.0;
  const double quarter = std::nearbyint(angle_deg / 90.0);
  const double rest = (angle_deg - quarter * 90.0) * kRadiansPerDegree;
  const double s = std::sin(rest);
  const double c = std::cos(rest);
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

}  // namespace karst::core
