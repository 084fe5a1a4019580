// SPDX-License-Identifier: MIT
// What is measured of patches two lanes at a time, with normals taken once, against the same sums made one
// after the other: to the bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include <glm/geometric.hpp>

#include "terrain/measure/level_error.h"
#include "terrain/measure/level_triangles.h"
#include "terrain/measure/normal_cone.h"
#include "terrain/measure/shading_cone.h"
#include "terrain/patch/octahedral.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

namespace plain_errors {

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

void measure_own_errors(const Surface& surface, const Heights& heights, PatchId patch, BorderErrors& own,
                        std::span<std::uint16_t> values) {
  const int level = heights.level;
  const LevelGrid grid(surface, heights, patch);
  std::uint16_t* const error = values.data();
  std::uint16_t* const reach = error + (level - 1);
  own = {};
  for (int m = 2; m <= level; ++m) {
    const int size = 1 << (level - m);
    Extremes inside;
    Extremes edge[4];
    for_each_level_triangle(grid, m, [&](const LevelTriangle& t, int e) {
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

}  // namespace plain_errors

namespace plain_cone {

constexpr int kMoves = 8;

// Finest level whose normals the axis is looked for among; it holds for all, but need not be the best.
constexpr int kAxisLevel = 3;

// Added to the sine, 127 of it being 1: 0.45 degrees, for what the GPU does to triangles of about a pixel's
// size and larger, moving their vertices to the subpixel grid. Smaller ones that turn over by it lie behind
// the same closed surface's front.
constexpr double kSineMargin = 1.0;

// Calls visit(normal) for every corner of the hull: twice the area long, of any length above 0. An edge to a
// coarser neighbour adds none: the triangle that stands on two sides there has the normal of the one whose
// border vertex has arrived in the middle between them.
template <class Visit>
void for_each_normal(const LevelGrid& grid, int last_level, Visit visit) {
  const auto triangle = [&](glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    if (normal != glm::dvec3(0.0)) visit(normal);
  };
  for (int m = 1; m <= last_level; ++m) {
    for_each_level_triangle(grid, m, [&](const LevelTriangle& t, int) {
      const glm::dvec3 stay = grid.at(t.stay);
      const glm::dvec3 borders[2] = {grid.at(t.border), t.border_target};
      const glm::dvec3 centres[2] = {grid.at(t.centre), t.centre_target};
      // Vertices of level 1 do not move.
      const int states = m == 1 ? 1 : 2;
      for (int b = 0; b < states; ++b) {
        for (int c = 0; c < states; ++c) {
          if (t.ends_side) {
            triangle(borders[b], stay, centres[c]);
          } else {
            triangle(stay, borders[b], centres[c]);
          }
        }
      }
    });
  }
}

glm::dvec3 find_axis(const LevelGrid& grid, int level) {
  const int last = std::min(level, kAxisLevel);
  glm::dvec3 axis(0.0);
  for_each_normal(grid, last, [&](glm::dvec3 n) { axis += n * (1.0 / glm::length(n)); });
  const double length = glm::length(axis);
  if (!(length > 0.0)) return glm::dvec3(0.0);
  axis /= length;
  for (int move = 1; move <= kMoves; ++move) {
    glm::dvec3 farthest = axis;
    double least = 1.0;
    for_each_normal(grid, last, [&](glm::dvec3 n) {
      const double along = glm::dot(n, axis);
      // Signed squares compare cosines without a root each.
      const double share = along * std::fabs(along) / glm::dot(n, n);
      if (share < least) {
        least = share;
        farthest = n;
      }
    });
    axis = glm::normalize(axis + (glm::normalize(farthest) - axis) * (1.0 / (move + 1)));
  }
  return axis;
}

NormalCone measure_normal_cone(const Surface& surface, const Heights& heights, PatchId patch) {
  const LevelGrid grid(surface, heights, patch);
  const glm::dvec3 axis = find_axis(grid, heights.level);
  if (axis == glm::dvec3(0.0)) return {};
  NormalCone cone;
  for (int k = 0; k < 3; ++k) cone.axis[k] = static_cast<std::int8_t>(std::lround(127.0 * axis[k]));
  const glm::dvec3 rounded(cone.axis[0], cone.axis[1], cone.axis[2]);
  double most = 0.0;  // squared sine times the axis's length
  bool holds = true;
  for_each_normal(grid, heights.level, [&](glm::dvec3 n) {
    const double along = glm::dot(n, rounded);
    holds = holds && along > 0.0;
    const glm::dvec3 across = glm::cross(n, rounded);
    most = std::max(most, glm::dot(across, across) / glm::dot(n, n));
  });
  const double sine = (std::sqrt(most) + kSineMargin) * (1.0 + 1e-9);
  const double units = std::ceil(sine / NormalCone::kSineUnit);
  // A cone whose sine reaches the axis's length holds half of all directions: nothing faces away from it.
  if (!holds || sine >= glm::length(rounded) || units >= NormalCone::kNone) return {};
  cone.sine = static_cast<std::uint8_t>(units);
  return cone;
}

}  // namespace plain_cone

namespace plain_shading {

constexpr int kMoves = 8;

// Added to the sine, 127 of it being 1: what rounding does to decoded and interpolated normals.
constexpr double kSineMargin = 0.05;

template <class Visit>
void for_each_normal(std::span<const GpuVertex> vertices, Visit visit) {
  for (const GpuVertex& vertex : vertices) {
    visit(glm::dvec3(decode_octahedral(vertex.normal)));
    if (vertex.morph_normal != vertex.normal) visit(glm::dvec3(decode_octahedral(vertex.morph_normal)));
  }
}

NormalCone measure_shading_cone(std::span<const GpuVertex> vertices) {
  glm::dvec3 axis(0.0);
  for_each_normal(vertices, [&](glm::dvec3 n) { axis += n; });
  const double length = glm::length(axis);
  if (!(length > 0.0)) return {};
  axis /= length;
  for (int move = 1; move <= kMoves; ++move) {
    glm::dvec3 farthest = axis;
    double least = 1.0;
    for_each_normal(vertices, [&](glm::dvec3 n) {
      const double along = glm::dot(n, axis);
      if (along < least) {
        least = along;
        farthest = n;
      }
    });
    const glm::dvec3 moved = axis + (farthest - axis) * (1.0 / (move + 1));
    if (glm::length(moved) > 0.0) axis = glm::normalize(moved);
  }
  NormalCone cone;
  for (int k = 0; k < 3; ++k) cone.axis[k] = static_cast<std::int8_t>(std::lround(127.0 * axis[k]));
  const glm::dvec3 rounded(cone.axis[0], cone.axis[1], cone.axis[2]);
  double most = 0.0;  // sine times the axis's length
  bool holds = true;
  for_each_normal(vertices, [&](glm::dvec3 n) {
    holds = holds && glm::dot(n, rounded) > 0.0;
    most = std::max(most, glm::length(glm::cross(n, rounded)));
  });
  const double sine = most + kSineMargin;
  const double units = std::ceil(sine / NormalCone::kSineUnit);
  if (!holds || sine >= glm::length(rounded) || units >= NormalCone::kNone) return {};
  cone.sine = static_cast<std::uint8_t>(units);
  return cone;
}

}  // namespace plain_shading

void expect_as_plain(const test::TestWorld& world, int level) {
  for (PatchId p = 0; p < world.surface().patches.size(); ++p) {
    BorderErrors made{}, plain{};
    std::vector<std::uint16_t> values(level_error_values(level)), plain_values(values.size());
    measure_own_errors(world.surface(), world.heights(), p, made, values);
    plain_errors::measure_own_errors(world.surface(), world.heights(), p, plain, plain_values);
    ASSERT_EQ(std::memcmp(&made, &plain, sizeof made), 0) << p;
    ASSERT_EQ(values, plain_values) << p;
    ASSERT_EQ(measure_normal_cone(world.surface(), world.heights(), p),
              plain_cone::measure_normal_cone(world.surface(), world.heights(), p))
        << p;
    const auto vertices = world.vertices(p, level);
    ASSERT_EQ(measure_shading_cone(vertices), plain_shading::measure_shading_cone(vertices)) << p;
  }
}

TEST(MeasureLanes, AreAsOneAfterTheOther) {
  for (const int level : {1, 2, 3, 5, 6}) {
    for (const int roughness : {0, 300, 4'000}) {
      test::TestWorld world =
          test::TestWorld::noise(static_cast<std::uint64_t>(level), {5, 4, 5}, 0.45, 3.0, false);
      world.roughen(level, 3, roughness);
      expect_as_plain(world, level);
      if (HasFatalFailure()) FAIL() << "level " << level << " roughness " << roughness;
    }
  }
}

// More of them than are kept, in any order, the same ones again, and none at all.
TEST(MeasureLanes, ShadingConesHoldAnyNormals) {
  test::Random random{5};
  for (const std::size_t count : {0u, 1u, 2u, 3u, 500u, 4'000u}) {
    for (const int spread : {1, 12, 60, 200}) {
      std::vector<GpuVertex> vertices(count);
      const auto normal = [&] {
        const auto part = [&] { return static_cast<unsigned>(random.below(spread) - spread / 2) & 0xffu; };
        const unsigned low = part(), high = part();
        return static_cast<std::uint16_t>((low == 0x80 ? 0x81u : low) | (high == 0x80 ? 0x81u : high) << 8);
      };
      for (GpuVertex& vertex : vertices) {
        vertex.normal = normal();
        vertex.morph_normal = normal();
      }
      ASSERT_EQ(measure_shading_cone(vertices), plain_shading::measure_shading_cone(vertices))
          << count << " " << spread;
    }
  }
}

}  // namespace
}  // namespace karst::core
