// SPDX-License-Identifier: MIT
#include "terrain/edit/brush.h"

#include <array>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "terrain/base/check.h"

namespace karst::core {
namespace {

using simd::Double2;
using simd::Long2;

constexpr double kMiddle = 0.9950547536867305;  // tanh(kBrushSteepness)
static_assert(kBrushSteepness == 3);

// tanh, from 0 to kBrushSteepness, by powers of two and a series; that of the C library differs between
// machines.
Double2 plain_tanh(Double2 x) {
  constexpr double kLog2 = 0.693147180559945309417;
  constexpr int kTerms = 14;
  constexpr std::array<double, kTerms + 1> kFactors = [] {
    std::array<double, kTerms + 1> factors{1};
    for (std::size_t k = 1; k <= kTerms; ++k) factors[k] = factors[k - 1] / static_cast<double>(k);
    return factors;
  }();
  const Double2 twice = 2 * x;
  const Double2 n = simd::floor(twice * (1 / kLog2) + 0.5);
  const Double2 r = twice - n * kLog2;
  Double2 sum = simd::splat(kFactors[kTerms]);
  for (std::size_t k = kTerms; k-- > 0;) sum = sum * r + kFactors[k];
  // 2^n: n becomes the exponent.
  const Double2 e = sum * simd::as_double((simd::as_long(n + 0x1p52) + 1023) << 52);
  return (e - 1) / (e + 1);
}

Double2 profile(Double2 share, double hardness) {
  const Double2 part = simd::max(simd::splat(0.0), simd::min((1 - share) / (1 - hardness), simd::splat(1.0)));
  const Double2 soft = simd::min(plain_tanh(kBrushSteepness * part) / kMiddle, simd::splat(1.0));
  const Long2 whole = share <= hardness, inside = share < 1;
  return simd::select(inside, simd::select(whole, simd::splat(1.0), soft), simd::splat(0.0));
}

// Of the radius; 1 and more: outside.
Double2 share_of(const Edit& edit, const Double2 (&place)[3]) {
  const Double2 from[3] = {place[0] - edit.place.x, place[1] - edit.place.y, place[2] - edit.place.z};
  const auto length = [](const Double2(&v)[3]) {
    return simd::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  };
  switch (edit.shape) {
    case BrushShape::box:
      return simd::max(simd::max(simd::abs(from[0]) / edit.half.x, simd::abs(from[1]) / edit.half.y),
                       simd::abs(from[2]) / edit.half.z);
    case BrushShape::capsule: {
      const glm::dvec3 along = edit.to - edit.place;
      const double square = glm::dot(along, along);
      Double2 t = simd::splat(0.0);
      if (square > 0) {
        t = (from[0] * along.x + from[1] * along.y + from[2] * along.z) / square;
        t = simd::max(simd::min(t, simd::splat(1.0)), simd::splat(0.0));
      }
      return length({from[0] - along.x * t, from[1] - along.y * t, from[2] - along.z * t}) / edit.radius;
    }
    case BrushShape::cylinder:
      return length({from[0], simd::splat(0.0), from[2]}) / edit.radius;
    default:
      return length(from) / edit.radius;
  }
}

// Which of twelve edges of a cube the gradient of a corner points at, from its middle.
std::uint64_t edge_of(const std::int64_t (&corner)[3], std::uint32_t seed) {
  std::uint64_t h = seed * 0x9e3779b97f4a7c15ull;
  for (const std::int64_t axis : corner) {
    h ^= static_cast<std::uint64_t>(axis);
    h *= 0xc2b2ae3d27d4eb4full;
    h ^= h >> 29;
  }
  return (h >> 32) * 12 >> 32;
}

// d along those edges. Four edges have 0 along each axis; of the other two axes the signs differ.
Double2 along_edges(const std::uint64_t (&edge)[2], const Double2 (&d)[3]) {
  const auto both = [&](auto&& of) {
    return Long2{static_cast<std::int64_t>(of(edge[0])), static_cast<std::int64_t>(of(edge[1]))};
  };
  const Long2 none_x = both([](std::uint64_t e) { return std::uint64_t{0} - std::uint64_t{e < 4}; });
  const Long2 none_z = both([](std::uint64_t e) { return std::uint64_t{0} - std::uint64_t{e >= 8}; });
  const Double2 u = simd::select(none_x, d[1], d[0]), v = simd::select(none_z, d[1], d[2]);
  const Long2 u_sign = both([](std::uint64_t e) { return e << 63; });
  const Long2 v_sign = both([](std::uint64_t e) { return e >> 1 << 63; });
  return simd::as_double(simd::as_long(u) ^ u_sign) + simd::as_double(simd::as_long(v) ^ v_sign);
}

}  // namespace

double brush_profile(double share, double hardness) {
  return profile(simd::splat(share), hardness)[0];
}

Double2 brush_weights(const Edit& edit, const Double2 (&place)[3]) {
  KARST_ASSERT(edit.shape != BrushShape::voxel);
  return profile(share_of(edit, place), edit.hardness);
}

double brush_weight(const Edit& edit, const glm::dvec3& place) {
  return brush_weights(edit, {simd::splat(place.x), simd::splat(place.y), simd::splat(place.z)})[0];
}

BrushBox brush_box(const Edit& edit) {
  const glm::dvec3 reach = edit.shape == BrushShape::box ? edit.half : glm::dvec3(edit.radius);
  BrushBox box{edit.place - reach, edit.place + reach};
  if (edit.shape == BrushShape::capsule) {
    box.low = glm::min(box.low, edit.to - reach);
    box.high = glm::max(box.high, edit.to + reach);
  }
  if (edit.shape == BrushShape::cylinder) {
    box.low.y = -std::numeric_limits<double>::infinity();
    box.high.y = std::numeric_limits<double>::infinity();
  }
  return box;
}

double simplex_noise(const glm::dvec3& place, std::uint32_t seed) {
  return simplex_noise({simd::splat(place.x), simd::splat(place.y), simd::splat(place.z)}, seed)[0];
}

Double2 simplex_noise(const Double2 (&place)[3], std::uint32_t seed) {
  // Cubes of the skewed lattice are six tetrahedra each, along a way from corner to corner by one axis after
  // the other, the greatest share first.
  const Double2 skew = (place[0] + place[1] + place[2]) / 3;
  Double2 cube[3], first[3];
  for (int axis = 0; axis < 3; ++axis) cube[axis] = simd::floor(place[axis] + skew);
  const Double2 back = (cube[0] + cube[1] + cube[2]) / 6;
  for (int axis = 0; axis < 3; ++axis) first[axis] = place[axis] - (cube[axis] - back);
  const Long2 xy = first[0] >= first[1], yz = first[1] >= first[2], xz = first[0] >= first[2];
  const Long2 none{0, 0};
  // Lanes are -1 where a corner is one further along the axis.
  const Long2 corners[4][3] = {{none, none, none},
                               {xy & xz, ~xy & yz, ~xz & ~yz},
                               {xy | xz, ~xy | yz, ~xz | ~yz},
                               {~none, ~none, ~none}};
  const Double2 one = simd::splat(1.0), zero = simd::splat(0.0);
  Double2 sum = zero;
  for (int n = 0; n < 4; ++n) {
    Double2 d[3];
    std::uint64_t edge[2];
    for (int axis = 0; axis < 3; ++axis)
      d[axis] = first[axis] - simd::select(corners[n][axis], one, zero) + n / 6.0;
    for (int lane = 0; lane < 2; ++lane) {
      std::int64_t corner[3];
      for (int axis = 0; axis < 3; ++axis)
        corner[axis] = static_cast<std::int64_t>(cube[axis][lane]) - corners[n][axis][lane];
      edge[lane] = edge_of(corner, seed);
    }
    // 0 at the faces across from the corner, and so is its slope.
    const Double2 near = simd::max(0.5 - (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]), zero);
    sum += near * near * near * near * along_edges(edge, d);
  }
  constexpr double kToOne = 76;
  return simd::max(simd::min(sum * kToOne, one), -one);
}

}  // namespace karst::core
