// SPDX-License-Identifier: MIT
// The belt: the strip in the region's four sides between its rim and that of the ground around it, drawn
// with the vertices of both. A piece of it lies at a half of a node's edge (of size 0, at all of it): between
// the node's vertices there and those of the patches between the same two upright lines, each at what it is
// drawn at. So every edge of either rim is used once by its side and once by the belt, the other way, and
// the upright edges between pieces by the two that meet there: there is no gap, whatever moves.
//
// Of an isosurface pieces end at the first points of its rim that are not before those lines: a coarse mesh
// has no vertex in them. All lie in the side, so nothing gapes there either.
//
// Triangles face as the rim does: outwards where the region stands above the ground, inwards where below.
// Where the two rims all but meet, or the eye is within a few steps of a side's plane, they are thinner than
// rasterisers place corners, and face as their rounded corners do.
#pragma once

#include <cstdint>
#include <span>

#include "terrain/blocks/block_rim.h"
#include "terrain/nodes/ground_view.h"
#include "terrain/regions/region_rim.h"
#include "terrain/resident/page_table.h"
#include "terrain/surface/patch.h"

namespace karst::core {

struct BuildBelts {
  // Inputs, borrowed.
  const GroundInfo* info = nullptr;
  std::size_t region = 0;          // its number in info
  const RegionRim* rim = nullptr;  // built of it; or, where an isosurface stands there:
  const BlockRim* blocks = nullptr;
  const GroundView* view = nullptr;  // selected, with the region drawn
  // By patch of the region: what it is drawn at, and what it is held at; the lesser counts. 0: its part of
  // the rim is left out.
  std::span<const std::uint8_t> levels, resident;
  PageTable pages;                    // first_page of the region's patches; texels are not used
  std::uint32_t first_node_page = 0;  // of the buffer of vertices
  std::uint32_t first_mesh_page = 0;  // of it; where blocks is set: levels, resident and pages are not used

  // Output, borrowed: of the buffer's vertices, three a triangle. room() holds all.
  std::span<std::uint32_t> out;

  static constexpr std::size_t room(std::uint32_t rim_edges, int max_level) {
    return std::size_t{3} * rim_edges * ((std::size_t{1} << max_level) + kNodeQuads);
  }
  // Returns how many indices were written; pieces for which there is no room are left out.
  std::size_t run() const;

 private:
  struct Piece;
  template <class Rim>
  std::size_t run_along(const Rim& line) const;
  std::size_t fill_loops(std::span<std::uint32_t> to) const;
  template <class Walk>
  std::size_t write(Walk walk, const Piece& piece, std::span<std::uint32_t> to) const;
};

}  // namespace karst::core
