// SPDX-License-Identifier: MIT
// How far a patch strays from its full level when it is drawn coarser or is on the way there (E(j) of design
// 4.7). Measured once, when heights are made; thresholds for any view follow from it (terrain/lod/morph.h).
//
// A triangle of level m has one corner of a coarser level, which stays, and two vertices of level m, which
// move to their morph targets, the midpoints of their parents, each by its own distance. Let s >= t be the
// shares of their ways that they have gone. Every point of the triangle is then the mean, with weights 1 - s,
// s - t and t, of where it is with neither, with the first, and with both of them arrived; so its distance
// from the full surface is at most the same mean of the three distances. With both arrived everywhere it is
// level m - 1. Each of these surfaces is linear over the triangles of the full level, because coarse
// triangles are unions of finer ones; its distance from the full surface at equal (u, v) is convex on each of
// them and largest at full-level vertices, where it is measured.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/base/lattice.h"
#include "terrain/patch/bounds.h"
#include "terrain/patch/generate_vertices.h"
#include "terrain/patch/heights.h"
#include "terrain/surface/patch.h"

namespace karst::core {

struct LevelGrid;  // level_triangles.h: all vertices of a patch

// The last share of a threshold's distance in which a vertex morphs (K's sigma, 4.4.4). A world's errors are
// measured for this value.
inline constexpr float kMorphShare = 0.3f;

// Values a patch: two for each level above the first.
constexpr std::size_t level_error_values(int level) {
  return 2 * static_cast<std::size_t>(level - 1);
}

// This and more counts as this, and as no bound at all: thresholds are then infinite. 8 voxels.
inline constexpr std::uint16_t kUnboundedError = 65'535;

// Errors of all patches of a world; borrowed. A patch has error(1) .. error(level - 1), then reach(2) ..
// reach(level); both fall or stay from each to the next. Lattice steps, rounded up.
struct LevelErrors {
  int level = 0;                          // the full one, 1..kMaxLevel; 0: nothing is known
  std::span<const std::uint16_t> values;  // patches x level_error_values(level)

  bool known(std::size_t patches) const {
    return level >= 1 && level <= kMaxLevel && values.size() == patches * level_error_values(level);
  }

  // The largest distance from the full surface, over
  //  - the patch's triangles of level j + 1 with one or both vertices arrived,
  //  - its neighbours' triangles of level j + 1 on a shared edge with the border vertex alone arrived,
  //  because
  //    a border vertex moves by the smaller threshold of the two patches,
  //  - its own such triangles, over 1 - kMorphShare: then the inner vertex, which may start later, does not
  //    add to what the border vertex did (morph.h).
  std::uint16_t error(PatchId patch, int j) const { return row(patch)[j - 1]; }
  // The largest distance from a vertex of level m, from which it measures its own distance to the eye, to any
  // point of these triangles, drawn in any state or on the full surface.
  std::uint16_t reach(PatchId patch, int m) const { return row(patch)[level - 1 + m - 2]; }

 private:
  const std::uint16_t* row(PatchId patch) const { return values.data() + patch * level_error_values(level); }
};

// What a patch's border triangles tell its neighbours: index j - 1 or m - 2, by edge. Working memory.
struct BorderErrors {
  std::uint16_t error[4][kMaxLevel - 1];
  std::uint16_t reach[4][kMaxLevel - 1];
};

// What a patch's own triangles say: to neighbours, and of itself as LevelErrors::values has it.
struct OwnErrors {
  BorderErrors borders;
  std::uint16_t values[level_error_values(kMaxLevel)];
};

// No less than what measure_own_errors() would give, from how far vertices are from their morph targets: a
// level differs from the next coarser one by no more than its vertices' ways, and from the full one by no
// more than the sum of those of all finer levels. Reaches are the diagonal of the box of all vertices.
// apart: lattice steps; where ways are those of another surface, how far the two are apart at most.
void bound_own_errors(int level, const MorphWays& ways, const PatchBounds& box, OwnErrors& own,
                      double apart = 0);

// Of one patch at the heights' level: values of its own triangles alone (as LevelErrors has them,
// level_error_values() of them), and what its neighbours need.
void measure_own_errors(const Surface& surface, const Heights& heights, PatchId patch, BorderErrors& own,
                        std::span<std::uint16_t> values);
void measure_own_errors(const LevelGrid& grid, BorderErrors& own, std::span<std::uint16_t> values);
// Adds what comes over its edges. theirs: by edge, what measure_own_errors() made of the neighbour there; not
// read where there is none.
void join_errors(const Surface& surface, int level, PatchId patch, const BorderErrors& own,
                 const BorderErrors* const (&theirs)[4], std::span<std::uint16_t> values);

// measure() every patch, then join() every patch; ranges of each may run on several threads.
struct MeasureLevelErrors {
  // Inputs, borrowed.
  Surface surface;
  Heights heights;  // its level is the full one

  // Working memory, borrowed: one a patch.
  std::span<BorderErrors> borders;

  // Output, borrowed: as LevelErrors::values.
  std::span<std::uint16_t> values;

  // invalid_argument naming the first field of another size than the surface, or heights.level out of range.
  Status validate() const;

  // Patches first .. last - 1. Precondition: validate() is ok.
  void measure(PatchId first, PatchId last) const;
  void join(PatchId first, PatchId last) const;
};

// Whether values are what MeasureLevelErrors can have made: errors and reaches that nowhere rise. Returns the
// index of the first that does, or values.size().
std::size_t find_level_error_fault(int level, std::span<const std::uint16_t> values);

}  // namespace karst::core
