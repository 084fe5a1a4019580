// SPDX-License-Identifier: MIT
// Sun and haze, as a host says them.
#pragma once

#include <array>
#include <cstdint>

#include "ig/cigi/packets.h"
#include "ig/place/earth.h"
#include "karst/renderer.h"

namespace karst::ig {

class HostAir {
 public:
  void clear() { *this = {}; }
  void take(const cigi::CelestialSphereControl& sphere, std::int64_t now_ns);
  void take(const cigi::AtmosphereControl& atmosphere) { visibility_m_ = atmosphere.visibility_m; }
  // False: a layer that is not drawn: clouds, and what is not global.
  bool take(const cigi::WeatherControl& layer);

  // What the host has said of it, at an eye; the rest stays. Haze is that of the thickest of the air that
  // the eye is in: the atmosphere's, and layers' from their base up to base and thickness.
  void light(const Earth& earth, glm::dvec3 eye, std::int64_t now_ns, Sun& sun) const;

 private:
  static constexpr std::size_t kLayers = 10;
  struct Layer {
    bool enabled = false;
    double visibility_m = 0, base_m = 0, thickness_m = 0;
  };

  cigi::CelestialSphereControl sphere_;
  bool has_date_ = false;
  double days_ = 0;  // since noon of 1 January 2000, at taken_ns_
  std::int64_t taken_ns_ = 0;
  double visibility_m_ = 0;
  std::array<Layer, kLayers> layers_{};
};

}  // namespace karst::ig
