// SPDX-License-Identifier: MIT
// `canyon`: a river has cut three tiers of rock. Its size is that of K's test scene (chapter 5: 24,000 filled
// voxels, 3,560 patches), so that K's tables can be set beside ours.
//
// Each tier is what lies further from the river than the tier's edge and lower than its top; hard caps
// overhang the soft rock below them. A side canyon, alcoves and a window are taken away, a natural bridge and
// a butte are added.
#include "bake/samples/sample_solid.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace karst::bake {
namespace {

constexpr double kVoxelM = 10;
constexpr double kHalfX = 200, kHalfZ = 145;  // metres; 40 x 29 voxels

// The river's course: z of its middle by x. It enters and leaves the world in the west and the east.
double course(double x) {
  return 36 * wave(x / 330 + 0.08) + 13 * wave(x / 143 + 0.3);
}

// Beyond the world of the samples the river has wider bends, too.
double far_course(double x) {
  return course(x) + 420 * smooth_step((std::abs(x) - 260) / 1500) * noise(glm::dvec2(x / 900, 0.37), 17);
}

// A tier of rock: from about `edge_m` of the river outwards, about `top_m` high.
struct Tier {
  double edge_m, top_m;
  double cap_m;       // height of the hard cap
  double undercut_m;  // how far the soft rock below it recedes, at most
};
constexpr std::array<Tier, 3> kTiers = {{{18, 38, 14, 7}, {44, 84, 17, 10}, {82, 124, 18, 11}}};

// Alcoves under the caps: where along the river, on its north (-1) or south (+1) side, in which tier.
struct Alcove {
  double x;
  int side;
  std::size_t tier;
  glm::dvec3 radii;
};
constexpr Alcove kAlcoves[] = {
    {-150, 1, 1, {36, 17, 22}}, {-18, 1, 1, {30, 16, 20}}, {28, -1, 2, {34, 17, 22}},
    {150, -1, 1, {34, 17, 20}}, {146, 1, 2, {30, 15, 20}}, {-160, -1, 2, {32, 16, 20}},
};

// A tower that the river once went around: the canyon is wider there.
constexpr glm::dvec2 kButte = {88, -26};

constexpr double kBridgeX = -112;

// A side canyon that comes down from the north-west.
constexpr glm::dvec2 kGully[] = {{-36, 10}, {-52, -22}, {-44, -52}, {-70, -84}, {-66, -112}, {-88, -170}};

double distance_to(const glm::dvec2* points, std::size_t count, glm::dvec2 p) {
  double least = 1e9;
  for (std::size_t k = 0; k + 1 < count; ++k)
    least = std::min(least, segment_distance(points[k], points[k + 1], p));
  return least;
}

// How far the rock recedes below a cap: nothing in the cap, most right under it, less further down.
double recess(const Tier& tier, double below_top) {
  const double depth = below_top - tier.cap_m;
  return tier.undercut_m * smooth_step(depth / 9) * (1 - 0.8 * smooth_step((depth - 7) / 20));
}

class Canyon final : public SampleShape {
 public:
  Canyon() {
    content_m = {{-kHalfX, -100, -kHalfZ}, {kHalfX, 140, kHalfZ}};
    voxel_m = kVoxelM;
    grain = {0.5, 8, 5, 0.45, 13, 5};
    land = {1, 650, 2300};
    const glm::dvec2 max(kHalfX + 40, kHalfZ + 40);
    std::array<glm::dvec2, 200> river;
    for (std::size_t k = 0; k < river.size(); ++k) {
      const double x = (2 * static_cast<double>(k) / (river.size() - 1) - 1) * (kHalfX + 100);
      river[k] = {x, course(x)};
    }
    const auto tabulate = [&](const auto& function) { return TabulatedPlane(-max, max, 2, function); };
    from_river_ = tabulate([&](double x, double z) {
      return distance_to(river.data(), river.size(), {x, z});
    });
    from_gully_ = tabulate([](double x, double z) { return distance_to(kGully, std::size(kGully), {x, z}); });
    swell_ = tabulate([](double x, double z) { return fbm(glm::dvec2(x, z) / 70.0, 4, 11); });
    for (std::size_t k = 0; k < kTiers.size(); ++k) {
      const auto seed = static_cast<std::uint32_t>(80 + 10 * k);
      shift_[k] = tabulate([&](double x, double z) { return fbm(glm::dvec2(x, z) / 95.0, 2, seed); });
    }
  }

