// SPDX-License-Identifier: MIT
// `caves`: halls with pillars, joined by tunnels that wind under hills, with mouths in a cliff and shafts to
// the sky.
#include "bake/samples/sample_solid.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>

namespace karst::bake {
namespace {

constexpr double kHalf = 188;  // metres; 47 x 47 voxels

struct Hall {
  glm::dvec3 centre, radii;
};
constexpr Hall kHalls[] = {
    {{-64, 46, -42}, {64, 36, 54}},
    {{78, 54, 34}, {56, 40, 48}},
    {{-22, 30, 92}, {44, 26, 36}},
    {{88, 34, -96}, {46, 26, 36}},
};

// A leg of a tunnel: radius at its two ends.
struct Leg {
  glm::dvec3 a, b;
  double ra, rb;
};
constexpr Leg kLegs[] = {
    // From the western cliff into the first hall, and on to the second.
    {{-200, 26, -20}, {-132, 30, -34}, 24, 19},
    {{-132, 30, -34}, {-96, 38, -40}, 19, 20},
    {{-30, 40, -18}, {12, 44, 8}, 19, 16},
    {{12, 44, 8}, {50, 46, 22}, 16, 19},
    // Down to the lower halls.
    {{-60, 34, 6}, {-50, 28, 50}, 17, 16},
    {{-50, 28, 50}, {-30, 28, 80}, 16, 18},
    {{86, 40, -8}, {104, 34, -52}, 17, 16},
    {{104, 34, -52}, {92, 34, -84}, 16, 18},
    // Mouths in the south and the east.
    {{-22, 28, 112}, {-34, 22, 160}, 18, 20},
    {{-34, 22, 160}, {-40, 20, 210}, 20, 26},
    {{104, 32, -96}, {150, 28, -112}, 18, 19},
    {{150, 28, -112}, {210, 26, -106}, 19, 26},
    {{112, 50, 50}, {150, 44, 76}, 18, 17},
    {{150, 44, 76}, {206, 36, 88}, 17, 24},
    // Shafts to the sky.
    {{-74, 60, -50}, {-80, 150, -54}, 17, 26},
    {{86, 70, 40}, {92, 150, 44}, 15, 22},
};

// Pillars stand where the halls' roofs would fall.
struct Pillar {
  glm::dvec2 middle;
  double waist, foot;
  double middle_y;
};
constexpr Pillar kPillars[] = {
    {{-40, -62}, 10, 22, 44}, {{-98, -28}, 9.5, 20, 46}, {{-48, -16}, 9, 19, 42},
    {{56, 50}, 10, 21, 52},   {{-8, 92}, 9, 17, 30},     {{76, -92}, 9, 17, 34},
};

class Caves final : public SampleShape {
 public:
  Caves() {
    content_m = {{-kHalf, 8, -kHalf}, {kHalf, 130, kHalf}};
    grain = {0.5, 6.5, 5, 0.25, -1e9, 9};
    land = {14, 500, 2600};
    ground_ = TabulatedPlane({-kHalf - 20, -kHalf - 20}, {kHalf + 20, kHalf + 20}, 2, hills);
  }

  double value_m(glm::dvec3 p) const override {
    const double wander = 4.5 * noise(p / 38.0, 61) + 2.0 * noise(p / 15.0, 62);
    const double ground = ground_.at(p.x, p.z) - p.y;
    const double rock = ground + 0.35 * wander;
    const double open = hollow(p, wander);
    return smooth_min(rock, -open, 5);
  }

  double ground_m(double x, double z) const override {
    // To the north the hills go on and become lower.
    const double north = smooth_step((-z - kHalf) / 420);
    const double height = hills(x, z);
    return height + north * (30 + 0.45 * (height - 17) - height);
  }
  double far_m(double x, double z, double away_m) const override {
    const double stands = smooth_step((away_m - 400) / 900);
    return stands > 0 ? 240 * stands * mountains(x, z, 1300, 76) : 0;
  }

 private:
  // Hills with a cliff towards the west and lower land in the south and the east.
  static double hills(double x, double z) {
    const glm::dvec2 p(x, z);
    const glm::dvec2 moved = p + 16.0 * glm::dvec2(noise(p / 60.0, 71), noise(p / 60.0, 72));
    const double west = smooth_step((moved.x + 168 + 10 * wave(z / 170)) / 34);
    const double south = 1 - smooth_step((moved.y - 126) / 46);
    const double east = 1 - smooth_step((moved.x - 132) / 44);
    const double high = 92 + 17 * fbm(moved / 120.0, 4, 73);
    return 17 + 3 * noise(p / 40.0, 74) + (high - 17) * west * (0.12 + 0.88 * south) * (0.15 + 0.85 * east);
  }

  // Positive inside the hollows.
  static double hollow(glm::dvec3 p, double wander) {
    double open = -1e9;
    for (const Hall& h : kHalls) {
      // Floors are flatter than roofs: fallen rock fills them.
      const double floor = h.centre.y - 0.55 * h.radii.y;
      const double hall = smooth_min(-ellipsoid_distance(h.centre, h.radii, p), p.y - floor, 14);
      open = smooth_max(open, hall, 10);
    }
    for (const Pillar& s : kPillars) {
      const glm::dvec2 off(p.x - s.middle.x, p.z - s.middle.y);
      const double above = std::abs(p.y - s.middle_y) / 26;
      const double radius = s.waist + (s.foot - s.waist) * smooth_step(above);
      open = smooth_min(open, std::sqrt(glm::dot(off, off)) - radius, 7);
    }
    for (const Leg& l : kLegs) {
      const glm::dvec3 ab = l.b - l.a;
      const double t = std::clamp(glm::dot(p - l.a, ab) / glm::dot(ab, ab), 0.0, 1.0);
      const glm::dvec3 off = p - (l.a + t * ab);
      open = smooth_max(open, l.ra + (l.rb - l.ra) * t - std::sqrt(glm::dot(off, off)), 8);
    }
    return open + 0.6 * wander;
  }

  TabulatedPlane ground_;
};

}  // namespace

std::unique_ptr<SampleShape> make_caves() {
  return std::make_unique<Caves>();
}

}  // namespace karst::bake
