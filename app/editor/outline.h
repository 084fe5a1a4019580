// SPDX-License-Identifier: MIT
// Lines that show where the brush is: a ring that lies on the ground, the box of a voxel.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "karst/query.h"

namespace karst::app {

struct OutlinePart {
  glm::dvec3 from, to;
};

// Around a place, on the surface that is met along the axis (unit length) within the radius of it; where
// there is none, in the plane through the place.
std::vector<OutlinePart> ring_on(Query& query, const glm::dvec3& place, const glm::dvec3& axis,
                                 double radius_m);
// A square with sides to the east and to the south, laid on the ground likewise, from above.
std::vector<OutlinePart> square_on(Query& query, const glm::dvec3& place, double half_m);
// The edges of a cube.
std::vector<OutlinePart> cube_edges(const glm::dvec3& centre, double side_m);
// A circle around the place, across the axis.
std::vector<OutlinePart> circle(const glm::dvec3& place, const glm::dvec3& axis, double radius_m);

}  // namespace karst::app
