// SPDX-License-Identifier: MIT
// Two passes over the normals of a patch's triangles, which are exact in double: the axis is moved towards
// the normal farthest from it a few times (Badoiu and Clarkson, "Smaller core-sets for balls", 2003), then
// the rounded axis's widest angle is taken.
#include "terrain/measure/normal_cone.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "terrain/base/check.h"
#include "terrain/measure/level_triangles.h"
#include "terrain/patch/displacement.h"

namespace karst::core {
namespace {

// Moves of the axis. After eight the cone is within a few degrees of the narrowest.
constexpr int kMoves = 8;

// Finest level whose normals the axis is looked for among; it holds for all, but need not be the best.
constexpr int kAxisLevel = 3;

// Added to the sine, 127 of it being 1: 0.45 degrees, for what the GPU does to triangles of about a pixel's
// size and larger, moving their vertices to the subpixel grid. Smaller ones that turn over by it lie behind
// the same closed surface's front.
constexpr double kSineMargin = 1.0;

// Calls visit(normal) for every corner of the hull: twice the area long, of any length above 0. An edge to a
// coarser neighbour adds none: the triangle that stands on two sides there has the normal of the one whose
// border vertex has arrived in the middle between them.
template <class Visit>
void for_each_normal(const LevelGrid& grid, int full_level, int last_level, Visit visit) {
  const auto triangle = [&](glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    if (normal != glm::dvec3(0.0)) visit(normal);
  };
  for (int m = 1; m <= last_level; ++m) {
    for_each_level_triangle(grid, full_level, m, [&](const LevelTriangle& t, int) {
      const glm::dvec3 stay = grid.at(t.stay);
      const glm::dvec3 borders[2] = {grid.at(t.border), t.border_target};
      const glm::dvec3 centres[2] = {grid.at(t.centre), t.centre_target};
      // Vertices of level 1 do not move.
      const int states = m == 1 ? 1 : 2;
      for (int b = 0; b < states; ++b) {
        for (int c = 0; c < states; ++c) {
          if (t.ends_side) {
            triangle(borders[b], stay, centres[c]);
          } else {
            triangle(stay, borders[b], centres[c]);
          }
        }
      }
    });
  }
}

glm::dvec3 find_axis(const LevelGrid& grid, int level) {
  const int last = std::min(level, kAxisLevel);
  glm::dvec3 axis(0.0);
  for_each_normal(grid, level, last, [&](glm::dvec3 n) { axis += n * (1.0 / glm::length(n)); });
  const double length = glm::length(axis);
  if (!(length > 0.0)) return glm::dvec3(0.0);
  axis /= length;
  for (int move = 1; move <= kMoves; ++move) {
    glm::dvec3 farthest = axis;
    double least = 1.0;
    for_each_normal(grid, level, last, [&](glm::dvec3 n) {
      const double along = glm::dot(n, axis);
      // Signed squares compare cosines without a root each.
      const double share = along * std::fabs(along) / glm::dot(n, n);
      if (share < least) {
        least = share;
        farthest = n;
      }
    });
    axis = glm::normalize(axis + (glm::normalize(farthest) - axis) * (1.0 / (move + 1)));
  }
  return axis;
}

}  // namespace

NormalCone measure_normal_cone(const Surface& surface, const Heights& heights, PatchId patch) {
  LevelGrid grid;
  grid.side = patch_side(heights.level);
  displaced_positions(surface, heights, heights.level, patch, grid.position);
  const glm::dvec3 axis = find_axis(grid, heights.level);
  if (axis == glm::dvec3(0.0)) return {};
  NormalCone cone;
  for (int k = 0; k < 3; ++k) cone.axis[k] = static_cast<std::int8_t>(std::lround(127.0 * axis[k]));
  const glm::dvec3 rounded(cone.axis[0], cone.axis[1], cone.axis[2]);
  double most = 0.0;  // squared sine times the axis's length
  bool holds = true;
  for_each_normal(grid, heights.level, heights.level, [&](glm::dvec3 n) {
    const double along = glm::dot(n, rounded);
    holds = holds && along > 0.0;
    const glm::dvec3 across = glm::cross(n, rounded);
    most = std::max(most, glm::dot(across, across) / glm::dot(n, n));
  });
  const double sine = (std::sqrt(most) + kSineMargin) * (1.0 + 1e-9);
  const double units = std::ceil(sine / NormalCone::kSineUnit);
  // A cone whose sine reaches the axis's length holds half of all directions: nothing faces away from it.
  if (!holds || sine >= glm::length(rounded) || units >= NormalCone::kNone) return {};
  cone.sine = static_cast<std::uint8_t>(units);
  return cone;
}

Status MeasureNormalCones::validate() const {
  if (heights.level < 1 || heights.level > kMaxLevel) {
    return {StatusCode::invalid_argument, "not a level of detail", "heights"};
  }
  if (cones.size() != surface.patches.size()) {
    return {StatusCode::invalid_argument, "must hold one cone a patch", "cones"};
  }
  return {};
}

void MeasureNormalCones::run(PatchId first, PatchId last) const {
  KARST_ASSERT(validate().ok() && first <= last && last <= surface.patches.size());
  for (PatchId p = first; p < last; ++p) cones[p] = measure_normal_cone(surface, heights, p);
}

}  // namespace karst::core
