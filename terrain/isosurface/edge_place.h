// SPDX-License-Identifier: MIT
// Where the surface crosses an edge between two samples: the same bits for meshes and for queries.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace karst::core {

inline constexpr std::int32_t kIsoStepsPerCell = 1024;

// From the sample `low` on, kIsoStepsPerCell from sample to sample. Values stand for themselves and a half;
// one is below 0, one is not.
inline int edge_crossing(int low, int high) {
  const int a = std::abs(2 * low + 1), b = std::abs(2 * high + 1);
  return std::clamp((2 * a * 512 + (a + b) / 2) / (a + b), 1, 1023);
}

// A crossing `steps` from its edge's beginning, kIsoStepsPerCell a sample, in those of a level. On sides of
// blocks it is an odd multiple of 2, a place that the next coarser level has, too, but for none of its own
// vertices: where no way can be made for transition cells, they are thin, and still no two of their vertices
// are at one place.
inline int edge_steps(int steps, int level, bool on_side) {
  if (on_side) return (steps >> (level + 2)) * 4 + 2;
  return std::clamp((steps + ((1 << level) >> 1)) >> level, 1, kIsoStepsPerCell - 1);
}

}  // namespace karst::core
