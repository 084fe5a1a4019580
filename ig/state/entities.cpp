// SPDX-License-Identifier: MIT
#include "ig/state/entities.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "platform/base/clock.h"

namespace karst::ig {
namespace {

glm::dvec3 vec(Vec3 v) {
  return {v.x, v.y, v.z};
}

double seconds_between(std::int64_t from, std::int64_t to) {
  return static_cast<double>(to - from) * 1e-9;
}

// As it has moved by itself in this time, in the axes that its place is said in: x, y and z, or north, east
// and down.
glm::dvec3 way_of(const Entity& entity, const glm::dmat3& own_axes, const glm::dmat3& base_axes, double s) {
  const glm::dvec3 velocity(entity.rate.x_m_s, entity.rate.y_m_s, entity.rate.z_m_s);
  return (entity.rate.local ? own_axes : base_axes) * velocity * s;
}

glm::dmat3 attitude(const Entity& entity, const glm::dmat3& base, double s) {
  const cigi::EntityPosition& at = entity.position;
  return turned(base, at.yaw_deg + double{entity.rate.yaw_deg_s} * s,
                at.pitch_deg + double{entity.rate.pitch_deg_s} * s,
                at.roll_deg + double{entity.rate.roll_deg_s} * s);
}

Geodetic geodetic_of(const cigi::EntityPosition& at) {
  return {at.longitude_deg_or_y_m, at.latitude_deg_or_x_m, at.altitude_m_or_z_m};
}

// North, east and down, tilted so that down goes into the ground.
glm::dmat3 tilted(const glm::dmat3& axes, glm::dvec3 normal) {
  const glm::dvec3 down = -normal;
  const glm::dvec3 east = glm::cross(down, axes[0]);
  if (!(glm::length(east) > 1e-6)) return axes;
  const glm::dvec3 right = glm::normalize(east);
  return {glm::cross(right, down), right, down};
}

}  // namespace

Entities::Entities() : entities_(kMost), slots_(65'536, kNone) {}

void Entities::clear() {
  std::fill(slots_.begin(), slots_.end(), kNone);
  count_ = 0;
}

Entity* Entities::own(std::uint16_t id) {
  return slots_[id] == kNone ? nullptr : &entities_[slots_[id]];
}

const Entity* Entities::find(std::uint16_t id) const {
  return slots_[id] == kNone ? nullptr : &entities_[slots_[id]];
}

Entity* Entities::find_or_add(std::uint16_t id) {
  if (Entity* const known = own(id); known != nullptr) return known;
  if (count_ == kMost) return nullptr;
  slots_[id] = static_cast<std::uint16_t>(count_);
  Entity& entity = entities_[count_++];
  entity = {};
  entity.id = id;
  return &entity;
}

// And what is attached to it.
void Entities::remove(std::uint16_t id) {
  if (slots_[id] == kNone) return;
  std::size_t doomed = slots_[id];
  // Each turn removes one; those attached to what has gone are found by their parents.
  for (;;) {
    slots_[entities_[doomed].id] = kNone;
    if (doomed != --count_) {
      entities_[doomed] = entities_[count_];
      slots_[entities_[doomed].id] = static_cast<std::uint16_t>(doomed);
    }
    for (doomed = 0; doomed < count_; ++doomed) {
      const cigi::EntityPosition& at = entities_[doomed].position;
      if (entities_[doomed].has_position && at.attached && slots_[at.parent] == kNone) break;
    }
    if (doomed == count_) return;
  }
}

bool Entities::take(const cigi::EntityControl& control) {
  if (control.state == cigi::EntityState::destroyed) {
    remove(control.entity);
    return true;
  }
  Entity* const entity = find_or_add(control.entity);
  if (entity == nullptr) return false;
  entity->control = control;
  return true;
}

bool Entities::take(const cigi::EntityPosition& position, std::int64_t now_ns) {
  Entity* const entity = own(position.entity);
  // What is destroyed in the same packet is not made anew.
  if (entity == nullptr) return count_ < kMost;
  entity->position = position;
  entity->has_position = true;
  entity->since_ns = now_ns;
  return true;
}

void Entities::take(const cigi::RateControl& rate, const Earth& earth, std::int64_t now_ns) {
  Entity* const entity = own(rate.entity);
  if (entity == nullptr || rate.of_part) return;
  // It goes on from where it is.
  if (entity->has_rate && entity->has_position) {
    cigi::EntityPosition& at = entity->position;
    const double s = seconds_between(entity->since_ns, now_ns);
    glm::dvec3 place;
    Geodetic geodetic = geodetic_of(at);
    if (at.attached) {
      const glm::dmat3 base(1.0);
      const glm::dvec3 way = way_of(*entity, attitude(*entity, base, 0), base, s);
      at.latitude_deg_or_x_m += way.x;
      at.longitude_deg_or_y_m += way.y;
      at.altitude_m_or_z_m += way.z;
    } else if (earth.to_world(geodetic, place)) {
      const glm::dmat3 base = earth.axes_at(place);
      place += way_of(*entity, attitude(*entity, base, 0), base, s);
      if (earth.to_geodetic(place, geodetic)) {
        at.latitude_deg_or_x_m = geodetic.latitude_deg;
        at.longitude_deg_or_y_m = geodetic.longitude_deg;
        at.altitude_m_or_z_m = geodetic.altitude_m;
      }
    }
    const auto add = [&](float& angle, float by) {
      angle = static_cast<float>(angle + std::remainder(double{by} * s, 360.0));
    };
    add(at.yaw_deg, entity->rate.yaw_deg_s);
    add(at.pitch_deg, entity->rate.pitch_deg_s);
    add(at.roll_deg, entity->rate.roll_deg_s);
    entity->since_ns = now_ns;
  }
  if (!entity->has_rate) entity->since_ns = now_ns;
  entity->rate = rate;
  entity->has_rate = true;
}

void Entities::advance(const Earth& earth, Query& query, std::int64_t now_ns) {
  ++visit_;
  query.allow_reads(kGroundReads);
  ground_until_ = karst::now_ns() + kGround_ns;
  grounds_ = 0;
  const std::size_t first = turn_ < count_ ? turn_ : 0;
  turn_ = count_;
  for (std::size_t n = 0; n < count_; ++n) {
    const std::size_t at = first + n < count_ ? first + n : first + n - count_;
    const bool has_time = ground_until_ != 0;
    place(entities_[at], earth, query, now_ns, 0);
    if (has_time && ground_until_ == 0) turn_ = at;
  }
}

// The highest ground at the place, whatever its height. False: there is none, or it was not asked yet.
bool Entities::find_ground(Entity& entity, const Earth& earth, Query& query, glm::dvec3 place) {
  if (ground_until_ != 0 && grounds_ % 8 == 7 && karst::now_ns() > ground_until_) ground_until_ = 0;
  if (ground_until_ == 0) return entity.has_ground;
  ++grounds_;
  Hit hit;
  Geodetic ground;
  entity.has_ground = query.column({place.x, place.y, place.z}, Wait::for_file, {&hit, 1}) > 0 &&
                      earth.to_geodetic(vec(hit.place), ground);
  if (!entity.has_ground) return false;
  entity.ground_altitude_m = ground.altitude_m;
  entity.ground_normal = vec(hit.normal);
  return true;
}

void Entities::place(Entity& entity, const Earth& earth, Query& query, std::int64_t now_ns, int parents) {
  if (entity.visit == visit_) return;
  entity.visit = visit_;
  entity.is_placed = entity.is_seen = false;
  if (!entity.has_position) return;
  const cigi::EntityPosition& at = entity.position;
  const double s = entity.has_rate ? std::max(seconds_between(entity.since_ns, now_ns), 0.0) : 0;
  const bool shows = entity.control.state == cigi::EntityState::active && entity.control.type != 0;
  entity.alpha = static_cast<float>(entity.control.alpha) / 255;
  if (at.attached) {
    Entity* const parent = own(at.parent);
    if (parent == nullptr || parents == kMostParents) return;
    place(*parent, earth, query, now_ns, parents + 1);
    // A parent that is being placed is its own ancestor.
    if (!parent->is_placed) return;
    const glm::dvec3 offset(at.latitude_deg_or_x_m, at.longitude_deg_or_y_m, at.altitude_m_or_z_m);
    const glm::dmat3 still = attitude(entity, parent->body.axes, 0);
    entity.body.axes = attitude(entity, parent->body.axes, s);
    entity.body.place = parent->body.at(offset) + way_of(entity, still, parent->body.axes, s);
    if (entity.control.inherit_alpha) entity.alpha *= parent->alpha;
    entity.is_placed = true;
    entity.is_seen = shows && parent->control.state == cigi::EntityState::active;
    return;
  }
  glm::dvec3 place;
  Geodetic geodetic = geodetic_of(at);
  if (!earth.to_world(geodetic, place)) return;
  glm::dmat3 base = earth.axes_at(place);
  place += way_of(entity, attitude(entity, base, 0), base, s);
  if (at.clamp != cigi::Clamp::none && find_ground(entity, earth, query, place) &&
      earth.to_geodetic(place, geodetic)) {
    geodetic.altitude_m = entity.ground_altitude_m + at.altitude_m_or_z_m;
    earth.to_world(geodetic, place);
    if (at.clamp == cigi::Clamp::altitude_and_attitude) base = tilted(base, entity.ground_normal);
  }
  entity.body.place = place;
  entity.body.axes = attitude(entity, base, s);
  entity.is_placed = true;
  entity.is_seen = shows;
}

}  // namespace karst::ig