  double value_m(glm::dvec3 p) const override {
    const double swell = swell_.at(p.x, p.z);
    // Buttresses and alcoves: the walls' distance wanders with the place and, less, with height.
    const double wander = 8 * noise(glm::dvec3(p.x / 44, p.y / 80, p.z / 44), 21) +
                          3 * noise(glm::dvec3(p.x / 17, p.y / 30, p.z / 17), 22);
    const double from_river = from_river_.at(p.x, p.z);

    // River bed: a shallow channel between banks that rise to the walls.
    const double banks = 5 * smooth_step((from_river - 7) / 12) + 0.25 * std::max(from_river - 14, 0.0);
    double value = 3 + swell + banks - p.y;
    for (std::size_t k = 0; k < kTiers.size(); ++k) {
      value = smooth_max(value, tier(k, p, from_river + wander, swell), 4);
    }
    value = smooth_max(value, butte(p, wander, swell), 5);
    value = smooth_min(value, -gully(p, wander), 5);
    value = smooth_max(value, bridge(p, wander), 9);
    for (const Alcove& a : kAlcoves) {
      const Tier& t = kTiers[a.tier];
      const glm::dvec3 centre(a.x, t.top_m - t.cap_m - a.radii.y + 2, course(a.x) + a.side * (t.edge_m + 8));
      value = smooth_min(value, ellipsoid_distance(centre, a.radii, p) + 0.3 * wander, 6);
    }
    return value;
  }

  // The same tiers without what overhangs; their walls become slopes away from the sample.
  double ground_m(double x, double z) const override {
    const glm::dvec2 p(x, z);
    const glm::dvec2 out(std::max(std::abs(x) - kHalfX, 0.0), std::max(std::abs(z) - kHalfZ, 0.0));
    const double far = smooth_step(std::sqrt(glm::dot(out, out)) / 1200);
    const double swell = fbm(p / 70.0, 4, 11);
    const double from_river = far_from_river(p);
    double height =
        3 + swell + 5 * smooth_step((from_river - 7) / 12) + 0.25 * std::clamp(from_river - 14, 0.0, 80.0);
    for (std::size_t k = 0; k < kTiers.size(); ++k) {
      const Tier& t = kTiers[k];
      const double shift = fbm(p / 95.0, 2, static_cast<std::uint32_t>(80 + 10 * k));
      const double y = t.top_m - 0.5 * t.cap_m;
      const double wander = 8 * noise(glm::dvec3(x / 44, y / 80, z / 44), 21) +
                            3 * noise(glm::dvec3(x / 17, y / 30, z / 17), 22);
      const double inwards = from_river + wander - t.edge_m - (k == 0 ? 7.0 : 24.0) * shift;
      const double top = t.top_m + 5 * swell - 9 * shift + std::min(0.12 * std::max(inwards, 0.0), 6.0);
      const double width = 20 + 90 * far;
      const double rise = smooth_step((inwards + 0.55 * width) / width);
      height += rise * std::max(top - height, 0.0);
    }
    return carve_gully(p, height);
  }
  // Mesas on the plain, none in the river's way.
  double far_m(double x, double z, double away_m) const override {
    const double stands =
        smooth_step((away_m - 900) / 700) * smooth_step((std::abs(z - far_course(x)) - 250) / 300);
    return stands > 0 ? 130 * stands * mesas(x, z, 1000, 15) + 50 * stands * mountains(x, z, 2600, 25) : 0;
  }

 private:
  // Distance to the river, kMostFrom at most.
  static double far_from_river(glm::dvec2 p) {
    constexpr double kMostFrom = 260, kStep = 6;
    double least = kMostFrom;
    glm::dvec2 last[2] = {{p.x, far_course(p.x)}, {p.x, far_course(p.x)}};
    for (double away = kStep; away - kStep < least; away += kStep) {
      for (const int side : {0, 1}) {
        const double at = p.x + (side == 0 ? away : -away);
        const glm::dvec2 next(at, far_course(at));
        least = std::min(least, segment_distance(last[side], next, p));
        last[side] = next;
      }
    }
    return least;
  }

