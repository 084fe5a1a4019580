// SPDX-License-Identifier: MIT
// The last stage of fitting heights: folds that neighbouring rays leave on steep ground are taken out.
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/surface/patch.h"

namespace karst::bake {
using namespace core;

// Removes folds: moves the vertices of folded triangles towards their neighbours' heights until no triangle
// is folded or max_passes or the visits are used up; nothing is moved where folds are not rare. Shared
// vertices stay equal. A triangle is folded when
// its normal is turned both against W at its vertices and against its undisplaced normal; in a height field
// (height_field = true), when it does not face upwards.
struct RepairFolds {
  Surface surface;
  int level = 0;
  std::span<std::int16_t> heights;  // in and out, layout as in FitHeights
  bool height_field = false;
  int max_passes = 200;
  // Patches that all passes after the first may look at: so many a patch of the surface, and so many besides,
  // so that small surfaces may use all passes. Bounds the time on ground that keeps folding.
  std::uint64_t visits_per_patch = 8;
  std::uint64_t least_visits = 20'000;
  // Ground of which a larger share of the triangles folds is left as it is: averaging does not help there.
  // Worlds that fit their ground have less than a thousandth.
  double most_folded = 1.0 / 32;

  struct Result {
    std::uint64_t folded_before = 0;  // triangles
    std::uint64_t folded_after = 0;
    std::uint64_t vertices_moved = 0;
    int passes = 0;
  };

  Status validate() const;
  Result run() const;
};

}  // namespace karst::bake
