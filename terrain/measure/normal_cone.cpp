// SPDX-License-Identifier: MIT
// Two passes over the normals of a patch's triangles, which are exact in double: the axis is moved towards
// the normal farthest from it a few times (Badoiu and Clarkson, "Smaller core-sets for balls", 2003), then
// the rounded axis's widest angle is taken.
#include "terrain/measure/normal_cone.h"

#include <algorithm>

#include <glm/geometric.hpp>

#include "terrain/base/check.h"
#include "terrain/base/simd.h"
#include "terrain/measure/level_triangles.h"

namespace karst::core {
namespace {

using simd::Double2;

// Moves of the axis. After eight the cone is within a few degrees of the narrowest.
constexpr int kMoves = 8;

// Finest level whose normals the axis is looked for among; it holds for all, but need not be the best.
constexpr int kAxisLevel = 3;

// Added to the sine, 127 of it being 1: 0.45 degrees, for what the GPU does to triangles of about a pixel's
// size and larger, moving their vertices to the subpixel grid. Smaller ones that turn over by it lie behind
// the same closed surface's front.
constexpr double kSineMargin = 1.0;

// Normals that an axis is looked for among: those of four states of each triangle of levels 2 .. kAxisLevel,
// and of the eight of level 1.
constexpr int kMostNormals = 8 + 4 * (32 + 128);

struct Normals {
  double x[kMostNormals + 1], y[kMostNormals + 1], z[kMostNormals + 1];
  double squared[kMostNormals + 1];  // lengths
  int count = 0;

  glm::dvec3 at(int n) const { return {x[n], y[n], z[n]}; }
  void add(glm::dvec3 n) {
    x[count] = n.x;
    y[count] = n.y;
    z[count] = n.z;
    squared[count++] = glm::dot(n, n);
  }
};

// Calls visit(normal) for every corner of the hull: twice the area long, of any length above 0. An edge to a
// coarser neighbour adds none: the triangle that stands on two sides there has the normal of the one whose
// border vertex has arrived in the middle between them.
template <class Visit>
void for_each_normal(const LevelGrid& grid, int last_level, Visit visit) {
  const auto triangle = [&](glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    if (normal != glm::dvec3(0.0)) visit(normal);
  };
  for (int m = 1; m <= last_level; ++m) {
    for_each_level_triangle(grid, m, [&](const LevelTriangle& t, int) {
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

// The first of the normals farthest from the axis, or -1: none is beside it.
int find_farthest(const Normals& normals, glm::dvec3 axis) {
  // Signed squares compare cosines without a root each.
  const auto share = [&](int k) {
    const Double2 along = axis.x * simd::load(normals.x + k) + axis.y * simd::load(normals.y + k) +
                          axis.z * simd::load(normals.z + k);
    return along * simd::max(along, -along) / simd::load(normals.squared + k);
  };
  Double2 least = simd::splat(1.0);
  int from[2] = {-1, -1};  // where a lane has it from
  for (int k = 0; k < normals.count; k += 2) {
    const Double2 here = share(k);
    const simd::Long2 less = here < least;
    if (!simd::any(less)) continue;
    for (int lane = 0; lane < 2; ++lane) from[lane] = less[lane] != 0 ? k + lane : from[lane];
    least = simd::min(least, here);
  }
  if (from[0] < 0 || from[1] < 0) return std::max(from[0], from[1]);
  if (least[0] == least[1]) return std::min(from[0], from[1]);
  return least[0] < least[1] ? from[0] : from[1];
}

glm::dvec3 find_axis(const LevelGrid& grid) {
  Normals normals;
  for_each_normal(grid, std::min(grid.level, kAxisLevel), [&](glm::dvec3 n) { normals.add(n); });
  if (normals.count % 2 != 0) {  // the last one again, after it
    normals.add(normals.at(normals.count - 1));
    --normals.count;
  }
  glm::dvec3 axis(0.0);
  for (int k = 0; k < normals.count; k += 2) {
    const Double2 per_length = 1.0 / simd::sqrt(simd::load(normals.squared + k));
    axis += normals.at(k) * per_length[0];
    if (k + 1 < normals.count) axis += normals.at(k + 1) * per_length[1];
  }
  const double length = glm::length(axis);
  if (!(length > 0.0)) return glm::dvec3(0.0);
  axis /= length;
  for (int move = 1; move <= kMoves; ++move) {
    const int found = find_farthest(normals, axis);
    const glm::dvec3 farthest = found < 0 ? axis : normals.at(found);
    axis = glm::normalize(axis + (glm::normalize(farthest) - axis) * (1.0 / (move + 1)));
  }
  return axis;
}

// What an axis has to hold. The centre of a triangle's tile at home and arrived are two lanes.
struct Widest {
  glm::dvec3 axis;
  Double2 most = simd::splat(0.0);  // squared sine times the axis's length
  simd::Long2 beyond = {0, 0};      // a quarter turn and more

  void add(glm::dvec3 stay, glm::dvec3 border, const Double2 (&centre)[3], bool turned) {
    const glm::dvec3 e = turned ? stay - border : border - stay;
    const glm::dvec3 from = turned ? border : stay;
    const Double2 fx = centre[0] - from.x, fy = centre[1] - from.y, fz = centre[2] - from.z;
    // Integers, which doubles hold exactly.
    const Double2 x = e.y * fz - e.z * fy;
    const Double2 y = e.z * fx - e.x * fz;
    const Double2 z = e.x * fy - e.y * fx;
    const Double2 squared = x * x + y * y + z * z;
    const Double2 along = x * axis.x + y * axis.y + z * axis.z;
    // Those of no length count for nothing.
    beyond |= (along <= 0.0) & (squared > 0.0);
    const Double2 ax = y * axis.z - z * axis.y;
    const Double2 ay = z * axis.x - x * axis.z;
    const Double2 az = x * axis.y - y * axis.x;
    most = simd::max(most, (ax * ax + ay * ay + az * az) / simd::max(squared, simd::splat(1.0)));
  }
};

void find_widest(const LevelGrid& grid, Widest& widest) {
  for (int m = 1; m <= grid.level; ++m) {
    for_each_level_side(grid, m, [&](const LevelSide& side, int) {
      const glm::dvec3 borders[2] = {grid.at(side.border), side.border_target};
      const glm::dvec3 home = grid.at(side.centre);
      // Vertices of level 1 do not move.
      const glm::dvec3 arrived = m == 1 ? home : side.centre_target;
      const Double2 centre[3] = {{home.x, arrived.x}, {home.y, arrived.y}, {home.z, arrived.z}};
      for (int b = 0; b < (m == 1 ? 1 : 2); ++b) {
        widest.add(grid.at(side.stay[0]), borders[b], centre, false);
        widest.add(grid.at(side.stay[1]), borders[b], centre, true);
      }
    });
  }
}

}  // namespace

NormalCone measure_normal_cone(const Surface& surface, const Heights& heights, PatchId patch) {
  return measure_normal_cone(LevelGrid(surface, heights, patch));
}

NormalCone measure_normal_cone(const LevelGrid& grid) {
  const glm::dvec3 axis = find_axis(grid);
  if (axis == glm::dvec3(0.0)) return {};
  NormalCone cone;
  for (int k = 0; k < 3; ++k) cone.axis[k] = static_cast<std::int8_t>(std::lround(127.0 * axis[k]));
  const glm::dvec3 rounded(cone.axis[0], cone.axis[1], cone.axis[2]);
  Widest widest{.axis = rounded};
  find_widest(grid, widest);
  const double most = std::max(widest.most[0], widest.most[1]);
  const bool holds = !simd::any(widest.beyond);
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
