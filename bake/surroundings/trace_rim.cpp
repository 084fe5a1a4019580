// SPDX-License-Identifier: MIT
#include "bake/surroundings/trace_rim.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <glm/common.hpp>

#include "terrain/base/lattice.h"
#include "terrain/patch/displacement.h"

namespace karst::bake {
namespace {

constexpr int kPointsPerVoxel = 4;
// Voxels that a vertex must be higher by to be taken instead of one that is nearer to the point by a voxel.
constexpr double kSteep = 2.0;
// Of places that are exact but for the rounding of doubles.
constexpr double kSame = 1e-6;

struct RimPoint {
  glm::ivec3 position{0};  // lattice steps
  double score = 0;
  bool found = false;
};

// One side of the world, along x or z, the lower or the upper one.
struct Side {
  int along, across;
  double place;  // voxels on the axis across
  std::vector<RimPoint> points;

  Side(int along_axis, bool upper, glm::ivec3 extent) : along(along_axis), across(2 - along_axis) {
    place = upper ? extent[across] - 0.5 : 0.5;
    points.resize(static_cast<std::size_t>(kPointsPerVoxel * (extent[along] - 1) + 1));
  }

  bool holds(glm::dvec3 base) const { return std::abs(base[across] - place) < kSame; }

  // base: the vertex before it is displaced, voxels.
  void offer(glm::dvec3 base, glm::ivec3 position) {
    const double at = (base[along] - 0.5) * kPointsPerVoxel;
    const double nearest = std::round(at);
    if (!(nearest >= 0 && nearest < static_cast<double>(points.size()))) return;
    RimPoint& point = points[static_cast<std::size_t>(nearest)];
    const double score =
        position.y / double{kStepsPerVoxel} - kSteep * std::abs(at - nearest) / kPointsPerVoxel;
    if (point.found && point.score >= score) return;
    point = {position, score, true};
  }

  // False where no point was found.
  bool close() {
    const auto found = [](const RimPoint& p) { return p.found; };
    const auto first = std::find_if(points.begin(), points.end(), found);
    if (first == points.end()) return false;
    std::fill(points.begin(), first, *first);
    for (auto from = first; from != points.end();) {
      const auto to = std::find_if(from + 1, points.end(), found);
      const auto gap = static_cast<double>(to - from);
      for (auto p = from + 1; p != to; ++p) {
        const double share = to == points.end() ? 0.0 : static_cast<double>(p - from) / gap;
        const glm::dvec3 end = to == points.end() ? from->position : to->position;
        p->position = glm::ivec3(glm::round(glm::mix(glm::dvec3(from->position), end, share)));
      }
      from = to;
    }
    return true;
  }
};

}  // namespace

std::vector<glm::ivec3> trace_rim(const Surface& surface, const Heights& heights, glm::ivec3 extent) {
  // North, east, south, west.
  Side sides[] = {{0, false, extent}, {2, true, extent}, {0, true, extent}, {2, false, extent}};
  const int level = heights.level;
  std::vector<glm::ivec3> positions(static_cast<std::size_t>(patch_vertices(level)));
  for (PatchId id = 0; id < surface.patches.size(); ++id) {
    const Patch& patch = surface.patches[id];
    bool placed = false;
    const glm::ivec3 origin = patch_origin(surface.volume_of(id));
    for (int e = 0; e < 4; ++e) {
      if (patch.neighbour[e].exists() || (e == 3 && patch.collapsed != 0)) continue;
      const GridLine line = GridLine::along_edge(e, 0, level, false);
      const auto base = [&](int t) {
        return base_point(surface, level, id, line.i0 + t * line.di, line.j0 + t * line.dj).position +
               glm::dvec3(origin) / double{kStepsPerVoxel};
      };
      for (Side& side : sides) {
        if (!side.holds(base(0)) || !side.holds(base(patch_cells(level)))) continue;
        if (!placed) displaced_positions(surface, heights, level, id, positions);
        placed = true;
        for (int t = 0; t <= patch_cells(level); ++t) {
          const int vertex = (line.j0 + t * line.dj) * patch_side(level) + line.i0 + t * line.di;
          side.offer(base(t), origin + positions[static_cast<std::size_t>(vertex)]);
        }
      }
    }
  }
  std::vector<glm::ivec3> rim;
  for (Side& side : sides) {
    if (!side.close()) return {};
    const bool back = &side >= sides + 2;
    const std::size_t last = side.points.size() - 1;  // the next side's first
    for (std::size_t n = 0; n < last; ++n) rim.push_back(side.points[back ? last - n : n].position);
  }
  return rim;
}

}  // namespace karst::bake
