// SPDX-License-Identifier: MIT
// Where the surface crosses an edge between two samples: the same bits for meshes and for queries.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include <glm/vec3.hpp>

namespace karst::core {

inline constexpr int kIsoCells = 16;  // along a block's side
inline constexpr std::int32_t kIsoStepsPerCell = 1024;

// From the sample `low` on, kIsoStepsPerCell from sample to sample. Values stand for themselves and a half;
// one is below 0, one is not.
inline int edge_crossing(int low, int high) {
  const int a = std::abs(2 * low + 1), b = std::abs(2 * high + 1);
  return std::clamp((2 * a * 512 + (a + b) / 2) / (a + b), 1, 1023);
}

// A vertex on a side of a block lies so many steps of its level, modulo 16, from its edge's beginning, by the
// number of the edge's line in the side, modulo 4. Steps of the next coarser level are such places, too, but
// never those of its own vertices. So transition cells without way, which are thin, have no flat triangle:
// twice its area is, in steps of the finer level, where x are places along lines of one direction and y along
// lines across, a multiple of 1024 (the width of a cell)
//   - plus y (x' - x): 2 divides y at most twice, and x' - x at most four times, or
//   - times x + x'' - 2 x', of lines side by side: never 0 modulo 16, or
//   - times x' - x, of two vertices on one line.
// kInside: of no side, to the nearest step.
inline constexpr int kLineSteps[4] = {2, 6, 14, 10};
inline constexpr int kInside = -1;

// The number of that line, or kInside. Lines that two sides share are 0 in both. cell: where the edge begins,
// of the block or of the world, whose blocks begin at multiples of kIsoCells.
inline int side_line(int axis, glm::ivec3 cell) {
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  if (cell[b] % kIsoCells == 0) return cell[c] & 3;
  return cell[c] % kIsoCells == 0 ? cell[b] & 3 : kInside;
}

// A crossing `steps` from its edge's beginning, kIsoStepsPerCell a sample, in those of a level.
inline int edge_steps(int steps, int level, int line) {
  if (line == kInside) return std::clamp((steps + ((1 << level) >> 1)) >> level, 1, kIsoStepsPerCell - 1);
  const int rest = kLineSteps[line & 3];
  return std::clamp(((steps >> level) - rest + 8) >> 4, 0, kIsoStepsPerCell / 16 - 1) * 16 + rest;
}

}  // namespace karst::core