  // The side canyon goes on to the north and ends in the plateau.
  static double carve_gully(glm::dvec2 p, double height) {
    if (p.x < -300 || p.x > 120 || p.y > 20 || p.y < -520) return height;
    constexpr glm::dvec2 kOn[] = {kGully[5], {-104, -250}, {-70, -330}, {-120, -440}};
    const double from =
        std::min(distance_to(kGully, std::size(kGully), p), distance_to(kOn, std::size(kOn), p));
    const double along = std::max(0.0, -p.y - 10) / 110;
    const double floor = 4 + 70 * smooth_step(along * 0.9) + 75 * smooth_step((-p.y - 150) / 300);
    const double wander = 8 * noise(glm::dvec3(p.x / 44, 1.2, p.y / 44), 21);
    return smooth_min(height, floor + 1.4 * std::max(from + 0.6 * wander - 13, 0.0), 8);
  }

  double tier(std::size_t k, glm::dvec3 p, double outwards, double swell) const {
    const Tier& t = kTiers[k];
    // Where a tier's edge comes close to the next one's, two cliffs are one; where they part, there is a wide
    // bench.
    const double shift = shift_[k].at(p.x, p.z);
    const glm::dvec2 off = glm::dvec2(p.x, p.z) - kButte;
    const double widening =
        k == 0 ? 0 : 52 * (1 - smooth_step(std::sqrt(off.x * off.x + off.y * off.y) / 105));
    const double inwards = outwards - t.edge_m - widening - (k == 0 ? 7.0 : 24.0) * shift;
    // Benches rise with the rock behind them; the plateau rolls.
    const double below = t.top_m + 5 * swell - 9 * shift + std::min(0.12 * inwards, 6.0) - p.y;
    // Fallen rock lies at the foot of the walls.
    const double height = t.top_m - (k == 0 ? 0.0 : kTiers[k - 1].top_m);
    const double scree = 6 * smooth_step((below - 0.6 * height) / 14);
    // Above the bridge's ends the wall is whole: between them and a cap the air would be one voxel thick.
    const double whole = k == 1 ? smooth_step((std::abs(p.x - kBridgeX) - 16) / 24) : 1;
    const double wall = inwards - recess(t, below) * (0.6 + 0.5 * swell) * whole + scree;
    return smooth_min(wall, below, 6);
  }

  static double butte(glm::dvec3 p, double wander, double swell) {
    const glm::dvec2 off = glm::dvec2(p.x, p.z) - kButte;
    const double below = 98 + 3 * swell - p.y;
    const double radius =
        22 - 0.6 * wander - recess({0, 0, 16, 3.5}, below) + 0.16 * std::max(below - 30, 0.0);
    return smooth_min(radius - std::sqrt(off.x * off.x + 1.6 * off.y * off.y), below, 7);
  }

  // Positive inside the side canyon, whose floor climbs to the north.
  double gully(glm::dvec3 p, double wander) const {
    const double along = std::max(0.0, -p.z - 10) / 110;
    const double floor = 4 + 70 * smooth_step(along * 0.9);
    const double half_width = 13 + 0.10 * std::max(0.0, p.y - floor);
    return smooth_min(half_width - from_gully_.at(p.x, p.z) - 0.6 * wander, p.y - floor, 8);
  }

  // A natural bridge over the inner gorge: a bar that sags towards its ends.
  static double bridge(glm::dvec3 p, double wander) {
    constexpr double kHalfLength = 42;
    const double along = (p.z - course(kBridgeX)) / kHalfLength;
    const glm::dvec2 off((p.x - kBridgeX - 8 * along) / 1.2, p.y - 52 + 10 * along * along);
    const double within = kHalfLength * (1 - std::abs(along));
    return std::min(13.5 - std::sqrt(off.x * off.x + off.y * off.y) + 0.25 * wander, within);
  }

  TabulatedPlane from_river_, from_gully_, swell_;
  std::array<TabulatedPlane, kTiers.size()> shift_;
};

}  // namespace

std::unique_ptr<SampleShape> make_canyon() {
  return std::make_unique<Canyon>();
}

}  // namespace karst::bake
