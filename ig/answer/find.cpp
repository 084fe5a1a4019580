// SPDX-License-Identifier: MIT
// What a request is answered with.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <glm/geometric.hpp>

#include "ig/answer/answers.h"

namespace karst::ig {
namespace {

constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180.0;

glm::dvec3 vec(Vec3 v) {
  return {v.x, v.y, v.z};
}
Vec3 plain(glm::dvec3 v) {
  return {v.x, v.y, v.z};
}

bool find_place(cigi::CoordinateSystem system, std::uint16_t entity, double x, double y, double z,
                const Surroundings& around, glm::dvec3& place) {
  if (system == cigi::CoordinateSystem::geodetic) return around.earth->to_world({y, x, z}, place);
  const Entity* const owner = around.entities->find(entity);
  if (owner == nullptr || !owner->is_placed) return false;
  place = owner->body.at({x, y, z});
  return true;
}

// Heights that could not be read are none.
struct Reads {
  explicit Reads(const Query& query) : query_(query), before_(count()) {}
  bool failed() const { return count() != before_; }

 private:
  std::uint64_t count() const { return query_.failed_reads() + query_.refused_reads(); }

  const Query& query_;
  std::uint64_t before_;
};

// The highest ground that is not above the place; below the ground, in rock under which there is no cave,
// the lowest above it.
bool find_ground(Query& query, glm::dvec3 place, glm::dvec3 up, Hit& hit) {
  if (query.ground(plain(place), 0, Wait::for_file, hit)) return true;
  std::array<Hit, kMostColumn> column;
  const std::uint32_t count = std::min(query.column(plain(place), Wait::for_file, column), kMostColumn);
  for (std::uint32_t n = count; n-- > 0;) {
    if (glm::dot(vec(column[n].normal), up) <= 0) continue;
    hit = column[n];
    return true;
  }
  return false;
}

struct Met {
  double distance = 0;
  glm::dvec3 place{0.0}, normal{0.0};
  const Entity* entity = nullptr;  // null: the ground
};

// The first side of a box that a segment meets from outside.
bool meet_box(const Entity& entity, glm::dvec3 half, glm::dvec3 from, glm::dvec3 way, double most, Met& met) {
  const glm::dvec3 apart = entity.body.place - from;
  const double along = std::clamp(glm::dot(apart, way), 0.0, most);
  if (glm::dot(apart - way * along, apart - way * along) > glm::dot(half, half)) return false;
  double enter = 0, leave = most;
  int side = -1;
  double sign = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double start = -glm::dot(apart, entity.body.axes[axis]);
    const double step = glm::dot(way, entity.body.axes[axis]);
    if (step == 0) {
      if (std::fabs(start) > half[axis]) return false;
      continue;
    }
    const double one = (-half[axis] - start) / step, other = (half[axis] - start) / step;
    if (std::min(one, other) > enter) {
      enter = std::min(one, other);
      side = axis;
      sign = step > 0 ? -1 : 1;
    }
    leave = std::min(leave, std::max(one, other));
  }
  if (side < 0 || enter > leave) return false;
  met = {enter, from + way * enter, entity.body.axes[side] * sign, &entity};
  return true;
}

struct Segment {
  glm::dvec3 from{0.0}, to{0.0};
  std::optional<std::uint16_t> one, other;  // entities that it begins and ends at, which are not met
  std::uint8_t alpha_threshold = 0;
};

bool first_met(const Segment& segment, const Surroundings& around, Met& met) {
  const double length = glm::length(segment.to - segment.from);
  if (!(length > 0)) return false;
  bool any = false;
  Hit hit;
  if (around.query->ray(plain(segment.from), plain(segment.to), Wait::for_file, hit)) {
    met = {hit.distance, vec(hit.place), vec(hit.normal), nullptr};
    any = true;
  }
  const glm::dvec3 way = (segment.to - segment.from) / length;
  for (const Entity& entity : around.entities->all()) {
    if (!entity.is_seen || entity.alpha * 255 < segment.alpha_threshold || entity.alpha <= 0) continue;
    if (segment.one == entity.id || segment.other == entity.id) continue;
    Met box;
    if (!meet_box(entity, around.half_box_m, segment.from, way, any ? met.distance : length, box)) continue;
    met = box;
    any = true;
  }
  return any;
}

// way_before: to the segment's start, of what is asked for.
cigi::LosExtendedResponse response_of(const Segment& segment, cigi::CoordinateSystem system,
                                      double way_before_m, const Surroundings& around) {
  cigi::LosExtendedResponse response;
  response.responses = 1;
  const Reads reads(*around.query);
  Met met;
  if (!first_met(segment, around, met)) {
    response.visible = !reads.failed();
    return response;
  }
  if (reads.failed()) return response;
  response.valid = response.range_valid = true;
  response.range_m = way_before_m + met.distance;
  const glm::dmat3 axes = around.earth->axes_at(met.place);
  const Direction normal = direction_in(axes, met.normal);
  response.normal_azimuth_deg = static_cast<float>(normal.azimuth_deg);
  response.normal_elevation_deg = static_cast<float>(normal.elevation_deg);
  response.alpha = 255;
  if (met.entity != nullptr) {
    response.entity_valid = true;
    response.entity = met.entity->id;
    response.alpha = static_cast<std::uint8_t>(met.entity->alpha * 255 + 0.5f);
    if (system == cigi::CoordinateSystem::entity) {
      const glm::dvec3 offset = glm::transpose(met.entity->body.axes) * (met.place - met.entity->body.place);
      response.latitude_deg_or_x_m = offset.x;
      response.longitude_deg_or_y_m = offset.y;
      response.altitude_m_or_z_m = offset.z;
      return response;
    }
  }
  Geodetic geodetic;
  if (!around.earth->to_geodetic(met.place, geodetic)) response.valid = false;
  response.latitude_deg_or_x_m = geodetic.latitude_deg;
  response.longitude_deg_or_y_m = geodetic.longitude_deg;
  response.altitude_m_or_z_m = geodetic.altitude_m;
  return response;
}

}  // namespace

