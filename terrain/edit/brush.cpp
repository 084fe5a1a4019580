// SPDX-License-Identifier: MIT
#include "terrain/edit/brush.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "terrain/base/check.h"

namespace karst::core {
namespace {

// e^x by powers of two and a series; that of the C library differs between machines.
double plain_exp(double x) {
  constexpr double kLog2 = 0.693147180559945309417;
  const double n = std::floor(x / kLog2 + 0.5);
  const double r = x - n * kLog2;
  double sum = 1;
  for (int k = 14; k >= 1; --k) sum = 1 + sum * r / k;
  return std::ldexp(sum, static_cast<int>(n));
}

double plain_tanh(double x) {
  const double e = plain_exp(2 * x);
  return (e - 1) / (e + 1);
}

double length(const glm::dvec3& v) {
  return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

// Of the radius; 1 and more: outside.
double share_of(const Edit& edit, const glm::dvec3& place) {
  const glm::dvec3 from = place - edit.place;
  switch (edit.shape) {
    case BrushShape::box: {
      const glm::dvec3 share(std::abs(from.x) / edit.half.x, std::abs(from.y) / edit.half.y,
                             std::abs(from.z) / edit.half.z);
      return std::max(std::max(share.x, share.y), share.z);
    }
    case BrushShape::capsule: {
      const glm::dvec3 along = edit.to - edit.place;
      const double square = glm::dot(along, along);
      const double t = square > 0 ? std::clamp(glm::dot(from, along) / square, 0.0, 1.0) : 0.0;
      return length(from - along * t) / edit.radius;
    }
    case BrushShape::cylinder:
      return length({from.x, 0, from.z}) / edit.radius;
    default:
      return length(from) / edit.radius;
  }
}

std::uint32_t corner_hash(const glm::dvec3& corner, std::uint32_t seed) {
  std::uint64_t h = seed * 0x9e3779b97f4a7c15ull;
  for (int axis = 0; axis < 3; ++axis) {
    h ^= static_cast<std::uint64_t>(static_cast<std::int64_t>(corner[axis]));
    h *= 0xc2b2ae3d27d4eb4full;
    h ^= h >> 29;
  }
  return static_cast<std::uint32_t>(h >> 32);
}

// From the middle of a cube to one of its twelve edges.
double gradient(std::uint32_t hash, const glm::dvec3& d) {
  const auto edge = static_cast<int>(std::uint64_t{hash} * 12 >> 32);
  const int axis = edge >> 2;  // which is 0
  const double u = d[axis == 0 ? 1 : 0], v = d[axis == 2 ? 1 : 2];
  return ((edge & 1) != 0 ? -u : u) + ((edge & 2) != 0 ? -v : v);
}

}  // namespace

double brush_profile(double share, double hardness) {
  if (!(share < 1)) return 0;
  if (share <= hardness) return 1;
  constexpr double kMiddle = 0.9950547536867305;  // tanh(kBrushSteepness)
  static_assert(kBrushSteepness == 3);
  return std::min(1.0, plain_tanh(kBrushSteepness * (1 - share) / (1 - hardness)) / kMiddle);
}

double brush_weight(const Edit& edit, const glm::dvec3& place) {
  KARST_ASSERT(edit.shape != BrushShape::voxel);
  return brush_profile(share_of(edit, place), edit.hardness);
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
  // Cubes of the skewed lattice are six tetrahedra each, along a way from corner to corner by one axis after
  // the other, the greatest share first.
  const double skew = (place.x + place.y + place.z) / 3;
  const glm::dvec3 cube(std::floor(place.x + skew), std::floor(place.y + skew), std::floor(place.z + skew));
  const double back = (cube.x + cube.y + cube.z) / 6;
  const glm::dvec3 first = place - (cube - back);
  int order[3] = {0, 1, 2};
  if (first[order[0]] < first[order[1]]) std::swap(order[0], order[1]);
  if (first[order[1]] < first[order[2]]) std::swap(order[1], order[2]);
  if (first[order[0]] < first[order[1]]) std::swap(order[0], order[1]);
  glm::dvec3 corner(0.0);
  double sum = 0;
  for (int n = 0; n < 4; ++n) {
    if (n > 0) corner[order[n - 1]] = 1;
    const glm::dvec3 d = first - corner + n / 6.0;
    // 0 at the faces across from the corner, and so is its slope.
    const double near = 0.5 - (d.x * d.x + d.y * d.y + d.z * d.z);
    if (near <= 0) continue;
    sum += near * near * near * near * gradient(corner_hash(cube + corner, seed), d);
  }
  constexpr double kToOne = 76;
  return std::clamp(sum * kToOne, -1.0, 1.0);
}

}  // namespace karst::core
