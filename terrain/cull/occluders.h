// SPDX-License-Identifier: MIT
// Rock that hides: cells of the voxel grid that nothing which can be drawn ever enters, filled ones (rock)
// and empty ones (air). A box is hidden where all rays to it come from air, through a rectangle of rock.
//
// Why. Let the box of a patch hold all its displaced vertices and its undisplaced control points. Everything
// drawn of it lies in the box, at every level and in every state of its morph, and so does the straight way
// from the undisplaced surface to it. A point outside all boxes therefore stays on one side of the drawn
// surface while that is moved from the undisplaced one, and is inside where its voxel is filled and outside
// where it is empty. A ray from a point outside to one inside crosses the surface from its front on the way,
// and what lies behind the rectangle is farther away by a cell at least. So that crossing hides it, if it is
// drawn: it faces the eye, and it is in view; and if its patch is hidden itself, then by a crossing that is
// nearer still, and so on to one that is drawn.
//
// Where a ray comes from air: the eye is outside and far enough from the surface (is_outside), or it passes a
// rectangle of cells of air first, beyond the near plane.
//
// What the argument needs, and where it comes from:
//  - No open edge of the surface near the ray. The surface ends at the sides and the bottom of a world: all
//    that is between air and rock must lie in a box that no patch with an open edge reaches into
//    (interior()). It is convex, so it holds the rays between two of its points; it has no top, because the
//    surface has no open edge there.
//  - What is in front of the near plane is not drawn. An eye counts as outside only where no patch's box
//    comes nearer to it than the corners of the near plane; else air has to lie beyond them.
//  - The GPU moves vertices to its subpixel grid, and what hides must still cover what is hidden. Boxes are
//    taken kMargin larger here, and boxes asked for by 2^-12 of their distance.
//  - Depths differ by more than the depth buffer's steps: a cell is kept, and boxes beyond reach_of_depth are
//    never hidden.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/cull/bounds_tree.h"
#include "terrain/field/octree.h"
#include "terrain/patch/bounds.h"
#include "terrain/surface/patch.h"

namespace karst::core {

// All that a patch's displaced surface, and its way there from the undisplaced one, can touch, and a margin.
LatticeBox swept_box(const Surface& surface, std::span<const PatchBounds> bounds, PatchId id);

class Occluders {
 public:
  // Lattice steps around everything drawn: a subpixel of a picture 64 pixels high at the largest world's
  // size.
  static constexpr std::int32_t kMargin = 128;

  // The finest cells are half a voxel: rock then begins a cell behind the boxes of the surface, not a voxel.
  // Quarters hide little more, for eight times the memory.
  static constexpr int kLeastCellLog2 = -1;

  enum class Kind : std::uint8_t { rock, air };

  // 64-bit words for a world of so many voxels with cells of 2^cell_log2 voxels a side, from kLeastCellLog2:
  // four bits a cell.
  static std::size_t word_count(glm::ivec3 extent, int cell_log2);

  // Lends memory, borrowed for the object's life.
  void create(std::span<std::uint64_t> storage) {
    storage_ = storage;
    clear();
  }
  void clear() { size_ = glm::ivec3(0); }

  // Finds the cells anew, as small as the memory allows; a cell larger than a voxel is of a kind where all of
  // its voxels are. Without memory for any there are none, which is no error. tree: over surface and bounds.
  void build(const Octree& octree, glm::ivec3 extent, const Surface& surface,
             std::span<const PatchBounds> bounds);

  // After a change: what build() would find, as long as all that differs lies in a box, lattice steps, of
  // which what patches sweep before and after is a part: swept_box(), or what holds it. changed: patches that
  // are others now. sides: whether some at the world's sides are, or were. tree: up to date. Precondition:
  // built for an octree of the same extent.
  void update(const Octree& octree, const Surface& surface, std::span<const PatchBounds> bounds,
              const BoundsTree& tree, std::span<const PatchId> changed, const LatticeBox& box, bool sides);

  bool empty() const { return size_.x == 0; }
  glm::ivec3 size() const { return size_; }  // in cells
  int cell_log2() const { return cell_log2_; }
  float cell_steps() const { return static_cast<float>(1 << (kLatticeBits + cell_log2_)); }
  std::uint64_t count(Kind kind) const;

  // Whether all cells of a layer across an axis within low..high of the other two axes, both included, are of
  // a kind. The two are in the order y, z for x; z, x for y; y, x for z. Cells outside the grid are of none.
  bool covers(Kind kind, int axis, int layer, glm::ivec2 low, glm::ivec2 high) const;

  // Whether a cell is rock. False outside the grid.
  bool is_rock(glm::ivec3 cell) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (static_cast<unsigned>(cell[axis]) >= static_cast<unsigned>(size_[axis])) return false;
    }
    const std::uint64_t* const rows = bits_[static_cast<std::size_t>(Kind::rock)].along_x.data();
    return (rows[(cell.y * size_.z + cell.z) * words_x_ + cell.x / 64] >> (cell.x % 64) & 1u) != 0;
  }

  // Whether the eye (lattice steps) and everything up to `reach` steps from it are outside the surface, and
  // in interior().
  bool is_outside(const Octree& octree, const BoundsTree& tree, const Surface& surface,
                  std::span<const PatchBounds> bounds, glm::dvec3 eye, double reach) const;
  const LatticeBox& interior() const { return interior_; }

 private:
  // Rows of bits.
  struct Bits {
    std::span<std::uint64_t> along_x;  // [y][z], bits x
    std::span<std::uint64_t> along_z;  // [y][x], bits z
  };

  void clear_cells(Kind kind, glm::ivec3 low, glm::ivec3 high);
  void clear_cells(glm::ivec3 low, glm::ivec3 high) {
    clear_cells(Kind::rock, low, high);
    clear_cells(Kind::air, low, high);
  }
  void fill_cells(glm::ivec3 low, glm::ivec3 high);
  // Of leaves in cells low..high.
  void clear_leaves(const Octree& octree, Octree::Node node, glm::ivec3 origin, int size, glm::ivec3 low,
                    glm::ivec3 high);
  void renew(const Octree& octree, const Surface& surface, std::span<const PatchBounds> bounds,
             const BoundsTree& tree, glm::ivec3 low, glm::ivec3 high);
  void clear_outside(glm::ivec3 first, glm::ivec3 last);
  void widen(const Surface& surface, std::span<const PatchBounds> bounds, PatchId id);
  void find_interior(const Surface& surface, std::span<const PatchBounds> bounds, glm::ivec3 extent);

  std::span<std::uint64_t> storage_;
  Bits bits_[2];  // by kind
  glm::ivec3 size_{0};
  int cell_log2_ = 0;
  int words_x_ = 0;  // a row
  int words_z_ = 0;
  glm::ivec3 extent_{0};
  LatticeBox interior_;
  // Most that a patch's control points stick out of its box, with kMargin; steps. Updates never lower it.
  std::int32_t widest_ = 0;
};

// How far, in lattice steps, a depth buffer of 24 bits still tells surfaces a voxel apart: z^2 / (near 2^24)
// is at most a quarter.
inline double reach_of_depth(double near_voxels) {
  return std::sqrt(near_voxels * 0x1p22) * kStepsPerVoxel;
}

}  // namespace karst::core
