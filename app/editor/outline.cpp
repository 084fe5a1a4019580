// SPDX-License-Identifier: MIT
#include "app/editor/outline.h"

#include <cmath>

#include <glm/geometric.hpp>

namespace karst::app {
namespace {

constexpr int kRingParts = 64;
constexpr int kSquareParts = 12;   // a side
constexpr double kMostPart = 0.6;  // of the radius
constexpr double kTwoPi = 6.28318530717958647692;

Vec3 vec(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

// The surface nearest to the place on the way through it along the axis, one radius each way.
glm::dvec3 laid(Query& query, const glm::dvec3& place, const glm::dvec3& axis, double radius_m) {
  Hit hits[2];
  for (const int side : {0, 1}) {
    const glm::dvec3 end = place + axis * (side == 0 ? radius_m : -radius_m);
    query.ray(vec(place), vec(end), Wait::for_file, hits[side]);
  }
  if (!hits[0].found && !hits[1].found) return place;
  const bool second = !hits[0].found || (hits[1].found && hits[1].distance < hits[0].distance);
  const Vec3 found = hits[second ? 1 : 0].place;
  return {found.x, found.y, found.z};
}

// Two directions across the axis.
void across(const glm::dvec3& axis, glm::dvec3& u, glm::dvec3& v) {
  const glm::dvec3 other = std::abs(axis.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
  u = glm::normalize(glm::cross(other, axis));
  v = glm::cross(axis, u);
}

// most_m: longer parts, from one side of a valley to the other, are left out.
template <class PlaceAt>
std::vector<OutlinePart> closed(int parts, double most_m, PlaceAt place_at) {
  std::vector<OutlinePart> outline;
  outline.reserve(static_cast<std::size_t>(parts));
  const glm::dvec3 first = place_at(0);
  glm::dvec3 before = first;
  for (int n = 1; n <= parts; ++n) {
    const glm::dvec3 next = n == parts ? first : place_at(n);
    if (glm::length(next - before) <= most_m) outline.push_back({before, next});
    before = next;
  }
  return outline;
}

}  // namespace

std::vector<OutlinePart> ring_on(Query& query, const glm::dvec3& place, const glm::dvec3& axis,
                                 double radius_m) {
  glm::dvec3 u, v;
  across(axis, u, v);
  return closed(kRingParts, kMostPart * radius_m, [&](int n) {
    const double angle = kTwoPi * n / kRingParts;
    return laid(query, place + radius_m * (std::cos(angle) * u + std::sin(angle) * v), axis, radius_m);
  });
}

std::vector<OutlinePart> square_on(Query& query, const glm::dvec3& place, double half_m) {
  return closed(4 * kSquareParts, kMostPart * half_m, [&](int n) {
    const double along = 2.0 * (n % kSquareParts) / kSquareParts - 1;
    constexpr double kCorners[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    const int side = n / kSquareParts;
    const double *const a = kCorners[side], *const b = kCorners[(side + 1) % 4];
    const double x = (a[0] + b[0]) / 2 + (b[0] - a[0]) / 2 * along,
                 z = (a[1] + b[1]) / 2 + (b[1] - a[1]) / 2 * along;
    return laid(query, place + glm::dvec3(x * half_m, 0, z * half_m), {0, 1, 0}, half_m);
  });
}

std::vector<OutlinePart> cube_edges(const glm::dvec3& centre, double side_m) {
  const double half = 0.5 * side_m;
  std::vector<OutlinePart> edges;
  for (int corner = 0; corner < 8; ++corner) {
    const auto at = [&](int n) {
      return centre + half * glm::dvec3((n & 1) != 0 ? 1 : -1, (n & 2) != 0 ? 1 : -1, (n & 4) != 0 ? 1 : -1);
    };
    for (const int bit : {1, 2, 4}) {
      if ((corner & bit) == 0) edges.push_back({at(corner), at(corner | bit)});
    }
  }
  return edges;
}

std::vector<OutlinePart> circle(const glm::dvec3& place, const glm::dvec3& axis, double radius_m) {
  glm::dvec3 u, v;
  across(axis, u, v);
  return closed(kRingParts, radius_m, [&](int n) {
    const double angle = kTwoPi * n / kRingParts;
    return place + radius_m * (std::cos(angle) * u + std::sin(angle) * v);
  });
}

}  // namespace karst::app
