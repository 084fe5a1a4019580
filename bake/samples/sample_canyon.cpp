// SPDX-License-Identifier: MIT
// `canyon`: a river has cut three tiers of rock. Its size is that of K's test scene (chapter 5: 24,000 filled
// voxels, 3,560 patches), so that K's tables can be set beside ours.
//
// Each tier is what lies further from the river than the tier's edge and lower than its top; hard caps
// overhang the soft rock below them. A side canyon, alcoves and a window are taken away, a natural bridge and
// a butte are added.
#include "bake/samples/sample_solid.h"

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

 private:
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
