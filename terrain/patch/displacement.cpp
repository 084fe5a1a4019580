// SPDX-License-Identifier: MIT
#include "terrain/patch/displacement.h"

#include <cmath>

namespace karst {
namespace {

using simd::Float4;
using simd::Int4;

// Fractional bits kept of a lattice step until the one rounding: P at level 6 has 24 - 12 of them.
constexpr int kFractionBits = 12;

// Bernstein weights of degree 2 at t / n, times n^2: (n-t)^2, 2t(n-t), t^2.
struct Weights {
  float w[3];
};
Weights bernstein(int t, int n) {
  const float a = static_cast<float>(n - t);
  const float b = static_cast<float>(t);
  return {{a * a, 2.0f * a * b, b * b}};
}

// The quadratic Bézier curve that a grid line follows: three control points times n^2, integers up to 2^12.
struct LineCurve {
  float control[3][3];
};

LineCurve line_curve(const PatchCase& shape, GridLine line, int n) {
  const bool along_u = line.di != 0;
  const Weights across = bernstein(along_u ? line.j0 : line.i0, n);
  const bool backwards = line.di + line.dj < 0;
  LineCurve curve{};
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t along = backwards ? 2 - a : a;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      float sum = 0;
      for (std::size_t b = 0; b < 3; ++b) {
        const std::int8_t c = along_u ? shape.control[b][along][axis] : shape.control[along][b][axis];
        sum += across.w[b] * static_cast<float>(c);
      }
      curve.control[a][axis] = sum;
    }
  }
  return curve;
}

// W h for four vertices, in 2^-12 lattice steps. p: position in half voxels, in [-1, 1].
struct Displacement4 {
  Int4 axis[3];
};

inline Displacement4 displacement(const std::int8_t (&gradient)[8][3], const Float4 (&p)[3], Float4 height) {
  // Weights of the lower and upper voxel centre on each axis; exactly 0 and 1 on the volume's faces.
  Float4 upper[3];
  Float4 lower[3];
  for (int axis = 0; axis < 3; ++axis) {
    const Float4 half = 0.5f * p[axis];
    upper[axis] = 0.5f + half;
    lower[axis] = 0.5f - half;
  }
  const Float4 xy[4] = {lower[0] * lower[1], upper[0] * lower[1], lower[0] * upper[1], upper[0] * upper[1]};
  Float4 g[3] = {simd::splat(0.0f), simd::splat(0.0f), simd::splat(0.0f)};
  for (int o = 0; o < 8; ++o) {
    const Float4 weight = xy[o & 3] * (o < 4 ? lower[2] : upper[2]);
    for (int axis = 0; axis < 3; ++axis) g[axis] += weight * static_cast<float>(gradient[o][axis]);
  }
  const Float4 length = simd::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
  const Float4 scale = height * static_cast<float>(1 << kFractionBits) / simd::max(length, simd::splat(kMinGradientLength));
  Displacement4 d;
  for (int axis = 0; axis < 3; ++axis) d.axis[axis] = simd::to_int(g[axis] * scale);
  return d;
}

// Four positions from their curve parameter weights. to_half: 1 / n^4.
inline void place(const LineCurve& curve, const Float4 (&weight)[3], float to_half, int shift, const Volume& volume, bool displaced,
                  Float4 height, Int4 (&position)[3]) {
  Float4 p[3];
  for (int axis = 0; axis < 3; ++axis) {
    p[axis] = weight[0] * curve.control[0][axis] + weight[1] * curve.control[1][axis] + weight[2] * curve.control[2][axis];
  }
  Int4 fixed[3];
  for (int axis = 0; axis < 3; ++axis) fixed[axis] = simd::to_int(p[axis]) << shift;
  if (displaced) {
    const Float4 half[3] = {p[0] * to_half, p[1] * to_half, p[2] * to_half};
    const Displacement4 d = displacement(volume.gradient, half, height);
    for (int axis = 0; axis < 3; ++axis) fixed[axis] += d.axis[axis];
  }
  constexpr std::int32_t kRound = 1 << (kFractionBits - 1);
  for (int axis = 0; axis < 3; ++axis) position[axis] = (fixed[axis] + kRound) >> kFractionBits;
}

// P is kept in 2^-12 steps: half voxels are 2^12 steps, and P counts half voxels / 2^(4 level).
constexpr int fixed_shift(int level) { return kLatticeBits - 1 + kFractionBits - 4 * level; }

float inverse_fourth(int n) {
  const float n2 = static_cast<float>(n) * static_cast<float>(n);
  return 1.0f / (n2 * n2);
}

}  // namespace

PatchShape PatchShape::make(const Surface& surface, const Heights& heights, int level, PatchId patch) {
  const Patch& p = surface.patches[patch];
  PatchShape s;
  s.volume = &surface.volumes[p.volume];
  s.shape = &kCaseTable[s.volume->configuration].patch[p.case_patch];
  s.level = level;
  if (p.height_block != kNoHeights) {
    s.heights = heights.block(p.height_block);
    s.heights_side = patch_side(heights.level);
    s.heights_stride = 1 << (heights.level - level);
  }
  return s;
}

