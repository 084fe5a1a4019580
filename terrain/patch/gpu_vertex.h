// SPDX-License-Identifier: MIT
// The 16 bytes a vertex takes on the GPU (design 4.5), and the order of vertices inside a patch's slot.
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/lattice.h"
#include "terrain/surface/patch_extent.h"

namespace karst::core {

// position, morph: lattice steps from the patch's origin, +-4 voxels. normal, morph_normal: octahedral.h. Two
// attributes of ivec4 on the GPU.
struct GpuVertex {
  std::int16_t position[3];
  std::uint16_t normal;
  std::int16_t
      morph[3];  // where the vertex goes before its level is dropped: the midpoint of its two parents
  std::uint16_t morph_normal;  // of meshes: materials (terrain/isosurface/field_materials.h)

  friend bool operator==(const GpuVertex&, const GpuVertex&) = default;
};
static_assert(sizeof(GpuVertex) == 16);

// Vertices of a patch are stored level by level: the (2^k + 1)^2 vertices of level k come first, so one index
// table a level serves every resident level, and raising the resident level only appends. Inside level m > 1
// they are in row order of the rows of level m; level 1 starts with its nine vertices in row order.
// (i, j) are in 0..2^level, at the grid of that level. Returns the index in the slot.
// (i, j) at one level and (2i, 2j) at the next are the same vertex and have the same index.
int vertex_order(int level, int i, int j);

// Of the vertices that level m adds to a slot, first .. last - 1: those that may be others where places or
// normals in these rows are. Rows are of the full level `level`; 1 <= m <= level.
struct SlotRange {
  int first = 0;
  int last = 0;
};
SlotRange vertices_of_rows(int level, int m, GridRows rows);

// The same for a whole level (1..kMaxLevel) at once: out[j * patch_side(level) + i] = vertex_order(level, i,
// j). out holds at least patch_vertices(level) values; what lies beyond is untouched.
Status build_vertex_order(int level, std::span<std::uint16_t> out);

// The inverse: out[vertex_order(level, i, j)] = j * patch_side(level) + i. Shapes and errors as above.
Status build_grid_order(int level, std::span<std::uint16_t> out);

}  // namespace karst::core
