// SPDX-License-Identifier: MIT
// The rim of a region (terrain/ground/ground.h): the edges of its patches that lie in its four sides, one
// closed line around it, and where that crosses the upright lines in which nodes of the ground have corners.
//
// Sides are numbered as edges of nodes (terrain/nodes/family_row.h): 0 west, walked to the south; 1 south, to
// the east; 2 east, to the north; 3 north, to the west: the region is on the left. Columns are the nodes of
// size 0 along a side, in the order of the walk, from 0 over all four sides.
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/arena.h"
#include "terrain/base/config.h"
#include "terrain/ground/ground.h"
#include "terrain/surface/patch.h"

namespace karst::core {

class RegionRim {
 public:
  struct Edge {
    PatchEdge edge;
    // Where it begins and ends along its side, half voxels from the side's first corner.
    std::int16_t from = 0, to = 0;
  };

  struct Storage {
    std::span<Edge> edges;
    std::span<std::uint32_t> marks;

    template <class Visit>
    void each_block(const Config& config, Visit&& visit) {
      visit(Consumer::ground, config.rim_edges, edges);
      visit(Consumer::ground, config.rim_edges, marks);
    }
  };
  void create(const Storage& storage) { storage_ = storage; }

  // Finds the rim of a surface that was just extracted. corrupt ("region") where it is not one line that
  // crosses each of those upright lines in a corner of a patch; limit_reached ("rim_edges") where it has more
  // edges than there is memory for. lattice_size: GroundInfo's.
  Status build(const GroundRegion& region, int lattice_size, const Surface& surface);
  // Edges of patches that have no neighbour.
  static std::uint32_t count(const Surface& surface);

  std::span<const Edge> edges() const { return storage_.edges.first(edge_count_); }
  // The edge that begins where a column does.
  std::uint32_t mark(std::uint32_t column) const { return storage_.marks[column]; }
  std::uint32_t columns() const { return column_count_; }
  std::uint32_t count() const { return edge_count_; }
  // The first column of a side; side 4: columns().
  std::uint32_t first_column(int side) const { return first_[side]; }

 private:
  Storage storage_;
  std::uint32_t edge_count_ = 0;
  std::uint32_t column_count_ = 0;
  std::uint32_t first_[5] = {};
};

}  // namespace karst::core
