// SPDX-License-Identifier: MIT
#include "terrain/isosurface/cell_loop.h"

#include <cmath>

#include <glm/common.hpp>

namespace karst::core {
namespace {

// Normals of what has no folds, along the loop's: their cosine at least.
constexpr float kLeastAlong = 0.2f;

}  // namespace

float from_segment(glm::vec3 p, glm::vec3 a, glm::vec3 b) {
  const glm::vec3 along = b - a;
  const float length2 = squared(along);
  const float t = length2 > 0 ? glm::clamp(glm::dot(p - a, along) / length2, 0.0f, 1.0f) : 0.0f;
  return squared(p - a - along * t);
}

float CellTriangle::distance2(glm::vec3 p) const {
  // Within the prism over the triangle it is that from the plane; else that from the nearest side.
  const float area2 = squared(normal);
  float least = kUnknown;
  bool within = area2 > 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const glm::vec3 a = at[k], b = at[(k + 1) % 3];
    if (glm::dot(glm::cross(b - a, p - a), normal) >= 0) continue;
    within = false;
  }
  if (within) {
    const float along = glm::dot(p - at[0], normal);
    return along * along / area2;
  }
  for (std::size_t k = 0; k < 3; ++k) least = std::min(least, from_segment(p, at[k], at[(k + 1) % 3]));
  return least;
}

bool Loop::find_outline() {
  std::array<int, kCellEdges> next{};
  next.fill(-1);
  std::array<glm::vec3, kCellEdges> at;
  int first = -1, count = 0;
  for (std::size_t n = 0; n < triangles; ++n) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = edge[n][k], to = edge[n][(k + 1) % 3];
      at[static_cast<std::size_t>(from)] = triangle[n].at[k];
      if (has(to, from)) continue;
      next[static_cast<std::size_t>(from)] = to;
      first = from;
      ++count;
    }
  }
  for (int e = first; count > 0; --count) {
    if (e < 0) return false;
    outline_edge[outlined] = e;
    outline[outlined++] = at[static_cast<std::size_t>(e)];
    e = next[static_cast<std::size_t>(e)];
  }
  return true;
}

// Along the mean normal, between two segments where they cross as seen along it; 0 where they do not.
float Loop::gap(glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d) const {
  const glm::vec3 ab = b - a, cd = d - c;
  const float whole = glm::dot(glm::cross(ab, cd), mean);
  if (whole == 0) return 0;
  const float s = glm::dot(glm::cross(c - a, cd), mean) / whole;
  const float t = glm::dot(glm::cross(c - a, ab), mean) / whole;
  if (s < 0 || s > 1 || t < 0 || t > 1) return 0;
  return std::abs(glm::dot(a + ab * s - c - cd * t, mean));
}

void Loop::measure() {
  for (std::size_t n = 0; n < triangles; ++n) {
    triangle[n].find_normal();
    mean += triangle[n].normal;
  }
  const float length = std::sqrt(squared(mean));
  if (!(length > 0) || !find_outline()) return;
  mean /= length;
  for (std::size_t n = 0; n < triangles; ++n) {
    const float along = glm::dot(triangle[n].normal, mean);
    const float whole = std::sqrt(squared(triangle[n].normal));
    if (!(along > kLeastAlong * whole)) return;
    slope = std::max(slope, std::sqrt(std::max(whole * whole - along * along, 0.0f)) / along);
  }
  for (std::size_t n = 0; n < outlined; ++n) {
    const glm::vec3 a = outline[n], b = outline[(n + 1) % outlined], c = outline[(n + 2) % outlined];
    if (!(glm::dot(glm::cross(b - a, c - b), mean) > 0)) return;
  }
  float around = 0;
  for (std::size_t n = 0; n < outlined; ++n) {
    const glm::vec3 side = outline[(n + 1) % outlined] - outline[n];
    const float along = glm::dot(side, mean);
    around += std::sqrt(std::max(squared(side) - along * along, 0.0f));
  }
  // A convex outline's area is at least half of it times what goes around; twice the area is `length`.
  radius = around > 0 ? length / around : 0;
  float most = 0;
  for (std::size_t n = 0; n < triangles; ++n) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = edge[n][k], to = edge[n][(k + 1) % 3];
      if (from > to || !has(to, from)) continue;  // of the outline, or seen from the other side
      for (std::size_t i = 0; i < outlined; ++i) {
        for (std::size_t j = i + 2; j < outlined; ++j) {
          most = std::max(most, gap(outline[i], outline[j], triangle[n].at[k], triangle[n].at[(k + 1) % 3]));
        }
      }
    }
  }
  thickness = most;
}

}  // namespace karst::core
