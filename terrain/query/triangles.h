// SPDX-License-Identifier: MIT
// Triangles against segments and vertical lines: the eight of a tile (index_batches.cpp: around its centre,
// counter-clockwise from outside), and single ones.
#pragma once

#include <glm/vec3.hpp>

#include "terrain/query/segment.h"

namespace karst::core {

// A tile's vertices: 0..7 around it, 8 its centre. Exact, lattice steps.
struct TileVertices {
  glm::dvec3 at[9];

  TileVertices(const QueryPatch& patch, int a, int b);
  // Of a node of the ground: the north-west one of nine in rows of kNodeSide, west first.
  explicit TileVertices(const glm::dvec3* first);

  // Corners of triangle t.
  const glm::dvec3& corner(int t, int k) const { return at[k == 2 ? 8 : (t + k) & 7]; }
  // Area vector, out of the rock; exact.
  glm::dvec3 area(int t) const;
};

// A segment turned so that it runs along one axis: there a triangle is hit where the origin is on one side of
// its three edges. A vertex that triangles share is at the same bits for each of them.
struct SegmentShear {
  glm::dvec3 from;
  int kx, ky, kz;  // kz: the axis along which the segment is longest
  double sx, sy, sz;

  explicit SegmentShear(const Segment& segment);

  // The same of one triangle. False: it is not crossed.
  bool cross(const glm::dvec3 (&corner)[3], double& share, glm::dvec3& place) const;

  // Calls visit(triangle, t, place) for the triangles of a tile that a segment crosses at 0 <= t <= 1, those
  // that it meets on an edge included.
  template <class Visit>
  void cross(const TileVertices& tile, Visit&& visit) const {
    double x[9];
    double y[9];
    double z[9];
    for (int v = 0; v < 9; ++v) {
      const glm::dvec3 d = tile.at[v] - from;
      x[v] = d[kx] - sx * d[kz];
      y[v] = d[ky] - sy * d[kz];
      z[v] = sz * d[kz];
    }
    // Of the edges from vertices around the tile to its centre; and of those around it.
    double spoke[8];
    double rim[8];
    for (int v = 0; v < 8; ++v) {
      const int next = (v + 1) & 7;
      spoke[v] = x[v] * y[8] - y[v] * x[8];
      rim[v] = x[v] * y[next] - y[v] * x[next];
    }
    for (int t = 0; t < 8; ++t) {
      const int next = (t + 1) & 7;
      const double w0 = spoke[next];
      const double w1 = -spoke[t];
      const double w2 = rim[t];
      if ((w0 < 0 || w1 < 0 || w2 < 0) && (w0 > 0 || w1 > 0 || w2 > 0)) continue;
      const double sum = w0 + w1 + w2;
      if (sum == 0.0) continue;  // seen from its edge
      const double share = (w0 * z[t] + w1 * z[next] + w2 * z[8]) / sum;
      if (!(share >= 0.0 && share <= 1.0)) continue;
      visit(t, share, (w0 * tile.at[t] + w1 * tile.at[next] + w2 * tile.at[8]) / sum);
    }
  }
};

// x and z of a vertical line, lattice steps. Rounded so that edge tests with vertices less than 2^17 steps
// away are exact: then a line that meets an edge or a corner can be moved aside by less than any number, and
// crosses each surface there once.
struct VerticalLine {
  static constexpr double kGrain = 0x1p-9;  // lattice steps

  double x, z;

  explicit VerticalLine(glm::dvec3 place_steps);

  // The same of one triangle, counter-clockwise from outside. False: it is not crossed.
  bool cross(const glm::dvec3 (&corner)[3], double& height, bool& up) const;

  // Calls visit(triangle, height, up) for the triangles of a tile that the line crosses. up: it faces up.
  template <class Visit>
  void cross(const TileVertices& tile, Visit&& visit) const {
    double px[9];
    double pz[9];
    for (int v = 0; v < 9; ++v) {
      px[v] = tile.at[v].x - x;
      pz[v] = tile.at[v].z - z;
    }
    double spoke[8];
    double rim[8];
    for (int v = 0; v < 8; ++v) {
      const int next = (v + 1) & 7;
      spoke[v] = px[v] * pz[8] - pz[v] * px[8];
      rim[v] = px[v] * pz[next] - pz[v] * px[next];
    }
    for (int t = 0; t < 8; ++t) {
      const int next = (t + 1) & 7;
      const double w0 = spoke[next];
      const double w1 = -spoke[t];
      const double w2 = rim[t];
      if ((w0 < 0 || w1 < 0 || w2 < 0) && (w0 > 0 || w1 > 0 || w2 > 0)) continue;
      const double sum = w0 + w1 + w2;
      if (sum == 0.0) continue;  // upright
      // On an edge: where the line is when it is moved by a little in x and by much less in z.
      const auto beside = [&](double w, int a, int b) {
        if (w != 0.0) return w > 0.0;
        const double dz = pz[a] - pz[b];
        return dz != 0.0 ? dz > 0.0 : px[b] > px[a];
      };
      const bool positive = sum > 0.0;
      if (beside(w0, next, 8) != positive || beside(w1, 8, t) != positive || beside(w2, t, next) != positive)
        continue;
      visit(t, (w0 * tile.at[t].y + w1 * tile.at[next].y + w2 * tile.at[8].y) / sum, !positive);
    }
  }
};

// Area vector, out of the rock; exact.
glm::dvec3 area_of(const glm::dvec3 (&corner)[3]);

}  // namespace karst::core
