// SPDX-License-Identifier: MIT
// Depth in two ranges. A depth buffer of whole numbers, or one that is reached by way of -1..1, has steps
// that grow with far / near: at the far end one is far / near / 2^24 of the distance. So where that is much,
// what is nearer than the split is drawn into the nearer half of the buffer, the rest into the other half,
// each with near and far planes of its own, between which it is split in proportion.
#pragma once

#include <cmath>

#include <glm/mat4x4.hpp>

namespace karst::core {

// far / near up to which one range has the steps that two of 1,000,000 have.
inline constexpr double kOneRange = 2048;
// The nearer range reaches so much further than the split, that no pixel is clipped by both.
inline constexpr double kRangeOverlap = 0x1p-10;

struct DepthRanges {
  int count = 1;  // 1: the projection as it is, into 0..1
  double near = 0, split = 0, far = 0;

  // Near and far plane of a range, 0 the nearer one; it takes the buffer's n / 2..(n + 1) / 2.
  double near_of(int n) const { return n == 0 ? near : split; }
  double far_of(int n) const { return n == 0 ? split * (1 + kRangeOverlap) : far; }
  // Clip z of a range is a w + b.
  double a(int n) const { return (far_of(n) + near_of(n)) / (far_of(n) - near_of(n)); }
  double b(int n) const { return -2 * far_of(n) * near_of(n) / (far_of(n) - near_of(n)); }
};

// Two where a perspective's depth is not reversed, its near and far planes stand upright to the direction in
// which w grows and far is finite and more than kOneRange times near. clip_from_view: w is -z times anything.
inline DepthRanges depth_ranges(const glm::dmat4& clip_from_view, bool reversed_depth) {
  const glm::dmat4& m = clip_from_view;
  DepthRanges ranges;
  const bool plain =
      m[0][2] == 0 && m[1][2] == 0 && m[0][3] == 0 && m[1][3] == 0 && m[3][3] == 0 && m[2][3] < 0;
  if (!plain || reversed_depth) return ranges;
  // z / w = a + b / w, w being -z m[2][3].
  const double a = m[2][2] / m[2][3], b = m[3][2];
  ranges.near = b / (-1 - a) / -m[2][3];
  ranges.far = b / (1 - a) / -m[2][3];
  if (!(ranges.near > 0 && ranges.far < 1e30 && ranges.far > kOneRange * ranges.near)) return ranges;
  ranges.count = 2;
  ranges.split = std::sqrt(ranges.near * ranges.far);
  return ranges;
}

}  // namespace karst::core
