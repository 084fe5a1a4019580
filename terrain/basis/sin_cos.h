// SPDX-License-Identifier: MIT
// Sine and cosine by plain IEEE operations, so that every machine computes the same bits: what lies on a
// curved basis is placed by them. The polynomials are those of FDLIBM (Sun Microsystems, 1993, k_sin.c and
// k_cos.c), off by less than 2^-52 within +-45 degrees.
#pragma once

#include <cmath>

#include "terrain/base/angles.h"

namespace karst::core {

// Exact at multiples of 90 degrees, odd and even to the bit within +-45. Precondition: |angle_deg| <= 2^30.
inline SinCos plain_sin_cos_deg(double angle_deg) {
  constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180.0;
  const double quarter = std::nearbyint(angle_deg / 90.0);
  const double x = (angle_deg - quarter * 90.0) * kRadiansPerDegree;
  const double z = x * x;
  const double s =
      x + x * z *
              (-1.66666666666666324348e-01 +
               z * (8.33333333332248946124e-03 +
                    z * (-1.98412698298579493134e-04 +
                         z * (2.75573137070700676789e-06 +
                              z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))));
  const double c =
      1.0 -
      (0.5 * z - z * z *
                     (4.16666666666666019037e-02 +
                      z * (-1.38888888888741095749e-03 +
                           z * (2.48015872894767294178e-05 +
                                z * (-2.75573143513906633035e-07 +
                                     z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11))))));
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
