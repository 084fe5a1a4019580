// SPDX-License-Identifier: MIT
#include "terrain/patch/displacement.h"

#include <cmath>

namespace karst::core {
namespace {

using simd::Double2;
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

// W h for four vertices, in 2^-12 lattice steps. p: position in half voxels, in [-1, 1].
struct Displacement4 {
  Int4 axis[3];
};

inline Displacement4 displacement(const Float4 (&gradient)[8][3], const Float4 (&p)[3], Float4 height) {
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
    for (int axis = 0; axis < 3; ++axis) g[axis] += weight * gradient[o][axis];
  }
  const Float4 length = simd::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
  const Float4 scale =
      height * static_cast<float>(1 << kFractionBits) / simd::max(length, simd::splat(kMinGradientLength));
  Displacement4 d;
  for (int axis = 0; axis < 3; ++axis) d.axis[axis] = simd::to_int(g[axis] * scale);
  return d;
}

// From P (half voxels / 2^(4 level), integers) to the lattice. to_half: 2^(-4 level).
template <bool kDisplaced>
inline void place(const PatchShape& patch, const Float4 (&p)[3], float to_half, int shift, Float4 height,
                  Int4 (&position)[3]) {
  Int4 fixed[3];
  for (int axis = 0; axis < 3; ++axis) fixed[axis] = simd::to_int(p[axis]) << shift;
  if constexpr (kDisplaced) {
    const Float4 half[3] = {p[0] * to_half, p[1] * to_half, p[2] * to_half};
    const Displacement4 d = displacement(patch.gradient, half, height);
    for (int axis = 0; axis < 3; ++axis) fixed[axis] += d.axis[axis];
  }
  constexpr int kBits = kFractionBits + kVertexStepLog2;
  constexpr std::int32_t kRound = 1 << (kBits - 1);
  for (int axis = 0; axis < 3; ++axis) position[axis] = (fixed[axis] + kRound) >> kBits << kVertexStepLog2;
}

// P is kept in 2^-12 steps: half voxels are 2^12 steps, and P counts half voxels / 2^(4 level).
constexpr int fixed_shift(int level) {
  return kLatticeBits - 1 + kFractionBits - 4 * level;
}

float inverse_fourth(int n) {
  const float n2 = static_cast<float>(n) * static_cast<float>(n);
  return 1.0f / (n2 * n2);
}

}  // namespace

PatchShape PatchShape::make(const Surface& surface, const Heights& heights, int level, PatchId patch) {
  const Patch& p = surface.patches[patch];
  PatchShape s;
  s.volume = &surface.volumes[p.volume];
  s.level = level;
  const PatchCase& shape = kCaseTable[s.volume->configuration].patch[p.case_patch];
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& c = shape.control[j][i];
      s.control[j][i] = simd::to_float(Int4{c[0], c[1], c[2], 0});
    }
  }
  if (p.height_block != kNoHeights && !heights.samples.empty()) {
    s.heights = heights.block(p.height_block);
    s.heights_side = patch_side(heights.level);
    s.heights_stride = 1 << (heights.level - level);
    for (int o = 0; o < 8; ++o) {
      for (int axis = 0; axis < 3; ++axis)
        s.gradient[o][axis] = simd::splat(static_cast<float>(s.volume->gradient[o][axis]));
    }
  }
  return s;
}

GridLine GridLine::along_edge(int edge, int inset, int level, bool reversed) {
  const int n = patch_cells(level);
  GridLine line{};
  switch (edge) {
    case 0:
      line = {0, inset, 1, 0};
      break;
    case 1:
      line = {n - inset, 0, 0, 1};
      break;
    case 2:
      line = {n, n - inset, -1, 0};
      break;
    default:
      line = {inset, n, 0, -1};
      break;
  }
  if (reversed) line = {line.i0 + n * line.di, line.j0 + n * line.dj, -line.di, -line.dj};
  return line;
}

LineCurve line_curve(const PatchShape& patch, GridLine line) {
  const bool along_u = line.di != 0;
  const Weights across = bernstein(along_u ? line.j0 : line.i0, patch_cells(patch.level));
  const bool backwards = line.di + line.dj < 0;
  LineCurve curve;
  for (int a = 0; a < 3; ++a) {
    const int along = backwards ? 2 - a : a;
    const auto point = [&](int b) { return along_u ? patch.control[b][along] : patch.control[along][b]; };
    curve.control[a] = across.w[0] * point(0) + across.w[1] * point(1) + across.w[2] * point(2);
  }
  return curve;
}

