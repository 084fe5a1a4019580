// SPDX-License-Identifier: MIT
#include "app/stage/camera_ground.h"

#include <algorithm>
#include <cstdio>

#include <glm/geometric.hpp>

#include "app/stage/camera_view.h"

namespace karst::app {
namespace {

constexpr double kHigh_m = 1e6;  // above any ground

Vec3 vec(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

}  // namespace

CameraGround::~CameraGround() {
  if (query_ != nullptr) world_->release(query_);
}

Error CameraGround::open(World& world) {
  world_ = &world;
  return {"ground", world.take_query(query_)};
}

Error CameraGround::stand(CameraPlace& place) {
  const WorldInfo& info = world_->info();
  if (place.on_map) {
    CameraPlace placed = place;
    if (Error error = find_on_map(placed); !error.ok()) return error;
    placed.on_map = false;
    if (Error error = stand(placed); !error.ok()) return error;
    place = placed;
    return {};
  }
  if (!place.above_ground) return {};
  Hit hit;
  if (info.basis != Basis::plane) {
    // position_m is a place of height 0, height_m_ above which it is wanted.
    if (!query_->ground(vec(place.position_m), kHigh_m, Wait::for_file, hit))
      return "there is no ground there";
    const LocalAxes axes = world_->axes_at(hit.place);
    const glm::dvec3 up(axes.up.x, axes.up.y, axes.up.z);
    place.position_m = glm::dvec3(hit.place.x, hit.place.y, hit.place.z) + height_m_ * up;
    place.above_ground = false;
    return {};
  }
  // From above everything: the highest ground.
  const glm::dvec3 above(place.position_m.x, info.high_m.y + info.voxel_size_m, place.position_m.z);
  if (!query_->ground(vec(above), 0, Wait::for_file, hit)) {
    char text[96];
    std::snprintf(text, sizeof text, "there is no ground at %.10g,%.10g to stand on", place.position_m.x,
                  place.position_m.z);
    return text;
  }
  place.position_m.y += hit.place.y;
  place.above_ground = false;
  return {};
}

// From a place on the map to one in the world's metres; what counts from the ground still does.
Error CameraGround::find_on_map(CameraPlace& place) {
  const WorldInfo& info = world_->info();
  const glm::dvec3 at = place.position_m;
  // On a plane y is what is added to the ground; else the place is put at height 0.
  const bool curved = info.basis != Basis::plane;
  const double height_m = curved && place.above_ground ? 0.0 : at.z;
  height_m_ = at.z;
  Vec3 found;
  const bool known = info.is_geodetic ? world_->from_geodetic({at.x, at.y, height_m}, found)
                                      : world_->from_projected({at.x, at.y, height_m}, found);
  if (!known) return "the world does not know where it lies; --camera X,Y,Z,... is in its own metres";
  place.position_m = {found.x, found.y, found.z};
  return {};
}

LocalAxes CameraGround::axes_at(const glm::dvec3& place_m) const {
  return world_->axes_at(vec(place_m));
}

Error CameraGround::in_rock(const CameraPlace& place) {
  const Vec3 at = vec(place.position_m);
  if (!query_->inside(at, Wait::for_file)) return {};
  Hit hits[32];
  const std::uint32_t count = query_->column(at, Wait::for_file, hits);
  double above_m = 0;  // to the lowest surface above the place
  for (const Hit& hit : std::span(hits).first(std::min<std::size_t>(count, std::size(hits)))) {
    if (hit.distance < 0) above_m = -hit.distance;
  }
  char text[160];
  std::snprintf(text, sizeof text,
                "the camera is inside rock, %.4g m below the ground; --camera X,~2,Z,... stands 2 m above it",
                above_m);
  return text;
}

std::optional<double> CameraGround::below_m(const glm::dvec3& place_m, double step_m) {
  Hit hit;
  if (!query_->ground(vec(place_m), step_m, Wait::for_file, hit)) return std::nullopt;
  return world_->info().basis == Basis::plane ? hit.place.y : place_m.y - hit.distance;
}

bool CameraGround::top(const glm::dvec3& place_m, bool reads, Hit& hit) {
  return query_->ground(vec(place_m), kHigh_m, reads ? Wait::for_file : Wait::never, hit);
}

double CameraGround::clearance_m(const glm::dvec3& place_m) {
  const double most = kClearance * world_->info().voxel_size_m;
  Hit hit;
  if (!query_->sphere(vec(place_m), vec(place_m), most, Wait::for_file, hit)) return most;
  return glm::length(glm::dvec3(hit.place.x, hit.place.y, hit.place.z) - place_m);
}

}  // namespace karst::app
