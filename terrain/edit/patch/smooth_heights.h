// SPDX-License-Identifier: MIT
// The mean of the heights around a vertex of a patch, those of other patches included. It is the same of all
// copies of a vertex: sums of integers over what they have in common.
#pragma once

#include <cstdint>

#include "terrain/patch/heights.h"
#include "terrain/surface/patch.h"

namespace karst::core {

class HeightsAround {
 public:
  HeightsAround(const Surface& surface, const Heights& heights, int level)
      : surface_(surface), heights_(heights), level_(level) {}

  // Of the eight around a vertex inside; of those beside it on the border and in both rows along it; around a
  // corner, of the nearest on all edges and in all patches there. 0 <= i, j <= patch_cells(level).
  double mean(PatchId patch, int i, int j) const;

 private:
  struct Sum {
    std::int64_t heights = 0;
    int count = 0;

    void add(std::int32_t height) {
      heights += height;
      ++count;
    }
  };

  std::int32_t at(PatchId patch, int i, int j) const;
  void add_row(PatchId patch, int edge, int t, Sum& sum) const;
  Sum around_border(PatchId patch, int edge, int t) const;
  Sum around_corner(PatchId patch, int corner) const;

  Surface surface_;
  Heights heights_;
  int level_;
};

}  // namespace karst::core
