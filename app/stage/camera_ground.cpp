// SPDX-License-Identifier: MIT
#include "app/stage/camera_ground.h"

#include <algorithm>
#include <cstdio>

#include <glm/geometric.hpp>

#include "app/stage/camera_view.h"

namespace karst::app {
namespace {

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
  if (!place.above_ground) return {};
  const WorldInfo& info = world_->info();
  // From above everything: the highest ground.
  const glm::dvec3 above(place.position_m.x, info.high_m.y + info.voxel_size_m, place.position_m.z);
  Hit hit;
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
  return hit.place.y;
}

double CameraGround::clearance_m(const glm::dvec3& place_m) {
  const double most = kClearance * world_->info().voxel_size_m;
  Hit hit;
  if (!query_->sphere(vec(place_m), vec(place_m), most, Wait::for_file, hit)) return most;
  return glm::length(glm::dvec3(hit.place.x, hit.place.y, hit.place.z) - place_m);
}

}  // namespace karst::app
