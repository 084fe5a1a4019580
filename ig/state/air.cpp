// SPDX-License-Identifier: MIT
#include "ig/state/air.h"

#include <algorithm>
#include <cmath>

#include "ig/place/sun_place.h"

namespace karst::ig {
namespace {

constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180.0;
constexpr bool is_cloud(std::size_t layer) {
  return layer >= 1 && layer <= 3;
}

bool is_date(const cigi::CelestialSphereControl& sphere) {
  return sphere.month() >= 1 && sphere.month() <= 12 && sphere.day() >= 1 && sphere.day() <= 31;
}

}  // namespace

void HostAir::take(const cigi::CelestialSphereControl& sphere, std::int64_t now_ns) {
  if (sphere.date_time_valid && is_date(sphere)) {
    const double seconds = sphere.hour * 3600.0 + sphere.minute * 60.0 + double{sphere.second};
    days_ = days_of(static_cast<int>(sphere.year()), static_cast<int>(sphere.month()),
                    static_cast<int>(sphere.day()), seconds);
    has_date_ = true;
    taken_ns_ = now_ns;
  } else if (sphere_.ephemeris) {
    days_ += static_cast<double>(now_ns - taken_ns_) * (1e-9 / 86'400);
    taken_ns_ = now_ns;
  } else {
    taken_ns_ = now_ns;
  }
  sphere_ = sphere;
}

bool HostAir::take(const cigi::WeatherControl& layer) {
  if (layer.scope != cigi::WeatherScope::global || layer.layer >= kLayers) return !layer.enabled;
  Layer& own = layers_[layer.layer];
  own = {layer.enabled && !is_cloud(layer.layer), layer.visibility_m, layer.base_elevation_m,
         layer.thickness_m};
  return !layer.enabled || !is_cloud(layer.layer);
}

void HostAir::light(const Earth& earth, glm::dvec3 eye, std::int64_t now_ns, Sun& sun) const {
  Geodetic here;
  if (!earth.to_geodetic(eye, here)) return;
  if (has_date_ && sphere_.sun) {
    double days = days_;
    if (sphere_.ephemeris) days += static_cast<double>(now_ns - taken_ns_) * (1e-9 / 86'400);
    const SunPlace place = sun_place(days, here.latitude_deg, here.longitude_deg);
    const double azimuth = place.azimuth_deg * kRadiansPerDegree;
    const double elevation = place.elevation_deg * kRadiansPerDegree;
    const glm::dmat3 axes = earth.axes_at(eye);
    const glm::dvec3 towards =
        axes * glm::dvec3(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                          -std::sin(elevation));
    sun.towards = {towards.x, towards.y, towards.z};
  }
  double visibility_m = visibility_m_;
  for (const Layer& layer : layers_) {
    if (!layer.enabled || !(layer.visibility_m > 0)) continue;
    if (here.altitude_m < layer.base_m || here.altitude_m > layer.base_m + layer.thickness_m) continue;
    visibility_m = visibility_m > 0 ? std::min(visibility_m, layer.visibility_m) : layer.visibility_m;
  }
  if (visibility_m > 0) sun.visibility_m = std::max(visibility_m, 1.0);
}

}  // namespace karst::ig
