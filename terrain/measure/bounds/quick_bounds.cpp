// SPDX-License-Identifier: MIT
// Places. Control points hold the Bezier surface, and a vertex is away from there by |W h| <= |h|, and by
// what rounding to even steps and W's floats lose.
//
// Ways. Of a vertex and two others at distances s along u, and alike along v, twice the way to the middle is
// a second difference of a quadratic, s^2 |P_uu|, and that is 2 s^2 times a mean of second differences of
// rows of control points. Along a diagonal it is, by the sums of the four places around,
//   1/2 (D_u(v + s) + D_u(v - s)) + D_v +- 1/2 (P(+,+) - P(-,+) - P(+,-) + P(-,-)),
// D being those along one axis; the last is 2 s^2 |P_uv| at most, and P_uv 4 times a mean of mixed
// differences of four neighbouring control points.
#include "terrain/measure/bounds/quick_bounds.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "terrain/base/lattice.h"
#include "terrain/surface/bezier/case_tables.h"

namespace karst::core {
namespace {

// Steps that rounding and floats move a place by at most.
constexpr int kRounding = 2;

int squared(const int (&v)[3]) {
  return v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
}

}  // namespace

QuickBounds quick_bounds(const Surface& surface, const Heights& heights, PatchId patch) {
  const Patch& p = surface.patches[patch];
  const auto& control = kCaseTable[surface.volumes[p.volume].configuration].patch[p.case_patch].control;
  int highest = 0;
  if (p.height_block != kNoHeights && !heights.samples.empty()) {
    const std::int16_t* const block = heights.block(p.height_block);
    const auto count = static_cast<std::size_t>(patch_vertices(heights.level));
    std::int16_t low = 0, high = 0;
    for (std::size_t n = 0; n < count; ++n) {
      low = std::min(low, block[n]);
      high = std::max(high, block[n]);
    }
    highest = std::max(int{high}, -int{low});
  }
  QuickBounds out;
  out.apart = highest + kRounding;
  int along_u = 0, along_v = 0, mixed = 0;  // squares, half voxels
  for (std::size_t k = 0; k < 3; ++k) {
    int u[3], v[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      u[axis] = control[k][0][axis] - 2 * control[k][1][axis] + control[k][2][axis];
      v[axis] = control[0][k][axis] - 2 * control[1][k][axis] + control[2][k][axis];
    }
    along_u = std::max(along_u, squared(u));
    along_v = std::max(along_v, squared(v));
  }
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t j = k / 2, i = k % 2;
    int d[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      d[axis] = control[j][i][axis] - control[j][i + 1][axis] - control[j + 1][i][axis] +
                control[j + 1][i + 1][axis];
    }
    mixed = std::max(mixed, squared(d));
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    int low = control[0][0][axis], high = low;
    for (const auto& row : control) {
      for (const auto& point : row) {
        low = std::min(low, int{point[axis]});
        high = std::max(high, int{point[axis]});
      }
    }
    const int more = highest + kRounding;
    out.box.min[axis] = static_cast<std::int16_t>(low * kStepsPerHalfVoxel - more);
    out.box.max[axis] = static_cast<std::int16_t>(high * kStepsPerHalfVoxel + more);
  }
  const double most =
      2 * (std::sqrt(double(along_u)) + std::sqrt(double(along_v))) + 8 * std::sqrt(double(mixed));
  for (int m = 2; m <= heights.level; ++m) {
    const double twice = std::ldexp(most * kStepsPerHalfVoxel, -2 * m) + 4;
    // Above what rounding to a float takes away.
    const auto square = static_cast<float>(twice * twice * (1 + 0x1p-20));
    out.ways.longest[m] = square;
    std::ranges::fill(out.ways.on_edge[m], square);
  }
  return out;
}

}  // namespace karst::core
