// SPDX-License-Identifier: MIT
// Writes the 32-bit index stream of a draw list: for each item the shared 16-bit table's ranges
// (index_batches.h), each index moved to the page of the one vertex buffer that holds the vertex. With it a
// whole pass is one draw call, or a few where the stream is written in chunks, in plain OpenGL ES 3.0, which
// has no base vertex and no multi-draw.
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/draw/draw_list.h"
#include "terrain/draw/index_batches.h"
#include "terrain/draw/mesh_items.h"
#include "terrain/draw/wall_indices.h"
#include "terrain/resident/page_table.h"

namespace karst::core {

struct ExpandIndices {
  // Inputs, borrowed.
  std::span<const std::uint16_t>
      table;  // build_index_tables(max_level), max_level at least every item's and node's
  std::span<const DrawItem> items;
  PageTable pages;  // texels are not used

  // Output, borrowed; may be write-only memory of the GPU: it is written once, in order, and never read.
  std::span<std::uint32_t> out;

  // Input, borrowed: nodes of the ground, which come after the items. A node's `patch` is the number of its
  // page, below node_pages, from first_node_page of the buffer on; its level has one page.
  std::span<const DrawItem> nodes = {};
  std::uint32_t first_node_page = 0;
  std::uint32_t node_pages = 0;
  // Input, borrowed: belts of regions, which come last: triangles of the buffer's vertices (terrain/regions).
  std::span<const std::uint32_t> belts = {};
  // Input, borrowed: meshes with indices of their own, which come behind all else, a page of indices at a
  // time.
  std::span<const MeshItem> meshes = {};
  MeshPages mesh_pages = {};

  struct Chunk {
    std::uint32_t indices = 0;  // written to the front of out: what to draw
    // Where to go on, counted through items, nodes, triangles of belts and pages of indices of meshes;
    // count() when all are done.
    std::uint32_t next_item = 0;
    // Items of this chunk whose patch has fewer pages than the level needs, and nodes without a page, which a
    // valid frame has none of: they are left out whole, because other vertices lie where theirs are not.
    std::uint32_t left_out = 0;
  };

  std::size_t count() const { return first_mesh_page() + mesh_index_pages(); }
  std::size_t first_mesh_page() const { return items.size() + nodes.size() + belts.size() / 3; }
  std::size_t mesh_index_pages() const {
    return meshes.empty() ? 0 : std::size_t{meshes.back().before} + meshes.back().index_pages();
  }

  // Room that out needs so that every chunk holds at least one item of a level up to max_level.
  static constexpr std::uint32_t least_room(int max_level) { return max_patch_indices(max_level); }
  // The same of a node with walls all around.
  static constexpr std::uint32_t kLeastNodeRoom = max_patch_indices(2) + 4 * kIndicesPerWall;

  // invalid_argument naming the first field that is empty or too small, for levels up to max_level.
  Status validate(int max_level) const;

  // Writes whole items from first_item on until out is full or they end. To draw a list:
  //   for (Chunk c; c.next_item < count();) { c = run(c.next_item); draw c.indices indices; }
  // Precondition: validate() is ok for the items' levels.
  Chunk run(std::uint32_t first_item) const;

 private:
  std::uint32_t copy_belts(Chunk& chunk, std::uint32_t* to, std::size_t room) const;
  void write_meshes(Chunk& chunk, std::uint32_t* to, std::size_t room) const;
};

}  // namespace karst::core
