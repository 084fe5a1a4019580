// SPDX-License-Identifier: MIT
// `canyon`: a river has cut three tiers of rock. Its size is that of K's test scene (chapter 5: 24,000 filled
// voxels, 3,560 patches), so that K's tables can be set beside ours.
//
// Each tier is what lies further from the river than the tier's edge and lower than its top; hard caps
// overhang the soft rock below them. A side canyon, alcoves and a tunnel are taken away, a natural bridge and
// a butte are added.
#include "app/bake/sample_solid.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>

namespace karst::bake {
namespace {

constexpr double kHalfX = 188, kHalfZ = 132;  // metres; 47 x 33 voxels

// The river's course: z of its middle by x. It leaves and enters the world on the west and east.
double course(double x) {
  return 34 * wave(x / 330 + 0.08) + 12 * wave(x / 143 + 0.3);
}

// A tier: from `edge_m` of the river outwards, up to `top_m`.
struct Tier {
  double edge_m, top_m;
  double cap_m;       // height of the hard cap
  double undercut_m;  // how far the soft rock below it recedes
};
constexpr std::array<Tier, 3> kTiers = {{{17, 40, 9, 6}, {45, 86, 12, 8}, {84, 122, 12, 9}}};

class Canyon final : public SampleShape {
 public:
  Canyon() {
    grain = {0.45, 7, 4.5, 0.4, 14, 5};
    content_m = {{-kHalfX, 0, -kHalfZ}, {kHalfX, 138, kHalfZ}};
    const glm::dvec2 min(-kHalfX - 20, -kHalfZ - 20), max(kHalfX + 20, kHalfZ + 20);
    for (int k = 0; k < kRiverPoints; ++k) {
      const double x = -kHalfX - 60 + (2 * kHalfX + 120) * k / (kRiverPoints - 1);
      river_[static_cast<std::size_t>(k)] = {x, course(x)};
    }
    from_river_ = TabulatedPlane(min, max, 2, [&](double x, double z) { return river_distance({x, z}); });
    from_gully_ = TabulatedPlane(min, max, 2, [&](double x, double z) { return gully_distance({x, z}); });
    swell_ =
        TabulatedPlane(min, max, 2, [](double x, double z) { return fbm(glm::dvec2(x, z) / 70.0, 4, 11); });
  }

  double value_m(glm::dvec3 p) const override {
    const double swell = swell_.at(p.x, p.z);
    // Buttresses and alcoves: the walls' distance wanders with the place and, less, with height.
    const double wander = 7 * noise(glm::dvec3(p.x / 46, p.y / 70, p.z / 46), 21) +
                          2.5 * noise(glm::dvec3(p.x / 17, p.y / 26, p.z / 17), 22);
    const double outwards = from_river_.at(p.x, p.z) + wander;

    // River bed: a shallow channel between gravel banks.
    const double bed = 3 + 1.2 * swell + 4 * smooth_step((from_river_.at(p.x, p.z) - 6) / 14);
    double value = bed - p.y;
    for (std::size_t k = 0; k < kTiers.size(); ++k) value = smooth_max(value, tier(k, p, outwards, swell), 3);
    value = smooth_max(value, butte(p, wander, swell), 4);
    value = smooth_min(value, -gully(p, wander), 4);
    value = smooth_max(value, bridge(p, wander), 8);
    for (const Hollow& h : kHollows) {
      value = smooth_min(value, ellipsoid_distance(h.centre, h.radii, p) + 0.3 * wander, 5);
    }
    return value;
  }

 private:
  static constexpr int kRiverPoints = 200;

  double river_distance(glm::dvec2 p) const {
    double least = 1e9;
    for (std::size_t k = 0; k + 1 < river_.size(); ++k) {
      least = std::min(least, segment_distance(river_[k], river_[k + 1], p));
    }
    return least;
  }

  // A side canyon that comes down from the north-west.
  static double gully_distance(glm::dvec2 p) {
    constexpr glm::dvec2 kCourse[] = {{-36, 10},  {-52, -22},  {-44, -52},
                                      {-70, -84}, {-66, -112}, {-88, -170}};
    double least = 1e9;
    for (std::size_t k = 0; k + 1 < std::size(kCourse); ++k) {
      least = std::min(least, segment_distance(kCourse[k], kCourse[k + 1], p));
    }
    return least;
  }

  // How far the rock recedes below the cap of a tier: nothing in the cap, most right under it, less further
  // down.
  static double recess(const Tier& tier, double below_top) {
    const double depth = below_top - tier.cap_m;
    return tier.undercut_m * smooth_step(depth / 5) * (1 - 0.75 * smooth_step((depth - 4) / 18));
  }

  static double tier(std::size_t k, glm::dvec3 p, double outwards, double swell) {
    const Tier& t = kTiers[k];
    // The plateau rolls; benches hardly do.
    const double top =
        t.top_m + (k == 2 ? 7.0 : 2.5) * swell + 3 * wave(0.004 * p.x + 0.3 * static_cast<double>(k));
    const double wall = outwards - t.edge_m - recess(t, top - p.y);
    return smooth_min(wall, top - p.y, 5);
  }

  // A tower that the river went around.
  static double butte(glm::dvec3 p, double wander, double swell) {
    const glm::dvec2 off(p.x - 96, p.z - 30);
    const double radius = 25 - 0.5 * wander;
    const double top = 92 + 2 * swell;
    const double below = top - p.y;
    const double wall = radius - recess({0, 0, 12, 6}, below) + 0.10 * std::max(below - 30, 0.0) -
                        std::sqrt(off.x * off.x + 1.5 * off.y * off.y);
    return smooth_min(wall, below, 5);
  }

  double gully(glm::dvec3 p, double wander) const {
    const double along = std::max(0.0, -p.z - 10) / 110;  // 0 at the river, 1 in the north
    const double floor = 4 + 70 * smooth_step(along * 0.9);
    const double half_width = 13 + 0.10 * std::max(0.0, p.y - floor);
    return smooth_min(half_width - from_gully_.at(p.x, p.z) - 0.6 * wander, p.y - floor, 8);
  }

  // A natural bridge over the inner gorge: a bar that sags to its ends.
  static double bridge(glm::dvec3 p, double wander) {
    const double t = std::clamp((p.z + 34) / 76, 0.0, 1.0);
    const double x = -112 + 10 * t;
    const double sag = 9 * (2 * t - 1) * (2 * t - 1);
    const glm::dvec2 off((p.x - x) / 1.25, p.y - (48 - sag));
    const double ends = std::max(-34 - p.z, p.z - 42);
    return std::min(11.5 - std::sqrt(off.x * off.x + off.y * off.y) + 0.25 * wander, -ends);
  }

  struct Hollow {
    glm::dvec3 centre, radii;
  };
  // Alcoves under the caps, and a window through the wall between river and side canyon.
  static constexpr Hollow kHollows[] = {
      {{30, 58, -64}, {34, 20, 24}}, {{128, 16, -18}, {26, 16, 22}}, {{-140, 60, 74}, {30, 19, 22}},
      {{36, 94, 100}, {30, 17, 22}}, {{-20, 22, -34}, {30, 14, 14}},
  };

  std::array<glm::dvec2, kRiverPoints> river_;
  TabulatedPlane from_river_, from_gully_, swell_;
};

}  // namespace

std::unique_ptr<SampleShape> make_canyon() {
  return std::make_unique<Canyon>();
}

}  // namespace karst::bake