template <bool kDisplaced>
static inline void displace_points_of(const PatchShape& patch, const LineCurve& curve, GridLine line,
                                      LinePoints points, glm::vec3 offset, float* const (&out)[3]) {
  const int n = patch_cells(patch.level);
  Float4 control[3][3];
  for (int a = 0; a < 3; ++a) {
    for (int axis = 0; axis < 3; ++axis) control[a][axis] = simd::splat(curve.control[a][axis]);
  }
  const float to_half = inverse_fourth(n);
  const int shift = fixed_shift(patch.level);
  const float size = static_cast<float>(n);
  const std::int16_t* heights = nullptr;
  std::ptrdiff_t height_step = 0;
  if constexpr (kDisplaced) {
    height_step = (line.dj * patch.heights_side + line.di) * patch.heights_stride;
    heights = patch.heights + (line.j0 * patch.heights_side + line.i0) * patch.heights_stride +
              points.first * height_step;
    height_step *= points.step;
  }
  const Float4 lane_t = static_cast<float>(points.step) * Float4{0, 1, 2, 3};
  for (int k = 0; k < points.count; k += simd::kLanes) {
    const Float4 b = static_cast<float>(points.first + k * points.step) + lane_t;
    const Float4 a = size - b;
    const Float4 weight[3] = {a * a, 2.0f * a * b, b * b};
    Float4 height = simd::splat(0.0f);
    if constexpr (kDisplaced) {
      const std::int16_t* h = heights + k * height_step;
      if (k + simd::kLanes <= points.count) {
        height = simd::to_float(Int4{h[0], h[height_step], h[2 * height_step], h[3 * height_step]});
      } else {  // lanes beyond the line repeat its end
        const int last = points.count - k - 1;
        const auto lane = [&](int l) { return std::int32_t{h[(l < last ? l : last) * height_step]}; };
        height = simd::to_float(Int4{lane(0), lane(1), lane(2), lane(3)});
      }
    }
    Float4 p[3];
    for (int axis = 0; axis < 3; ++axis) {
      p[axis] = weight[0] * control[0][axis] + weight[1] * control[1][axis] + weight[2] * control[2][axis];
    }
    Int4 position[3];
    place<kDisplaced>(patch, p, to_half, shift, height, position);
    for (int axis = 0; axis < 3; ++axis)
      simd::store(out[axis] + k, simd::to_float(position[axis]) + offset[axis]);
  }
}

void displace_points(const PatchShape& patch, const LineCurve& curve, GridLine line, LinePoints points,
                     glm::vec3 offset, float* x, float* y, float* z) {
  float* const out[3] = {x, y, z};
  if (patch.heights != nullptr) {
    displace_points_of<true>(patch, curve, line, points, offset, out);
  } else {
    displace_points_of<false>(patch, curve, line, points, offset, out);
  }
}

void displace_line(const PatchShape& patch, GridLine line, glm::vec3 offset, float* x, float* y, float* z) {
  displace_points(patch, line_curve(patch, line), line, {0, 1, patch_side(patch.level)}, offset, x, y, z);
}

Vertices4 displace_vertices(const PatchShape& patch, const int (&i)[4], const int (&j)[4]) {
  const int n = patch_cells(patch.level);
  const auto weights = [n](const int(&t)[4], Float4(&w)[3]) {
    const Float4 b = simd::to_float(Int4{t[0], t[1], t[2], t[3]});
    const Float4 a = static_cast<float>(n) - b;
    w[0] = a * a;
    w[1] = 2.0f * a * b;
    w[2] = b * b;
  };
  Float4 u[3];
  Float4 v[3];
  weights(i, u);
  weights(j, v);
  Float4 p[3];
  for (int axis = 0; axis < 3; ++axis) {
    p[axis] = simd::splat(0.0f);
    for (int a = 0; a < 3; ++a) {
      const Float4 across = v[0] * patch.control[0][a][axis] + v[1] * patch.control[1][a][axis] +
                            v[2] * patch.control[2][a][axis];
      p[axis] += u[a] * across;
    }
  }
  Int4 position[3];
  const float to_half = inverse_fourth(n);
  const int shift = fixed_shift(patch.level);
  if (patch.heights != nullptr) {
    const Int4 height = {patch.height(i[0], j[0]), patch.height(i[1], j[1]), patch.height(i[2], j[2]),
                         patch.height(i[3], j[3])};
    place<true>(patch, p, to_half, shift, simd::to_float(height), position);
  } else {
    place<false>(patch, p, to_half, shift, simd::splat(0.0f), position);
  }
  Vertices4 r;
  for (int lane = 0; lane < 4; ++lane)
    r.position[lane] = {position[0][lane], position[1][lane], position[2][lane]};
  return r;
}

