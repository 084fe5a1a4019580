// SPDX-License-Identifier: MIT
#include "terrain/regions/region_rim.h"

#include <algorithm>
#include <iterator>

#include <glm/vec3.hpp>

#include "terrain/patch/corner_fan.h"
#include "terrain/surface/bezier/case_tables.h"

namespace karst::core {
namespace {

// Where corner c of a patch lies, half voxels from the octree's corner.
glm::ivec3 corner_place(const Surface& surface, PatchId id, int corner) {
  const Volume& volume = surface.volume_of(id);
  const PatchCase& shape = kCaseTable[volume.configuration].patch[surface.patches[id].case_patch];
  const int i = corner == 1 || corner == 2 ? 2 : 0;
  const int j = corner == 2 || corner == 3 ? 2 : 0;
  const auto& control = shape.control[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)];
  return {2 * volume.corner[0] + control[0], 2 * volume.corner[1] + control[1],
          2 * volume.corner[2] + control[2]};
}

bool is_border(const Patch& patch, int edge) {
  return patch.volume != kNoVolume && !patch.neighbour[edge].exists() && !(patch.collapsed != 0 && edge == 3);
}

// The border edge that goes on where this one ends; none: the surface is not a surface.
PatchEdge next_border(const Surface& surface, PatchEdge at) {
  const auto after = [&](PatchId id, int edge) {
    const int next = (edge + 1) & 3;
    return surface.patches[id].collapsed != 0 && next == 3 ? 0 : next;
  };
  PatchId id = at.patch();
  int edge = after(id, at.edge());
  for (int n = 0; n < kMaxCornerFan; ++n) {
    const PatchEdge across = surface.patches[id].neighbour[edge];
    if (!across.exists()) return PatchEdge::make(id, edge);
    id = across.patch();
    edge = after(id, across.edge());
  }
  return {};
}

// Half voxels along the sides of a rectangle.
struct Sides {
  int low[2], high[2];

  // From the first corner of a side on; side numbers as in the header.
  int along(int side, glm::ivec3 place) const {
    switch (side) {
      case 0:
        return place.z - low[1];
      case 1:
        return place.x - low[0];
      case 2:
        return high[1] - place.z;
      default:
        return high[0] - place.x;
    }
  }
  bool lies_in(int side, glm::ivec3 place) const {
    switch (side) {
      case 0:
        return place.x == low[0];
      case 1:
        return place.z == high[1];
      case 2:
        return place.x == high[0];
      default:
        return place.z == low[1];
    }
  }
  int length(int side) const { return side % 2 == 0 ? high[1] - low[1] : high[0] - low[0]; }
};

Status corrupt_region(const char* what) {
  return {StatusCode::corrupt, what, "region"};
}

}  // namespace

std::uint32_t RegionRim::count(const Surface& surface) {
  std::uint32_t count = 0;
  for (const Patch& patch : surface.patches) {
    for (int edge = 0; edge < 4; ++edge) count += is_border(patch, edge) ? 1u : 0u;
  }
  return count;
}

Status RegionRim::build(const GroundRegion& region, int lattice_size, const Surface& surface) {
  edge_count_ = column_count_ = 0;
  std::fill(std::begin(first_), std::end(first_), 0u);
  const std::uint32_t total = count(surface);
  if (total > storage_.edges.size())
    return {StatusCode::limit_reached, "the region's rim is longer than a limit", "rim_edges", total};
  const int node = 2 << lattice_size;  // half voxels
  Sides sides{};
  for (int axis = 0; axis < 2; ++axis) {
    sides.low[axis] = 1;
    sides.high[axis] = 1 + (region.nodes.high[axis] - region.nodes.low[axis]) * node;
  }
  for (int side = 0; side < 4; ++side)
    first_[side + 1] = first_[side] + static_cast<std::uint32_t>(sides.length(side) / node);
  if (first_[4] > storage_.marks.size())
    return corrupt_region("its rim has fewer edges than nodes of the ground lie at it");

  PatchEdge start;
  for (PatchId id = 0; id < surface.patches.size() && !start.exists(); ++id) {
    for (int edge = 0; edge < 4; ++edge) {
      if (!is_border(surface.patches[id], edge)) continue;
      const glm::ivec3 from = corner_place(surface, id, edge);
      const glm::ivec3 to = corner_place(surface, id, (edge + 1) & 3);
      if (sides.lies_in(0, from) && sides.along(0, from) == 0 && sides.lies_in(0, to))
        start = PatchEdge::make(id, edge);
    }
  }
  if (!start.exists()) return corrupt_region("its rim has no corner in its north-west");
  PatchEdge at = start;
  int side = 0;
  std::uint32_t column = 0;
  std::uint32_t made = 0;
  do {
    if (made == total || !at.exists()) return corrupt_region("its rim does not close");
    const glm::ivec3 from = corner_place(surface, at.patch(), at.edge());
    const glm::ivec3 to = corner_place(surface, at.patch(), (at.edge() + 1) & 3);
    if (side < 3 && sides.along(side, from) == sides.length(side)) ++side;
    if (!sides.lies_in(side, from) || !sides.lies_in(side, to))
      return corrupt_region("its rim leaves its sides");
    const int along = sides.along(side, from);
    if (column < first_[side + 1] && along == static_cast<int>(column - first_[side]) * node)
      storage_.marks[column++] = made;
    storage_.edges[made++] = {at, static_cast<std::int16_t>(along),
                              static_cast<std::int16_t>(sides.along(side, to))};
    at = next_border(surface, at);
  } while (!(at == start));
  if (made != total) return corrupt_region("its sides are cut below the ground");
  if (column != first_[4]) return corrupt_region("its rim has no corner in an upright line of nodes");
  edge_count_ = made;
  column_count_ = column;
  return {};
}

}  // namespace karst::core
