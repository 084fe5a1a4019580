// SPDX-License-Identifier: MIT
// Displaced vertices of a patch on the lattice: D = P + W h (K equation 3.13 with design 4.4's W), rounded
// once, to even steps (lattice.h).
//
// P is the biquadratic Bézier point at (i, j) / 2^k: a dyadic number, computed exactly in integers. W is the
// trilinear interpolation of the gradients at the volume's eight voxel centres, normalised; on a face shared
// by two volumes only the face's four centres have weights, so both compute the same bits. W h is cut to
// 2^-12 step before it meets P, which makes the sum independent of the origin it is measured from. Where the
// interpolated gradient is shorter than kMinGradientLength (features one voxel thin, where the two sides
// cancel), W shrinks to zero with it instead of turning at random: such a spot can't be displaced.
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "terrain/base/simd.h"
#include "terrain/patch/heights.h"
#include "terrain/surface/bezier/case_tables.h"
#include "terrain/surface/patch.h"

namespace karst::core {

// In the units of Volume::gradient, where a flat surface has 32 at the voxel centres beside it.
inline constexpr float kMinGradientLength = 2.0f;

// A patch with what its vertices depend on, laid out for the inner loop. Borrows everything.
struct PatchShape {
  const Volume* volume = nullptr;
  simd::Float4 control[3][3];             // [j][i]: control points, half voxels; lanes are axes
  simd::Float4 gradient[8][3];            // the volume's, each in four equal lanes; set where heights are
  const std::int16_t* heights = nullptr;  // null: not displaced
  int heights_side = 0;                   // samples a row of heights
  int heights_stride = 1;                 // in i and j between vertices of the wanted level
  int level = 0;                          // wanted

  // heights.level >= level where the patch has heights. Without samples no patch has.
  static PatchShape make(const Surface& surface, const Heights& heights, int level, PatchId patch);

  std::int32_t height(int i, int j) const {
    return heights == nullptr ? 0 : heights[(j * heights_side + i) * heights_stride];
  }
};

// A straight run of vertices through a patch's grid: (i0, j0) + t (di, dj), t = 0..2^level, with exactly one
// of di, dj in {-1, 1} and the other 0, from border to border.
struct GridLine {
  int i0, j0, di, dj;

  // Parallel to edge e, `inset` rows inside, running from corner e to corner e + 1 (or back when reversed).
  static GridLine along_edge(int edge, int inset, int level, bool reversed);
};

// The quadratic Bézier curve that a grid line follows.
struct LineCurve {
  simd::Float4 control[3];  // times 4^level, integers up to 2^12; lanes are axes
};
LineCurve line_curve(const PatchShape& patch, GridLine line);

// Vertices t = first, first + step, ... of a line (`count` of them), as displace_line gives them.
// x, y, z: room for count values rounded up to a multiple of four.
struct LinePoints {
  int first, step, count;
};
void displace_points(const PatchShape& patch, const LineCurve& curve, GridLine line, LinePoints points,
                     glm::vec3 offset, float* x, float* y, float* z);

// Displaced positions in lattice steps relative to the patch's origin, as floats that hold integers, plus
// offset. x, y, z: room for 2^level + 1 values rounded up to a multiple of four.
void displace_line(const PatchShape& patch, GridLine line, glm::vec3 offset, float* x, float* y, float* z);

// Any four vertices (i, j) of a patch, relative to its origin; the same values as displace_line's.
struct Vertices4 {
  glm::ivec3 position[4];
};
Vertices4 displace_vertices(const PatchShape& patch, const int (&i)[4], const int (&j)[4]);

// All vertices of a patch, row by row (j * side + i): patch_vertices(level) positions relative to its origin.
void displaced_positions(const Surface& surface, const Heights& heights, int level, PatchId patch,
                         std::span<glm::ivec3> out);

// P of vertex (i, j) in voxels relative to the patch's origin, and W there. Both exact to double.
struct BasePoint {
  glm::dvec3 position;
  glm::dvec3 direction;
};
BasePoint base_point(const PatchShape& shape, int i, int j);
// Of two vertices of a row, whose curve is line_curve(shape, {0, j, 1, 0}); by axis; the same bits.
struct BasePoints2 {
  simd::Double2 position[3];
  simd::Double2 direction[3];
};
BasePoints2 base_points(const PatchShape& shape, const LineCurve& row, int i0, int i1);
BasePoint base_point(const Surface& surface, int level, PatchId patch, int i, int j);

}  // namespace karst::core
