// SPDX-License-Identifier: MIT
// For every triangle of a level, the deviation at each full-level vertex inside it, in integers times the
// triangle's size, which doubles hold exactly.
#include "terrain/measure/level_error.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "terrain/base/check.h"
#include "terrain/measure/level_triangles.h"
#include "terrain/patch/displacement.h"

namespace karst::core {
namespace {

// Squared distances; of deviations times the square of the triangle's size.
struct Extremes {
  double border = 0;  // the border vertex alone arrived
  double any = 0;     // one or both arrived
  double reach = 0;
};

double squared(glm::dvec3 v) {
  return glm::dot(v, v);
}

Extremes measure_triangle(const LevelGrid& grid, const LevelTriangle& t, int size) {
  const glm::dvec3 stay = grid.at(t.stay);
  const glm::dvec3 border = grid.at(t.border);
  const glm::dvec3 centre = grid.at(t.centre);
  const glm::dvec3 border_way = t.border_target - border;
  const glm::dvec3 centre_way = t.centre_target - centre;
  Extremes most;
  for (const glm::dvec3 from : {border, centre}) {
    for (const glm::dvec3 to : {stay, border, centre, t.border_target, t.centre_target}) {
      most.reach = std::max(most.reach, squared(to - from));
    }
  }
  const glm::ivec2 along = (t.border - t.stay) / size;
  const glm::ivec2 across = (t.centre - t.border) / size;
  for (int a = 0; a <= size; ++a) {
    for (int b = 0; b <= a; ++b) {
      const glm::dvec3 full = grid.at(t.stay + a * along + b * across);
      const double of_border = a - b;
      const double of_centre = b;
      const glm::dvec3 home =
          double(size - a) * stay + of_border * border + of_centre * centre - double(size) * full;
      const glm::dvec3 border_moves = of_border * border_way;
      const glm::dvec3 centre_moves = of_centre * centre_way;
      most.border = std::max(most.border, squared(home + border_moves));
      most.any =
          std::max({most.any, squared(home + centre_moves), squared(home + border_moves + centre_moves)});
      most.reach = std::max({most.reach, squared(full - border), squared(full - centre)});
    }
  }
  most.any = std::max(most.any, most.border);
  return most;
}

// The least integer that is not less than the root of a squared length over size.
std::uint16_t round_up(double squared_length, int size) {
  if (squared_length >= double{kUnboundedError} * kUnboundedError * size * size) return kUnboundedError;
  double steps = std::floor(std::sqrt(squared_length) / size);
  while (steps * steps * size * size < squared_length) ++steps;
  return static_cast<std::uint16_t>(steps);
}

std::uint16_t round_up(double steps) {
  return steps >= kUnboundedError ? kUnboundedError : static_cast<std::uint16_t>(std::ceil(steps));
}

void raise(std::uint16_t& value, std::uint16_t to) {
  value = std::max(value, to);
}

}  // namespace

Status MeasureLevelErrors::validate() const {
  const auto refuse = [](const char* what, const char* field) {
    return Status{StatusCode::invalid_argument, what, field};
  };
  const std::size_t patches = surface.patches.size();
  if (heights.level < 1 || heights.level > kMaxLevel) return refuse("not a level of detail", "heights");
  if (borders.size() != patches) return refuse("must hold one entry a patch", "borders");
  if (values.size() != patches * level_error_values(heights.level)) {
    return refuse("must hold two values a patch and level above the first", "values");
  }
  return {};
}

void measure_own_errors(const Surface& surface, const Heights& heights, PatchId patch, BorderErrors& own,
                        std::span<std::uint16_t> values) {
  const int level = heights.level;
  LevelGrid grid;
  grid.side = patch_side(level);
  displaced_positions(surface, heights, level, patch, grid.position);
  std::uint16_t* const error = values.data();
  std::uint16_t* const reach = error + (level - 1);
  own = {};
  for (int m = 2; m <= level; ++m) {
    const int size = 1 << (level - m);
    Extremes inside;
    Extremes edge[4];
    for_each_level_triangle(grid, level, m, [&](const LevelTriangle& t, int e) {
      const Extremes x = measure_triangle(grid, t, size);
      inside.any = std::max(inside.any, x.any);
      inside.reach = std::max(inside.reach, x.reach);
      if (e < 0) return;
      edge[e].border = std::max(edge[e].border, x.border);
      edge[e].reach = std::max(edge[e].reach, x.reach);
    });
    error[m - 2] = round_up(inside.any, size);
    reach[m - 2] = round_up(inside.reach, 1);
    for (int e = 0; e < 4; ++e) {
      own.error[e][m - 2] = round_up(edge[e].border, size);
      own.reach[e][m - 2] = round_up(edge[e].reach, 1);
    }
  }
}

void join_errors(const Surface& surface, int level, PatchId patch, const BorderErrors& own,
                 const BorderErrors* const (&theirs)[4], std::span<std::uint16_t> values) {
  std::uint16_t* const error = values.data();
  std::uint16_t* const reach = error + (level - 1);
  for (int e = 0; e < 4; ++e) {
    const PatchEdge other = surface.patches[patch].neighbour[e];
    if (!other.exists()) continue;
    for (int j = 1; j < level; ++j) {
      raise(error[j - 1], round_up(own.error[e][j - 1] / (1.0 - double{kMorphShare})));
      raise(error[j - 1], theirs[e]->error[other.edge()][j - 1]);
      raise(reach[j - 1], theirs[e]->reach[other.edge()][j - 1]);
    }
  }
  for (int j = level - 2; j >= 1; --j) {
    raise(error[j - 1], error[j]);
    raise(reach[j - 1], reach[j]);
  }
}

void MeasureLevelErrors::measure(PatchId first, PatchId last) const {
  KARST_ASSERT(validate().ok() && first <= last && last <= surface.patches.size());
  const std::size_t row = level_error_values(heights.level);
  for (PatchId p = first; p < last; ++p)
    measure_own_errors(surface, heights, p, borders[p], values.subspan(p * row, row));
}

void MeasureLevelErrors::join(PatchId first, PatchId last) const {
  KARST_ASSERT(validate().ok() && first <= last && last <= surface.patches.size());
  const std::size_t row = level_error_values(heights.level);
  for (PatchId p = first; p < last; ++p) {
    const BorderErrors* theirs[4] = {};
    for (int e = 0; e < 4; ++e) {
      const PatchEdge other = surface.patches[p].neighbour[e];
      if (other.exists()) theirs[e] = &borders[other.patch()];
    }
    join_errors(surface, heights.level, p, borders[p], theirs, values.subspan(p * row, row));
  }
}

std::size_t find_level_error_fault(int level, std::span<const std::uint16_t> values) {
  const auto half = static_cast<std::size_t>(level - 1);  // 0: there are no values
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (half != 0 && i % half != 0 && values[i] > values[i - 1]) return i;
  }
  return values.size();
}

}  // namespace karst::core
