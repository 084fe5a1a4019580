// SPDX-License-Identifier: MIT
// The axis is moved towards the normal farthest from it a few times, as in normal_cone.cpp; then the rounded
// axis's widest angle is taken.
#include "terrain/measure/shading_cone.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "terrain/base/simd.h"
#include "terrain/patch/octahedral.h"

namespace karst::core {
namespace {

using simd::Double2;

constexpr int kMoves = 8;

// Added to the sine, 127 of it being 1: what rounding does to decoded and interpolated normals.
constexpr double kSineMargin = 0.05;

// The different ones among a patch's normals, in the order of their first appearance. Few of the 65,025 that
// vertices can have lie on one patch.
struct Normals {
  static constexpr int kRoom = 1536;
  static constexpr std::size_t kSlots = 4096;

  double x[kRoom], y[kRoom], z[kRoom];
  std::uint16_t packed[kRoom];
  std::uint16_t slots[kSlots] = {};  // one more than the number of one; 0: none
  int count = 0;

  glm::dvec3 at(int n) const { return {x[n], y[n], z[n]}; }
  // Its number, or -1 where there is no room.
  int find(std::uint16_t normal) {
    std::size_t slot = (normal * 40'503u >> 4) % kSlots;
    for (; slots[slot] != 0; slot = (slot + 1) % kSlots) {
      if (packed[slots[slot] - 1] == normal) return slots[slot] - 1;
    }
    if (count == kRoom) return -1;
    const glm::dvec3 decoded(decode_octahedral(normal));
    x[count] = decoded.x;
    y[count] = decoded.y;
    z[count] = decoded.z;
    packed[count] = normal;
    slots[slot] = static_cast<std::uint16_t>(++count);
    return count - 1;
  }
};

template <class Visit>
void for_each_normal(std::span<const GpuVertex> vertices, Visit visit) {
  for (const GpuVertex& vertex : vertices) {
    visit(vertex.normal);
    if (vertex.morph_normal != vertex.normal) visit(vertex.morph_normal);
  }
}

// Calls visit(normal) for those that have no place among them.
template <class Visit>
void for_each_other(std::span<const GpuVertex> vertices, Normals& normals, bool complete, Visit visit) {
  if (complete) return;
  for_each_normal(vertices, [&](std::uint16_t normal) {
    if (normals.find(normal) < 0) visit(glm::dvec3(decode_octahedral(normal)));
  });
}

// The first of the normals that is farthest from the axis; the axis where none is beside it.
glm::dvec3 find_farthest(std::span<const GpuVertex> vertices, Normals& normals, bool complete,
                         glm::dvec3 axis) {
  const auto along = [&](int k) {
    return axis.x * simd::load(normals.x + k) + axis.y * simd::load(normals.y + k) +
           axis.z * simd::load(normals.z + k);
  };
  double least = 1.0;
  int first = -1;
  int k = 0;
  for (; k + 2 <= normals.count; k += 2) {
    const Double2 here = along(k);
    const simd::Long2 less = here < least;
    if (!simd::any(less)) continue;
    for (int lane = 0; lane < 2; ++lane) {
      if (here[lane] < least) {
        least = here[lane];
        first = k + lane;
      }
    }
  }
  if (k < normals.count && glm::dot(normals.at(k), axis) < least) {
    least = glm::dot(normals.at(k), axis);
    first = k;
  }
  glm::dvec3 farthest = first < 0 ? axis : normals.at(first);
  for_each_other(vertices, normals, complete, [&](glm::dvec3 n) {
    if (glm::dot(n, axis) < least) {
      least = glm::dot(n, axis);
      farthest = n;
    }
  });
  return farthest;
}

}  // namespace

NormalCone measure_shading_cone(std::span<const GpuVertex> vertices) {
  Normals normals;
  bool complete = true;
  glm::dvec3 axis(0.0);
  for_each_normal(vertices, [&](std::uint16_t normal) {
    const int n = normals.find(normal);
    complete = complete && n >= 0;
    axis += n < 0 ? glm::dvec3(decode_octahedral(normal)) : normals.at(n);
  });
  const double length = glm::length(axis);
  if (!(length > 0.0)) return {};
  axis /= length;
  for (int move = 1; move <= kMoves; ++move) {
    const glm::dvec3 farthest = find_farthest(vertices, normals, complete, axis);
    const glm::dvec3 moved = axis + (farthest - axis) * (1.0 / (move + 1));
    if (glm::length(moved) > 0.0) axis = glm::normalize(moved);
  }
  NormalCone cone;
  for (int k = 0; k < 3; ++k) cone.axis[k] = static_cast<std::int8_t>(std::lround(127.0 * axis[k]));
  const glm::dvec3 rounded(cone.axis[0], cone.axis[1], cone.axis[2]);
  double most = 0.0;  // squared sine times the axis's length
  bool holds = true;
  const auto hold = [&](glm::dvec3 n) {
    const glm::dvec3 across = glm::cross(n, rounded);
    holds = holds && glm::dot(n, rounded) > 0.0;
    most = std::max(most, glm::dot(across, across));
  };
  for (int n = 0; n < normals.count; ++n) hold(normals.at(n));
  for_each_other(vertices, normals, complete, hold);
  const double sine = std::sqrt(most) + kSineMargin;
  const double units = std::ceil(sine / NormalCone::kSineUnit);
  if (!holds || sine >= glm::length(rounded) || units >= NormalCone::kNone) return {};
  cone.sine = static_cast<std::uint8_t>(units);
  return cone;
}

}  // namespace karst::core