void displaced_positions(const Surface& surface, const Heights& heights, int level, PatchId patch,
                         std::span<glm::ivec3> out) {
  const PatchShape shape = PatchShape::make(surface, heights, level, patch);
  const int side = patch_side(level);
  float line[3][patch_side(kMaxLevel) + simd::kLanes];
  glm::ivec3* to = out.data();
  for (int j = 0; j < side; ++j, to += side) {
    displace_line(shape, {0, j, 1, 0}, glm::vec3(0), line[0], line[1], line[2]);
    // The last one of a row has no room for a fourth value behind it.
    int i = 0;
    for (; i + simd::kLanes < side; i += simd::kLanes) {
      Int4 four[4];
      for (int axis = 0; axis < 3; ++axis) four[axis] = simd::to_int(simd::load(line[axis] + i));
      four[3] = four[2];
      simd::transpose(four[0], four[1], four[2], four[3]);
      for (int lane = 0; lane < simd::kLanes; ++lane) simd::store(&to[i + lane].x, four[lane]);
    }
    for (; i < side; ++i) to[i] = glm::ivec3(glm::vec3(line[0][i], line[1][i], line[2][i]));
  }
}

BasePoint base_point(const Surface& surface, int level, PatchId patch, int i, int j) {
  return base_point(PatchShape::make(surface, Heights{}, level, patch), i, j);
}

BasePoint base_point(const PatchShape& shape, int i, int j) {
  const BasePoints2 both = base_points(shape, line_curve(shape, {0, j, 1, 0}), i, i);
  BasePoint one;
  for (int axis = 0; axis < 3; ++axis) {
    one.position[axis] = both.position[axis][0];
    one.direction[axis] = both.direction[axis][0];
  }
  return one;
}

BasePoints2 base_points(const PatchShape& shape, const LineCurve& row, int i0, int i1) {
  const int n = patch_cells(shape.level);
  const Double2 b{static_cast<double>(i0), static_cast<double>(i1)};
  const Double2 a = static_cast<double>(n) - b;
  const Double2 weight[3] = {a * a, 2 * a * b, b * b};
  const double to_half = double{inverse_fourth(n)};
  Double2 p[3], side[3][2];  // half voxels; weights of the lower and upper voxel centre
  for (int axis = 0; axis < 3; ++axis) {
    p[axis] = (weight[0] * double{row.control[0][axis]} + weight[1] * double{row.control[1][axis]} +
               weight[2] * double{row.control[2][axis]}) *
              to_half;
    side[axis][0] = 0.5 - 0.5 * p[axis];
    side[axis][1] = 0.5 + 0.5 * p[axis];
  }
  Double2 g[3] = {simd::splat(0.0), simd::splat(0.0), simd::splat(0.0)};
  for (int o = 0; o < 8; ++o) {
    const Double2 share = side[0][o & 1] * side[1][o >> 1 & 1] * side[2][o >> 2 & 1];
    for (int axis = 0; axis < 3; ++axis)
      g[axis] += share * static_cast<double>(shape.volume->gradient[o][axis]);
  }
  const Double2 length = simd::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
  const Double2 most = simd::max(length, simd::splat(double{kMinGradientLength}));
  BasePoints2 out;
  for (int axis = 0; axis < 3; ++axis) {
    out.position[axis] = 0.5 * p[axis];
    out.direction[axis] = g[axis] / most;
  }
  return out;
}

}  // namespace karst::core
