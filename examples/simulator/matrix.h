// SPDX-License-Identifier: MIT
// The few matrices that the simulator needs; columns, as OpenGL has them. Double, so that places far from the
// zero point keep their digits until the eye's place is taken off.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include <karst/types.h>

namespace simulator {

using karst::Vec3;
using Mat4 = std::array<double, 16>;

inline Vec3 operator+(Vec3 a, Vec3 b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3 operator-(Vec3 a, Vec3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3 operator*(double s, Vec3 v) {
  return {s * v.x, s * v.y, s * v.z};
}
inline double dot(Vec3 a, Vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Vec3 unit(Vec3 v) {
  return 1 / std::sqrt(dot(v, v)) * v;
}

inline Mat4 multiply(const Mat4& a, const Mat4& b) {
  Mat4 product{};
  for (std::size_t column = 0; column < 4; ++column) {
    for (std::size_t row = 0; row < 4; ++row) {
      for (std::size_t i = 0; i < 4; ++i) product[4 * column + row] += a[4 * i + row] * b[4 * column + i];
    }
  }
  return product;
}

// Columns are the axes and the place of a body.
inline Mat4 frame(Vec3 x, Vec3 y, Vec3 z, Vec3 place) {
  return {x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0, place.x, place.y, place.z, 1};
}

// A rotation of three by three, as ViewState has it.
inline Mat4 from_rotation(const double (&r)[9]) {
  return {r[0], r[1], r[2], 0, r[3], r[4], r[5], 0, r[6], r[7], r[8], 0, 0, 0, 0, 1};
}

}  // namespace simulator
