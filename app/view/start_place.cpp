// SPDX-License-Identifier: MIT
#include "app/view/start_place.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "app/stage/camera_view.h"

namespace karst::app {
namespace {

constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180.0;

// Places that are tried: the middle, and rings around it, in parts of the width.
constexpr double kRings[] = {0.0, 0.02, 0.05, 0.1, 0.17, 0.25};
constexpr int kOnRing = 8;
constexpr double kLevel = 0.9;  // a normal's part of up: 25 degrees

// Directions, and distances at which heights are asked for: near ones may be in the way, far ones are the
// skyline, up to a part of the width.
constexpr int kDirections = 24;
constexpr double kNear_m[] = {3, 6, 12, 25};
constexpr double kNearest_m = 50, kNearestPart = 0.005, kFarthestPart = 0.6;
constexpr int kFar = 10;
constexpr double kInTheWay_deg = 3;  // what is near rises so much above the skyline

constexpr double kMostPitch_deg = 20;

glm::dvec3 vec(Vec3 v) {
  return {v.x, v.y, v.z};
}

class Search {
 public:
  Search(CameraGround& ground, const World& world) : ground_(ground), world_(world), info_(world.info()) {
    const ShownBox box = shown_box(info_);
    middle_ = 0.5 * (vec(box.low_m) + vec(box.high_m));
    width_ = std::min(box.high_m.x - box.low_m.x, box.high_m.z - box.low_m.z);
  }

  // Of a planet no place is the middle, nor of what goes around.
  bool has_middle() const {
    if (info_.basis == Basis::plane) return true;
    return info_.basis == Basis::geographic && width_ < info_.radius_m;
  }

  bool find(double eye_height_m, CameraPlace& place) {
    axes_ = ground_.axes_at(middle_);
    double best = -std::numeric_limits<double>::infinity();
    Hit found;
    for (const double ring : kRings) {
      for (int n = 0; n < (ring == 0.0 ? 1 : kOnRing); ++n) {
        Hit hit;
        if (!ground_.top(beside(middle_, 360.0 / kOnRing * n, ring * width_), true, hit)) continue;
        const double level = std::min(glm::dot(vec(hit.normal), vec(axes_.up)), kLevel);
        const double goodness = depth_m(hit) > 0 ? -depth_m(hit) - 1 : level;
        if (goodness <= best) continue;
        best = goodness;
        found = hit;
      }
      if (best >= kLevel) break;
    }
    if (std::isinf(best)) return false;
    axes_ = ground_.axes_at(vec(found.place));
    eye_ = vec(found.place) + (std::max(depth_m(found), 0.0) + eye_height_m) * vec(axes_.up);
    place = {};
    place.position_m = eye_;
    look(place);
    return true;
  }

 private:
  // So far from a place along the level.
  glm::dvec3 beside(const glm::dvec3& from, double yaw_deg, double metres) const {
    const double yaw = yaw_deg * kRadiansPerDegree;
    return from + metres * (std::cos(yaw) * vec(axes_.north) - std::sin(yaw) * vec(axes_.east));
  }
  // Of the water there; 0 or less: it is dry.
  double depth_m(const Hit& hit) const {
    if (!info_.has_water) return 0;
    if (info_.basis == Basis::plane) return info_.water_m - hit.place.y;
    Geodetic on_map;
    return world_.to_geodetic(hit.place, on_map) ? info_.water_m - on_map.altitude_m : 0;
  }
  // Degrees above the level at which the ground is seen so far away.
  double rise_deg(double yaw_deg, double metres, bool reads) {
    Hit hit;
    if (!ground_.top(beside(eye_, yaw_deg, metres), reads, hit)) return -90;
    const glm::dvec3 way = vec(hit.place) - eye_;
    return std::asin(std::clamp(glm::dot(glm::normalize(way), vec(axes_.up)), -1.0, 1.0)) / kRadiansPerDegree;
  }

  void look(CameraPlace& place) {
    double best = -std::numeric_limits<double>::infinity();
    const double first_m = std::max(kNearest_m, kNearestPart * width_);
    const double last_m = std::max(kFarthestPart * width_, first_m);
    for (int n = 0; n < kDirections; ++n) {
      const double yaw_deg = 360.0 / kDirections * n;
      double near_deg = -90, far_deg = -90;
      for (const double metres : kNear_m) near_deg = std::max(near_deg, rise_deg(yaw_deg, metres, true));
      for (int k = 0; k < kFar; ++k) {
        const double metres = first_m * std::pow(last_m / first_m, k / (kFar - 1.0));
        far_deg = std::max(far_deg, rise_deg(yaw_deg, metres, false));
      }
      const bool in_the_way = near_deg > std::max(far_deg, 0.0) + kInTheWay_deg;
      const double goodness = far_deg - (in_the_way ? 180 : 0);
      if (goodness <= best) continue;
      best = goodness;
      place.yaw_deg = yaw_deg > 180 ? yaw_deg - 360 : yaw_deg;
      // The skyline a little above the picture's middle.
      place.pitch_deg = std::clamp(0.5 * far_deg, 0.0, kMostPitch_deg);
    }
  }

  CameraGround& ground_;
  const World& world_;
  const WorldInfo& info_;
  LocalAxes axes_;
  glm::dvec3 middle_{0.0};
  glm::dvec3 eye_{0.0};
  double width_ = 0;
};

}  // namespace

bool start_place(CameraGround& ground, const World& world, double eye_height_m, CameraPlace& place) {
  Search search(ground, world);
  return search.has_middle() && search.find(eye_height_m, place);
}

}  // namespace karst::app
