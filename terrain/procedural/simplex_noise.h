// SPDX-License-Identifier: MIT
// 2D simplex noise (K. Perlin, "Noise hardware", 2001), four places at a time. Gradients come from an integer
// hash of the lattice point, without a table and without a period below 2^32 lattice steps.
#pragma once

#include <cstdint>

#include "terrain/base/simd.h"

namespace karst::core {

// Four values, one a place.
struct Places {
  simd::Double2 first, second;
};

inline Places operator*(const Places& p, double factor) {
  return {p.first * factor, p.second * factor};
}
inline Places operator+(const Places& p, double v) {
  return {p.first + v, p.second + v};
}
inline Places operator+(const Places& p, const Places& q) {
  return {p.first + q.first, p.second + q.second};
}

// Rounded to the nearest float.
simd::Float4 to_float(const Places& p);

// Within -1..1 and 0 at lattice points. Precondition: |x|, |z| < 2^30. The bits of a
// a lane depend on its place and seed alone, on every target.
simd::Float4 simplex_noise(const Places& x, const Places& z, std::uint32_t seed);

}  // namespace karst::core
