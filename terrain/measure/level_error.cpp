// SPDX-License-Identifier: MIT
// For every triangle of a level, the deviation at each full-level vertex inside it, in integers times the
// triangle's size, which doubles hold exactly: in whatever order they are added up.
#include "terrain/measure/level_error.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "terrain/base/check.h"
#include "terrain/base/simd.h"
#include "terrain/measure/level_triangles.h"

namespace karst::core {
namespace {

using simd::Double2;

// Both triangles of a tile's side lie in two lanes: they have but one corner each of their own.
struct Pair {
  Double2 x, y, z;

  Pair(Double2 first, Double2 second, Double2 third) : x(first), y(second), z(third) {}
  explicit Pair(glm::dvec3 v) : x(simd::splat(v.x)), y(simd::splat(v.y)), z(simd::splat(v.z)) {}
  // Vertices of the grid.
  Pair(const LevelGrid& grid, const int (&at)[2]) {
    const simd::Int4 a = simd::load(&grid.position[at[0]].x);  // and a value behind it
    const simd::Int4 b = simd::load(&grid.position[at[1]].x);
    x = simd::to_double(__builtin_shufflevector(a, b, 0, 4, 0, 4));
    y = simd::to_double(__builtin_shufflevector(a, b, 1, 5, 1, 5));
    z = simd::to_double(__builtin_shufflevector(a, b, 2, 6, 2, 6));
  }
  Double2 squared() const { return x * x + y * y + z * z; }
  friend Pair operator+(const Pair& a, const Pair& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Pair operator-(const Pair& a, const Pair& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Pair operator*(double s, const Pair& b) { return {s * b.x, s * b.y, s * b.z}; }
};

double squared(glm::dvec3 v) {
  return glm::dot(v, v);
}

// Squared distances; of deviations times the square of the triangles' size.
struct Extremes {
  Double2 border{};  // the border vertex alone arrived
  Double2 any{};     // one or both arrived
  Double2 reach{};

  void add(const Extremes& other) {
    border = simd::max(border, other.border);
    any = simd::max(any, other.any);
    reach = simd::max(reach, other.reach);
  }
  static double most(Double2 v) { return std::max(v[0], v[1]); }
};

// Over the vertices of the full level in both triangles. Where the two moving vertices are, their weights
// rise and fall along a row of them: from start on, a step at a time.
void measure_inside(const LevelGrid& grid, const LevelSide& side, int size, Extremes& most) {
  const int border_at = grid.index(side.border);
  const int across = (grid.index(side.centre) - border_at) / size;
  const int stay_at[2] = {grid.index(side.stay[0]), grid.index(side.stay[1])};
  const int along[2] = {(border_at - stay_at[0]) / size, (border_at - stay_at[1]) / size};
  const Pair stay(grid, stay_at);
  const Pair border(grid.at(side.border)), centre(grid.at(side.centre));
  const Pair border_target(side.border_target), centre_target(side.centre_target);
  const Pair border_step(grid.at(side.centre) - side.border_target);
  const Pair centre_step(side.centre_target - grid.at(side.border));
  const Pair both_step(side.centre_target - side.border_target);
  for (int a = 0; a <= size; ++a) {
    Pair border_moved = double(size - a) * stay + double(a) * border_target;
    Pair centre_moved = double(size - a) * stay + double(a) * border;
    Pair both_moved = border_moved;
    int at[2] = {stay_at[0] + a * along[0], stay_at[1] + a * along[1]};
    for (int b = 0; b <= a; ++b) {
      const Pair full(grid, at);
      const Pair scaled = double(size) * full;
      most.border = simd::max(most.border, (border_moved - scaled).squared());
      most.any =
          simd::max(most.any, simd::max((centre_moved - scaled).squared(), (both_moved - scaled).squared()));
      most.reach = simd::max(most.reach, simd::max((full - border).squared(), (full - centre).squared()));
      border_moved = border_moved + border_step;
      centre_moved = centre_moved + centre_step;
      both_moved = both_moved + both_step;
      at[0] += across;
      at[1] += across;
    }
  }
}

Extremes measure_side(const LevelGrid& grid, const LevelSide& side, int size) {
  const glm::dvec3 border = grid.at(side.border);
  const glm::dvec3 centre = grid.at(side.centre);
  const double border_way = squared(side.border_target - border);
  const double centre_way = squared(side.centre_target - centre);
  Extremes most;
  most.reach = simd::splat(std::max({border_way, centre_way, squared(side.centre_target - border),
                                     squared(side.border_target - centre), squared(centre - border)}));
  if (size > 1) {
    measure_inside(grid, side, size, most);
  } else {
    // Its corners are all there is.
    for (const glm::ivec2 stay : side.stay) {
      const glm::dvec3 at = grid.at(stay);
      most.reach = simd::max(most.reach, simd::splat(std::max(squared(at - border), squared(at - centre))));
    }
    most.border = simd::splat(border_way);
    most.any = simd::splat(centre_way);
  }
  most.any = simd::max(most.any, most.border);
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
  measure_own_errors(LevelGrid(surface, heights, patch), own, values);
}

void measure_own_errors(const LevelGrid& grid, BorderErrors& own, std::span<std::uint16_t> values) {
  const int level = grid.level;
  std::uint16_t* const error = values.data();
  std::uint16_t* const reach = error + (level - 1);
  own = {};
  for (int m = 2; m <= level; ++m) {
    const int size = 1 << (level - m);
    Extremes inside;
    Extremes edge[4];
    for_each_level_side(grid, m, [&](const LevelSide& side, int e) {
      const Extremes x = measure_side(grid, side, size);
      inside.add(x);
      if (e >= 0) edge[e].add(x);
    });
    error[m - 2] = round_up(Extremes::most(inside.any), size);
    reach[m - 2] = round_up(Extremes::most(inside.reach), 1);
    for (int e = 0; e < 4; ++e) {
      own.error[e][m - 2] = round_up(Extremes::most(edge[e].border), size);
      own.reach[e][m - 2] = round_up(Extremes::most(edge[e].reach), 1);
    }
  }
}

void bound_own_errors(int level, const MorphWays& ways, const PatchBounds& box, OwnErrors& own,
                      double apart) {
  own = {};
  // Rounded up by more than floats have lost.
  const auto length = [](float twice_squared) {
    return 0.5 * std::sqrt(double{twice_squared} * (1.0 + 0x1p-19));
  };
  double squared_size = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double size = box.max[axis] - box.min[axis];
    squared_size += size * size;
  }
  const std::uint16_t reach = round_up(squared_size, 1);
  // Of all finer levels together; a place of each surface is so far from the other's.
  double finer = 2 * apart;
  for (int m = level; m >= 2; --m) {
    own.values[m - 2] = round_up(finer + length(ways.longest[m]));
    own.values[level - 1 + m - 2] = reach;
    for (int e = 0; e < 4; ++e) {
      own.borders.error[e][m - 2] = round_up(finer + length(ways.on_edge[m][e]));
      own.borders.reach[e][m - 2] = reach;
    }
    finer += length(ways.longest[m]);
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
