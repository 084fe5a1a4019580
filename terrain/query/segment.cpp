// SPDX-License-Identifier: MIT
#include "terrain/query/segment.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace karst::core {
namespace {

// Of a component without length: finite, so that no lane is ever infinity times zero, and so large that what
// lies beside the slab is never met.
constexpr double kMostInverse = 1e30;

}  // namespace

bool Segment::cut(glm::dvec3 a, glm::dvec3 b, const LatticeBox& box, double grow) {
  const glm::dvec3 whole = b - a;
  double first = 0.0;
  double last = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = box.min[axis] - grow;
    const double high = box.max[axis] + grow;
    if (whole[axis] == 0.0) {
      if (a[axis] < low || a[axis] > high) return false;
      continue;
    }
    const double to_low = (low - a[axis]) / whole[axis];
    const double to_high = (high - a[axis]) / whole[axis];
    first = std::max(first, std::min(to_low, to_high));
    last = std::min(last, std::max(to_low, to_high));
  }
  if (!(first <= last)) return false;
  const double whole_length = glm::length(whole);
  from = first > 0.0 ? a + first * whole : a;
  way = (last < 1.0 ? a + last * whole : b) - from;
  before = first * whole_length;
  length = glm::length(way);
  return true;
}

SlabTest::SlabTest(const Segment& segment, double grow) {
  for (int axis = 0; axis < 3; ++axis) {
    const double d = segment.way[axis];
    negative[axis] = d < 0.0;
    const double most = negative[axis] ? -kMostInverse : kMostInverse;
    inverse[axis] = simd::splat(static_cast<float>(std::abs(d) * kMostInverse > 1.0 ? 1.0 / d : most));
  }
  move_to(segment, glm::ivec3(0), grow);
}

void SlabTest::move_to(const Segment& segment, glm::ivec3 base, double grow) {
  for (int axis = 0; axis < 3; ++axis) {
    const double at = segment.from[axis] - base[axis];
    const double wider = negative[axis] ? -grow : grow;
    near_origin[axis] = simd::splat(static_cast<float>(at + wider));
    far_origin[axis] = simd::splat(static_cast<float>(at - wider));
  }
}

}  // namespace karst::core
