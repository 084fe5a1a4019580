// SPDX-License-Identifier: MIT
// A moving sphere against a triangle.
#pragma once

#include <limits>

#include <glm/vec3.hpp>

#include "terrain/query/segment.h"

namespace karst::core {

struct Contact {
  double t = 1.0;  // share of the segment's way
  // From the sphere's centre where they touch from the start, t = 0; else 0. Of no contact at all: infinite.
  double distance = std::numeric_limits<double>::infinity();
  glm::dvec3 place{0.0};  // of the triangle, lattice steps

  friend bool operator<(const Contact& a, const Contact& b) {
    return a.t != b.t ? a.t < b.t : a.distance < b.distance;
  }
};

struct Triangle {
  glm::dvec3 corner[3];  // lattice steps
};

// First contact of a sphere whose centre moves along a segment. False: none at or before t = best.t.
// area: the triangle's area vector; without length it is never touched.
bool sweep_triangle(const Segment& segment, double radius, const Triangle& triangle, glm::dvec3 area,
                    const Contact& best, Contact& contact);

}  // namespace karst::core
