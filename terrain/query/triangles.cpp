// SPDX-License-Identifier: MIT
#include "terrain/query/triangles.h"

#include <cmath>

#include <glm/geometric.hpp>

#include "terrain/ground/ground.h"

namespace karst::core {
namespace {

// Cells from a tile's lower corner, in the order of index_batches.cpp; the last is the centre.
constexpr int kAround[9][2] = {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}, {1, 1}};

}  // namespace

TileVertices::TileVertices(const QueryPatch& patch, int a, int b) {
  const int side = patch_side(patch.level);
  const std::int16_t* first = patch.positions + 3 * (2 * b * side + 2 * a);
  for (int v = 0; v < 9; ++v) {
    const std::int16_t* p = first + 3 * (kAround[v][1] * side + kAround[v][0]);
    at[v] = glm::dvec3(patch.origin + glm::ivec3(p[0], p[1], p[2]));
  }
}

// Of a node i runs south and j east (family_row.h).
TileVertices::TileVertices(const glm::dvec3* first) {
  for (int v = 0; v < 9; ++v) at[v] = first[kAround[v][0] * kNodeSide + kAround[v][1]];
}

glm::dvec3 TileVertices::area(int t) const {
  return glm::cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0));
}

SegmentShear::SegmentShear(const Segment& segment) : from(segment.from) {
  const glm::dvec3& way = segment.way;
  kz = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (std::abs(way[axis]) > std::abs(way[kz])) kz = axis;
  }
  kx = (kz + 1) % 3;
  ky = (kz + 2) % 3;
  sz = 1.0 / way[kz];
  sx = way[kx] * sz;
  sy = way[ky] * sz;
}

glm::dvec3 area_of(const glm::dvec3 (&corner)[3]) {
  return glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
}

bool SegmentShear::cross(const glm::dvec3 (&corner)[3], double& share, glm::dvec3& place) const {
  double x[3], y[3], z[3], w[3];
  for (int k = 0; k < 3; ++k) {
    const glm::dvec3 d = corner[k] - from;
    x[k] = d[kx] - sx * d[kz];
    y[k] = d[ky] - sy * d[kz];
    z[k] = sz * d[kz];
  }
  for (int k = 0; k < 3; ++k) {
    const int a = (k + 1) % 3, b = (k + 2) % 3;
    w[k] = x[a] * y[b] - y[a] * x[b];
  }
  if ((w[0] < 0 || w[1] < 0 || w[2] < 0) && (w[0] > 0 || w[1] > 0 || w[2] > 0)) return false;
  const double sum = w[0] + w[1] + w[2];
  if (sum == 0.0) return false;  // seen from its edge
  share = (w[0] * z[0] + w[1] * z[1] + w[2] * z[2]) / sum;
  if (!(share >= 0.0 && share <= 1.0)) return false;
  place = (w[0] * corner[0] + w[1] * corner[1] + w[2] * corner[2]) / sum;
  return true;
}

bool VerticalLine::cross(const glm::dvec3 (&corner)[3], double& height, bool& up) const {
  double px[3], pz[3], w[3];
  for (int k = 0; k < 3; ++k) {
    px[k] = corner[k].x - x;
    pz[k] = corner[k].z - z;
  }
  for (int k = 0; k < 3; ++k) {
    const int a = (k + 1) % 3, b = (k + 2) % 3;
    w[k] = px[a] * pz[b] - pz[a] * px[b];
  }
  if ((w[0] < 0 || w[1] < 0 || w[2] < 0) && (w[0] > 0 || w[1] > 0 || w[2] > 0)) return false;
  const double sum = w[0] + w[1] + w[2];
  if (sum == 0.0) return false;  // upright
  for (int k = 0; k < 3; ++k) {
    // On an edge: as for tiles.
    const int a = (k + 1) % 3, b = (k + 2) % 3;
    const double dz = pz[a] - pz[b];
    const bool beside = w[k] != 0.0 ? w[k] > 0.0 : dz != 0.0 ? dz > 0.0 : px[b] > px[a];
    if (beside != (sum > 0.0)) return false;
  }
  height = (w[0] * corner[0].y + w[1] * corner[1].y + w[2] * corner[2].y) / sum;
  up = !(sum > 0.0);
  return true;
}

VerticalLine::VerticalLine(glm::dvec3 place_steps)
    : x(std::floor(place_steps.x / kGrain + 0.5) * kGrain),
      z(std::floor(place_steps.z / kGrain + 0.5) * kGrain) {}

}  // namespace karst::core