cigi::HatHotExtendedResponse find_height(const cigi::HatHotRequest& request, const Surroundings& around) {
  cigi::HatHotExtendedResponse response;
  response.id = request.id;
  glm::dvec3 place;
  if (!find_place(request.system, request.entity, request.latitude_deg_or_x_m, request.longitude_deg_or_y_m,
                  request.altitude_m_or_z_m, around, place))
    return response;
  const glm::dmat3 axes = around.earth->axes_at(place);
  const Reads reads(*around.query);
  Hit hit;
  Geodetic ground;
  if (!find_ground(*around.query, place, -axes[2], hit) || reads.failed()) return response;
  if (!around.earth->to_geodetic(vec(hit.place), ground)) return response;
  response.valid = true;
  response.hat_m = hit.distance;
  response.hot_m = ground.altitude_m;
  const Direction normal = direction_in(axes, vec(hit.normal));
  response.normal_azimuth_deg = static_cast<float>(normal.azimuth_deg);
  response.normal_elevation_deg = static_cast<float>(normal.elevation_deg);
  return response;
}

cigi::LosExtendedResponse find_sight(const cigi::LosSegmentRequest& request, const Surroundings& around) {
  Segment segment;
  segment.alpha_threshold = request.alpha_threshold;
  const std::uint16_t end_entity =
      request.destination_entity_valid ? request.destination_entity : request.entity;
  if (request.source == cigi::CoordinateSystem::entity) segment.one = request.entity;
  if (request.destination == cigi::CoordinateSystem::entity) segment.other = end_entity;
  cigi::LosExtendedResponse response;
  if (find_place(request.source, request.entity, request.source_latitude_deg_or_x_m,
                 request.source_longitude_deg_or_y_m, request.source_altitude_m_or_z_m, around,
                 segment.from) &&
      find_place(request.destination, end_entity, request.destination_latitude_deg_or_x_m,
                 request.destination_longitude_deg_or_y_m, request.destination_altitude_m_or_z_m, around,
                 segment.to))
    response = response_of(segment, request.response, 0, around);
  response.id = request.id;
  return response;
}

cigi::LosExtendedResponse find_sight(const cigi::LosVectorRequest& request, const Surroundings& around) {
  Segment segment;
  segment.alpha_threshold = request.alpha_threshold;
  cigi::LosExtendedResponse response;
  glm::dvec3 source;
  if (find_place(request.source, request.entity, request.source_latitude_deg_or_x_m,
                 request.source_longitude_deg_or_y_m, request.source_altitude_m_or_z_m, around, source) &&
      request.minimum_range_m >= 0 && request.maximum_range_m > request.minimum_range_m) {
    glm::dmat3 axes = around.earth->axes_at(source);
    if (request.source == cigi::CoordinateSystem::entity) {
      segment.one = request.entity;
      axes = around.entities->find(request.entity)->body.axes;
    }
    const double azimuth = double{request.azimuth_deg} * kRadiansPerDegree;
    const double elevation = double{request.elevation_deg} * kRadiansPerDegree;
    const glm::dvec3 way = axes * glm::dvec3(std::cos(azimuth) * std::cos(elevation),
                                             std::sin(azimuth) * std::cos(elevation), -std::sin(elevation));
    segment.from = source + way * double{request.minimum_range_m};
    segment.to = source + way * double{request.maximum_range_m};
    response = response_of(segment, request.response, request.minimum_range_m, around);
  }
  response.id = request.id;
  response.visible = false;  // of segments alone
  return response;
}

}  // namespace karst::ig
