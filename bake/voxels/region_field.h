// SPDX-License-Identifier: MIT
// The field of a region of a ground, sampled from what stands there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "bake/elevation/solid.h"
#include "platform/base/error.h"
#include "terrain/isosurface/field_blocks.h"

namespace karst::bake {

class RegionField {
 public:
  static constexpr double kReachCells = 2;

  RegionField() = default;
  RegionField(const RegionField&) = delete;
  RegionField& operator=(const RegionField&) = delete;

  // Of the finest levels a side, blocks that coarser ones need: a region's sides are so many cells, or a
  // multiple.
  static constexpr int kSideCells = 64;

  // Samples 8-bit distances, 2^cells_log2 a voxel. grid: the region's, whose sides are blocks' (the first and
  // the last voxels' centres). steepest: how much the solid's value changes at most over a length.
  // column_log2: voxels of a node. An error where the surface is not one whose sides a ground can meet.
  Error sample(const Solid& solid, const WorldGrid& grid, int cells_log2, double steepest, int column_log2,
               int threads);

  const core::FieldBlocks& field() const { return field_; }
  // Vertices of its finest surface, voxels from the grid's corner; how many triangles, and edges of its rim.
  const std::vector<glm::dvec3>& points() const { return points_; }
  std::uint64_t triangles() const { return triangles_; }
  std::uint32_t rim_edges() const { return rim_edges_; }
  // Of a world file.
  std::uint64_t bytes() const;

 private:
  Error mesh(int column_log2);

  std::vector<std::uint32_t> table_;
  std::vector<std::byte> samples_;
  core::FieldBlocks field_;
  std::vector<glm::dvec3> points_;
  std::uint64_t triangles_ = 0;
  std::uint32_t rim_edges_ = 0;
};

}  // namespace karst::bake
