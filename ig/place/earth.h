// SPDX-License-Identifier: MIT
// Between places on the earth and a world's own metres (east, up, south), and bodies there: x forward, y
// right, z down, turned by yaw, then pitch, then roll from north, east and down.
#pragma once

#include <optional>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "karst/world.h"
#include "platform/base/error.h"

namespace karst::ig {

// A place with axes: the columns are forward, right and down.
struct Body {
  glm::dvec3 place{0.0};
  glm::dmat3 axes{1.0};

  glm::dvec3 at(glm::dvec3 offset_m) const { return place + axes * offset_m; }
};

// Turned in its own axes. Exact at multiples of 90 degrees.
glm::dmat3 turned(const glm::dmat3& axes, double yaw_deg, double pitch_deg, double roll_deg);

// Of a direction in axes that are north, east and down: clockwise from north, and up.
struct Direction {
  double azimuth_deg = 0, elevation_deg = 0;
};
Direction direction_in(const glm::dmat3& north_east_down, glm::dvec3 towards);

class Earth {
 public:
  // world must outlive this object. anchor: where its zero point lies, whatever else it knows; needed where
  // it has no georeference.
  Error open(const World& world, const std::optional<Geodetic>& anchor);

  // False: not known there.
  bool to_world(const Geodetic& geodetic, glm::dvec3& place) const;
  bool to_geodetic(glm::dvec3 place, Geodetic& geodetic) const;
  // North, east and down there, in columns. North is true north, but with an anchor, where it is the world's.
  glm::dmat3 axes_at(glm::dvec3 place) const;

 private:
  const World* world_ = nullptr;
  bool anchored_ = false;
  Geodetic anchor_;
  double metres_per_degree_east_ = 1, metres_per_degree_north_ = 1;  // with an anchor
};

}  // namespace karst::ig
