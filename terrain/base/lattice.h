// SPDX-License-Identifier: MIT
// The one integer lattice that every vertex lies on (design 4.3). Positions are measured from the octree's
// minimum corner. Axes: right-handed, y up; x and z span the ground.
#pragma once

#include <cstdint>

namespace karst::core {

inline constexpr int kLatticeBits = 13;
inline constexpr std::int32_t kStepsPerVoxel = 1 << kLatticeBits;  // lattice steps
// Lattice steps; the unit of control points.
inline constexpr std::int32_t kStepsPerHalfVoxel = kStepsPerVoxel / 2;

// Vertices lie on even steps. The midpoint of two vertices is then a lattice point, so that a vertex which
// has morphed there lies exactly on the coarser surface, and dropping it changes nothing.
inline constexpr int kVertexStepLog2 = 1;
inline constexpr std::int32_t kVertexStep = 1 << kVertexStepLog2;  // lattice steps

inline constexpr int kMaxDepth = 9;  // octree levels below the root (K 3.3.1: 9 bits an axis)
inline constexpr int kMaxLevel = 6;  // finest level of detail: (2^6 + 1)^2 vertices a patch

// Vertices of a patch at a level of detail: (2^level + 1) a side.
constexpr int patch_cells(int level) {
  return 1 << level;
}
constexpr int patch_side(int level) {
  return (1 << level) + 1;
}
constexpr int patch_vertices(int level) {
  return patch_side(level) * patch_side(level);
}
constexpr int patch_triangles(int level) {
  return 2 * patch_cells(level) * patch_cells(level);
}

}  // namespace karst::core
