// SPDX-License-Identifier: MIT
// The axis is moved towards the normal farthest from it a few times, as in normal_cone.cpp; then the rounded
// axis's widest angle is taken.
#include "terrain/measure/shading_cone.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "terrain/patch/octahedral.h"

namespace karst::core {
namespace {

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

}  // namespace

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

}  // namespace karst::core
