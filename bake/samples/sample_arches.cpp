// SPDX-License-Identifier: MIT
// `arches`: free-standing arches, fins with windows and balanced towers of sandstone on a plain of low dunes.
#include "bake/samples/sample_solid.h"

#include <glm/geometric.hpp>

#include <algorithm>

namespace karst::bake {
namespace {

constexpr double kHalf = 188;  // metres; 47 x 47 voxels

// An arch stands in a vertical plane: half of an ellipse between two feet, thick at the feet and thin at the
// crown.
struct Arch {
  glm::dvec2 middle;       // x, z
  glm::dvec2 direction;    // from foot to foot, unit length
  double half_span, rise;  // to the middle of the rock
  double foot, crown;      // radii
};

// A wall of rock with rounded top and, where its radius is above 0, a window.
struct Fin {
  glm::dvec2 from, to;
  double half_thickness, top;
  glm::dvec3 window;
  glm::dvec3 window_radii;
};

// A tower whose waist is narrower than its cap.
struct Tower {
  glm::dvec2 middle;
  double foot, waist, cap, height;
};

constexpr Arch kArches[] = {
    {{-22, 26}, {0.96, 0.28}, 62, 88, 21, 12.5},
    {{92, -64}, {0.6, 0.8}, 44, 60, 19, 11.5},
    {{-112, -92}, {0.28, -0.96}, 36, 50, 18, 11},
};
constexpr Fin kFins[] = {
    {{-150, 96}, {-18, 128}, 15, 58, {-84, 24, 112}, {24, 19, 40}},
    {{-30, -128}, {54, -142}, 14, 46, {12, 20, -135}, {17, 14, 40}},
    {{120, 38}, {150, 134}, 16, 66, {136, 26, 88}, {40, 19, 21}},
};
constexpr Tower kTowers[] = {
    {{62, 104}, 24, 12.5, 18, 62},
    {{-120, 10}, 22, 12, 17, 50},
    {{20, -62}, 17, 11.5, 15, 38},
    {{150, -10}, 18, 12, 16, 44},
};

class Arches final : public SampleShape {
 public:
  Arches() {
    content_m = {{-kHalf, 2, -kHalf}, {kHalf, 106, kHalf}};
    grain = {0.5, 6, 3.5, 0.35, 17, 7};
    land = {8, 900, 2600};
    sand_ = TabulatedPlane({-kHalf - 20, -kHalf - 20}, {kHalf + 20, kHalf + 20}, 2, dunes);
  }

  double value_m(glm::dvec3 p) const override {
    const double wander = 3.2 * noise(p / 31.0, 41) + 1.4 * noise(p / 13.0, 42);
    // Rock wears back along soft layers.
    const double layers = 1.6 * noise(glm::dvec3(p.x * 0.006, p.y / 9, p.z * 0.006), 43);
    double rock = -1e9;
    for (const Fin& f : kFins) rock = std::max(rock, fin(f, p));
    for (const Tower& t : kTowers) rock = smooth_max(rock, tower(t, p), 8);
    for (const Arch& a : kArches) rock = smooth_max(rock, arch(a, p), 8);
    const double sand = sand_.at(p.x, p.z) - p.y;
    return smooth_max(rock + wander + layers, sand, 9);  // sand is blown against the rock
  }
  double ground_m(double x, double z) const override { return dunes(x, z); }
  // Tables and needles of the same rock.
  double far_m(double x, double z, double away_m) const override {
    const double stands = smooth_step((away_m - 450) / 600);
    if (stands <= 0) return 0;
    return 120 * mesas(x, z, 900, 53) * stands + 60 * mountains(x, z, 2300, 58) * stands;
  }

 private:
  // Long crests across the wind, which blows from the west.
  static double dunes(double x, double z) {
    const glm::dvec2 p(x, z);
    const double shift = 26 * fbm(p / 120.0, 3, 51);
    const double crest = wave((x + 0.35 * z + shift) / 74);
    return 10 + 3.2 * crest + 5.5 * fbm(p / 140.0, 2, 52) + 0.35 * wave((x + 0.2 * z + shift) / 9.5);
  }

  static double arch(const Arch& a, glm::dvec3 p) {
    const glm::dvec2 off(p.x - a.middle.x, p.z - a.middle.y);
    const double along = glm::dot(off, a.direction);
    const double across = off.x * a.direction.y - off.y * a.direction.x;
    // Distance to the ellipse in its plane; below the ground the feet go straight down.
    const double y = std::max(p.y, 0.0);
    const glm::dvec2 q(along / a.half_span, y / a.rise);
    const glm::dvec2 g(q.x / a.half_span, q.y / a.rise);
    const double length = std::sqrt(glm::dot(q, q)), slope = std::sqrt(glm::dot(g, g));
    const double in_plane = slope > 1e-9 ? length * (length - 1) / slope : -a.rise;
    const double up = std::clamp(y / a.rise, 0.0, 1.0);
    const double radius = a.foot + (a.crown - a.foot) * smooth_step(up * 1.1);
    return radius - std::sqrt(in_plane * in_plane + across * across * 0.85);
  }

  static double fin(const Fin& f, glm::dvec3 p) {
    const double wall = f.half_thickness - segment_distance(f.from, f.to, glm::dvec2(p.x, p.z)) -
                        0.05 * std::max(p.y - 20, 0.0);
    const double top = f.top + 7 * wave(p.x / 61) + 5 * wave(p.z / 47) - p.y;
    const double solid = smooth_min(wall + 2, top, 16);
    if (f.window_radii.x <= 0) return solid;
    return smooth_min(solid, ellipsoid_distance(f.window, f.window_radii, p), 6);
  }

  static double tower(const Tower& t, glm::dvec3 p) {
    const glm::dvec2 off(p.x - t.middle.x, p.z - t.middle.y);
    const double up = p.y / t.height;
    double radius = t.foot + (t.waist - t.foot) * smooth_step(up / 0.55);
    radius += (t.cap - t.waist) * smooth_step((up - 0.55) / 0.25);
    return smooth_min(radius - std::sqrt(glm::dot(off, off)), t.height - p.y, 12);
  }

  TabulatedPlane sand_;
};

}  // namespace

std::unique_ptr<SampleShape> make_arches() {
  return std::make_unique<Arches>();
}

}  // namespace karst::bake