GridLine GridLine::along_edge(int edge, int inset, int level, bool reversed) {
  const int n = patch_cells(level);
  GridLine line{};
  switch (edge) {
    case 0: line = {0, inset, 1, 0}; break;
    case 1: line = {n - inset, 0, 0, 1}; break;
    case 2: line = {n, n - inset, -1, 0}; break;
    default: line = {inset, n, 0, -1}; break;
  }
  if (reversed) line = {line.i0 + n * line.di, line.j0 + n * line.dj, -line.di, -line.dj};
  return line;
}

void displace_line(const PatchShape& patch, GridLine line, glm::vec3 offset, float* x, float* y, float* z) {
  const int n = patch_cells(patch.level);
  const LineCurve curve = line_curve(*patch.shape, line, n);
  const float to_half = inverse_fourth(n);
  const int shift = fixed_shift(patch.level);
  const float size = static_cast<float>(n);
  const std::int16_t* heights = nullptr;
  int step = 0;
  if (patch.heights != nullptr) {
    heights = patch.heights + (line.j0 * patch.heights_side + line.i0) * patch.heights_stride;
    step = (line.dj * patch.heights_side + line.di) * patch.heights_stride;
  }
  for (int t = 0; t <= n; t += simd::kLanes) {
    const Float4 b = static_cast<float>(t) + Float4{0, 1, 2, 3};
    const Float4 a = size - b;
    const Float4 weight[3] = {a * a, 2.0f * a * b, b * b};
    Float4 height = simd::splat(0.0f);
    if (heights != nullptr) {
      const int last = n - t < 3 ? n - t : 3;  // lanes beyond the line repeat its end
      const auto at = [&](int lane) { return static_cast<float>(heights[(t + (lane < last ? lane : last)) * step]); };
      height = Float4{at(0), at(1), at(2), at(3)};
    }
    Int4 position[3];
    place(curve, weight, to_half, shift, *patch.volume, heights != nullptr, height, position);
    simd::store(x + t, simd::to_float(position[0]) + offset.x);
    simd::store(y + t, simd::to_float(position[1]) + offset.y);
    simd::store(z + t, simd::to_float(position[2]) + offset.z);
  }
}

glm::ivec3 displace_vertex(const PatchShape& patch, int i, int j) {
  const int n = patch_cells(patch.level);
  const LineCurve curve = line_curve(*patch.shape, {0, j, 1, 0}, n);
  const Weights w = bernstein(i, n);
  const Float4 weight[3] = {simd::splat(w.w[0]), simd::splat(w.w[1]), simd::splat(w.w[2])};
  Int4 position[3];
  place(curve, weight, inverse_fourth(n), fixed_shift(patch.level), *patch.volume, patch.heights != nullptr,
        simd::splat(static_cast<float>(patch.height(i, j))), position);
  return {position[0][0], position[1][0], position[2][0]};
}

void displaced_positions(const Surface& surface, const Heights& heights, int level, PatchId patch, std::span<glm::ivec3> out) {
  const PatchShape shape = PatchShape::make(surface, heights, level, patch);
  const int side = patch_side(level);
  float line[3][patch_side(kMaxLevel) + simd::kLanes];
  for (int j = 0; j < side; ++j) {
    displace_line(shape, {0, j, 1, 0}, glm::vec3(0), line[0], line[1], line[2]);
    for (int i = 0; i < side; ++i) out[static_cast<std::size_t>(j * side + i)] = glm::ivec3(glm::vec3(line[0][i], line[1][i], line[2][i]));
  }
}

BasePoint base_point(const Surface& surface, int level, PatchId patch, int i, int j) {
  const PatchShape shape = PatchShape::make(surface, Heights{}, level, patch);
  const int n = patch_cells(level);
  const LineCurve curve = line_curve(*shape.shape, {0, j, 1, 0}, n);
  const Weights w = bernstein(i, n);
  glm::dvec3 p(0.0);  // half voxels
  for (std::size_t a = 0; a < 3; ++a) {
    for (int axis = 0; axis < 3; ++axis) p[axis] += double{w.w[a]} * double{curve.control[a][axis]};
  }
  const double cells = n;
  p /= cells * cells * cells * cells;
  glm::dvec3 g(0.0);
  for (int o = 0; o < 8; ++o) {
    double weight = 1;
    for (int axis = 0; axis < 3; ++axis) weight *= (o >> axis & 1) != 0 ? 0.5 + 0.5 * p[axis] : 0.5 - 0.5 * p[axis];
    for (int axis = 0; axis < 3; ++axis) g[axis] += weight * shape.volume->gradient[o][axis];
  }
  const double length = std::sqrt(g.x * g.x + g.y * g.y + g.z * g.z);
  return {0.5 * p, g / (length > double{kMinGradientLength} ? length : double{kMinGradientLength})};
}

}  // namespace karst
