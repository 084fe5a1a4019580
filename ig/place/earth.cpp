// SPDX-License-Identifier: MIT
#include "ig/place/earth.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "app/motion/angles.h"

namespace karst::ig {
namespace {

constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180.0;
// WGS 84 (NIMA TR8350.2): equatorial radius in metres, and the square of the first eccentricity.
constexpr double kRadius_m = 6'378'137.0;
constexpr double kEccentricity2 = 6.69437999014e-3;
constexpr double kNorthStep_deg = 1e-4;  // 11 m: what north is found from

glm::dvec3 vec(Vec3 v) {
  return {v.x, v.y, v.z};
}

}  // namespace

glm::dmat3 turned(const glm::dmat3& axes, double yaw_deg, double pitch_deg, double roll_deg) {
  const auto [sy, cy] = app::sin_cos_deg(yaw_deg);
  const auto [sp, cp] = app::sin_cos_deg(pitch_deg);
  const auto [sr, cr] = app::sin_cos_deg(roll_deg);
  const glm::dmat3 yaw(glm::dvec3(cy, sy, 0), glm::dvec3(-sy, cy, 0), glm::dvec3(0, 0, 1));
  const glm::dmat3 pitch(glm::dvec3(cp, 0, -sp), glm::dvec3(0, 1, 0), glm::dvec3(sp, 0, cp));
  const glm::dmat3 roll(glm::dvec3(1, 0, 0), glm::dvec3(0, cr, sr), glm::dvec3(0, -sr, cr));
  return axes * (yaw * pitch * roll);
}

Direction direction_in(const glm::dmat3& north_east_down, glm::dvec3 towards) {
  const double north = glm::dot(north_east_down[0], towards);
  const double east = glm::dot(north_east_down[1], towards);
  const double up = -glm::dot(north_east_down[2], towards);
  Direction direction;
  direction.azimuth_deg = std::atan2(east, north) / kRadiansPerDegree;
  direction.elevation_deg = std::atan2(up, std::hypot(east, north)) / kRadiansPerDegree;
  return direction;
}

Error Earth::open(const World& world, const std::optional<Geodetic>& anchor) {
  world_ = &world;
  anchored_ = anchor.has_value();
  if (!anchored_) {
    if (world.info().is_geodetic) return {};
    return "it is not known where it lies on the earth; --anchor LAT,LON,ALT says where its middle is";
  }
  if (world.info().basis != Basis::plane) return "--anchor is for worlds on a plane, and this one is on none";
  anchor_ = *anchor;
  const double sine = std::sin(anchor_.latitude_deg * kRadiansPerDegree);
  const double w2 = 1 - kEccentricity2 * sine * sine;
  const double across = kRadius_m / std::sqrt(w2);
  const double along = across * (1 - kEccentricity2) / w2;
  const double cosine = std::cos(anchor_.latitude_deg * kRadiansPerDegree);
  metres_per_degree_north_ = (along + anchor_.altitude_m) * kRadiansPerDegree;
  metres_per_degree_east_ = (across + anchor_.altitude_m) * cosine * kRadiansPerDegree;
  return {};
}

bool Earth::to_world(const Geodetic& geodetic, glm::dvec3& place) const {
  if (anchored_) {
    const double east_deg = std::remainder(geodetic.longitude_deg - anchor_.longitude_deg, 360.0);
    place = {east_deg * metres_per_degree_east_, geodetic.altitude_m - anchor_.altitude_m,
             -(geodetic.latitude_deg - anchor_.latitude_deg) * metres_per_degree_north_};
    return true;
  }
  Vec3 found;
  if (!(std::fabs(geodetic.latitude_deg) <= 90) || !world_->from_geodetic(geodetic, found)) return false;
  place = vec(found);
  return true;
}

bool Earth::to_geodetic(glm::dvec3 place, Geodetic& geodetic) const {
  if (!anchored_) return world_->to_geodetic({place.x, place.y, place.z}, geodetic);
  geodetic.longitude_deg = std::remainder(anchor_.longitude_deg + place.x / metres_per_degree_east_, 360.0);
  geodetic.latitude_deg = anchor_.latitude_deg - place.z / metres_per_degree_north_;
  geodetic.altitude_m = anchor_.altitude_m + place.y;
  return true;
}

glm::dmat3 Earth::axes_at(glm::dvec3 place) const {
  const LocalAxes axes = world_->axes_at({place.x, place.y, place.z});
  const glm::dvec3 up = vec(axes.up);
  glm::dvec3 north = vec(axes.north);
  Geodetic here;
  if (!anchored_ && world_->info().basis == Basis::plane && to_geodetic(place, here)) {
    Geodetic low = here, high = here;
    low.latitude_deg = std::max(here.latitude_deg - kNorthStep_deg, -90.0);
    high.latitude_deg = std::min(here.latitude_deg + kNorthStep_deg, 90.0);
    glm::dvec3 from, to;
    if (to_world(low, from) && to_world(high, to)) {
      const glm::dvec3 way = (to - from) - up * glm::dot(to - from, up);
      if (glm::length(way) > 0) north = glm::normalize(way);
    }
  }
  return {north, glm::cross(north, up), -up};
}

}  // namespace karst::ig
