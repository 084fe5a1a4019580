// SPDX-License-Identifier: MIT
// How far a region and the ground that stands for it may be apart after edits of either, more than their file
// says (RegionMeasure): the ground from the nearest point of the region, and what rises above the ground from
// it. An upper bound, E being the file's, from voxels and ground in the columns that edits have changed:
//
// * From a point of the ground the surface lies no further than the next voxel of the other kind along any
//   line, but for what surface and voxels, and places in one column, are apart. L is the most of all those
//   columns. An edit may lengthen such ways beside it, but of none that is not within L of it.
// * A point of the ground beside those columns may have lost the point of the surface that was nearest to it,
//   E away at most, to an edit. From where that way enters the columns, stretch E along the ground at most,
//   it is L to the surface again; stretch is sqrt(1 + s^2) where s is the ground's slope.
//
// So what they are apart is stretch E + L at most, and never more than both are wide. Nor is it more than L
// of all columns, which follows from what is there alone, however it came to be: it takes a while to find,
// and is found when there is time.
#pragma once

#include <cstddef>
#include <span>

#include "terrain/edit/ground/edit_ground.h"
#include "terrain/world/world.h"

namespace karst::core {

// L of all columns of a region, row by row.
struct ColumnsOfRegion {
  std::size_t region = 0;
  int row = 0;  // the next one
  double most = 0, stretch = 1;
};

struct FindRegionGrowth {
  // Inputs, borrowed.
  const World* world = nullptr;
  EditGround* ground = nullptr;  // the world's; the region is reserved
  std::size_t region = 0;
  LatticeBox box{};  // that the last edit changed, of voxels, heights and ground; from the region's corner

  // Of all edits. Where the ground cannot be read it is the most that there can be.
  RegionGrowth run() const;
  // RegionGrowth::now of a growth.
  RegionMeasure now(const RegionGrowth& growth) const;
  // A row of columns; box is not looked at. Returns whether it was the last one.
  bool step(ColumnsOfRegion& columns) const;
  // The ground's growth with L of all columns.
  RegionGrowth run(const ColumnsOfRegion& columns) const;

 private:
  struct Ground;
  Status measure(RegionGrowth& growth) const;
  double surface_off(glm::dvec2 low, glm::dvec2 high) const;
  double column_way(int x, int z, double height, double enough) const;
};

}  // namespace karst::core
