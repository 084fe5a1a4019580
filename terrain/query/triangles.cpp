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

VerticalLine::VerticalLine(glm::dvec3 place_steps)
    : x(std::floor(place_steps.x / kGrain + 0.5) * kGrain),
      z(std::floor(place_steps.z / kGrain + 0.5) * kGrain) {}

}  // namespace karst::core
