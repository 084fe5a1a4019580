// SPDX-License-Identifier: MIT
// Sky visibility: how much of the sky is seen from each cell of a grid over the world, as the share of 240
// directions above the horizon in which nothing is in the way. It darkens what lies deep (ambient occlusion)
// and tells caves from open ground.
//
//   sky.create(storage);  sky.build(octree, extent);  sky.at({x, y, z});  // 0 .. 255
//
// Directions are spread evenly over the hemisphere: they count alike, whichever way a surface faces. Weights
// by the cosine from the zenith would be right for level ground only, and black below arches, which are lit
// from the side.
//
// A ray is a chain of cells, each of which shares a face with the next, so that none slips through the edges
// of a closed wall. All rays of a direction have the same moves in a layer, so they are followed a layer at a
// time, from the top, 64 cells at once: a bit is a ray that reaches the sky, a move is a shift. The work is
// some 7 operations a direction and word; all of it is integers, the same bits everywhere. An edit changes
// what lies below it and aside, so everything is built anew, in steps.
//
// The world is open at its sides. The topmost layer lies above everything, so that all of it is 255.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "terrain/base/lattice.h"
#include "terrain/field/octree.h"

namespace karst::core {

// Cells over a world: cell (x, y, z) is a cube of 2^cell_log2 voxels from (x, y, z) << cell_log2.
struct SkyGrid {
  glm::ivec3 cells{1};
  int cell_log2 = kMaxDepth;

  float cell_voxels() const { return static_cast<float>(1 << cell_log2); }
  // Cells in memory: rows along x, in whole 4 bytes, then along z, then along y. They upload as the texels of
  // a texture whose axes are x, z, y.
  std::size_t row_bytes() const { return (static_cast<std::size_t>(cells.x) + 3) / 4 * 4; }
  std::size_t bytes() const {
    return row_bytes() * static_cast<std::size_t>(cells.y) * static_cast<std::size_t>(cells.z);
  }
  std::size_t place(glm::ivec3 cell) const {
    return static_cast<std::size_t>(cell.y * cells.z + cell.z) * row_bytes() +
           static_cast<std::size_t>(cell.x);
  }

  friend bool operator==(const SkyGrid&, const SkyGrid&) = default;
};

class SkyVisibility {
 public:
  static constexpr int kDirections = 240;
  static constexpr std::size_t kMostBytes = 512 * 1024;  // of a grid
  static constexpr int kMostSide = 256;  // cells; the least GL_MAX_3D_TEXTURE_SIZE that ES 3.0 allows

  // The grid with the finest cells that fit kMostSide, kMostBytes, and `words` of storage; one open cell
  // where none does. extent: of the world, voxels.
  // least_log2: of its cells.
  static SkyGrid grid_for(glm::ivec3 extent, std::size_t words, int least_log2 = 0);
  // 64-bit words of storage that the finest grid takes.
  static std::size_t word_count(glm::ivec3 extent);

  // Lends memory, borrowed for the object's life.
  void create(std::span<std::uint64_t> storage) {
    storage_ = storage;
    behind_ = false;
    step_ = 0;
  }

  // With cells of this or larger ones: of an atlas.
  void set_least_cell(int cell_log2) { least_log2_ = cell_log2; }
  // Finds all of it anew. A cell larger than a voxel is filled where half of its voxels are.
  // opens_sides: towards the sides cells see more and more of the sky, and there all of it: beyond lies
  // ground that this grid knows nothing of, which lookups find in the outermost cells.
  void build(const Octree& octree, glm::ivec3 extent, bool opens_sides = false);

  // Voxels changed: cells() are of those before until steps have found them anew.
  void outdate() { behind_ = true; }
  bool is_behind() const { return behind_ || step_ > 0; }
  // A step, of some 10 microseconds to 1/200 of build(). room: as many words as of create(), the same ones
  // from step to step. Voxels may change between steps; cells() then are behind again. True: cells() are
  // others now. Precondition: is_behind().
  bool step(const Octree& octree, std::span<std::uint64_t> room);

  const SkyGrid& grid() const { return grid_; }
  std::span<const std::uint8_t> cells() const;
  // Of a cell of the grid. A filled one has the mean of the open ones of the 26 around it, so that lookups
  // between cells at its surface stay what they are in the open; 0 if there are none.
  std::uint8_t at(glm::ivec3 cell) const { return cells()[grid_.place(cell)]; }
  // The least that a lookup between the cells around a place (by linear interpolation, clamped to the grid)
  // gives anywhere in a box; voxels.
  std::uint8_t least_in(glm::vec3 low, glm::vec3 high) const;

 private:
  struct Rows;
  bool has_cells() const;
  void open_sides(std::uint8_t* cells) const;

  SkyGrid grid_;
  int least_log2_ = 0;
  bool opens_sides_ = false;
  bool behind_ = false;
  int step_ = 0;  // of finding it anew, 0: not begun
  std::span<std::uint64_t> storage_;
};

}  // namespace karst::core
