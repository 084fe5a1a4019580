// SPDX-License-Identifier: MIT
// `hills`: rolling hills, a plain height field.
#include "bake/samples/sample_solid.h"

#include <algorithm>

namespace karst::bake {
namespace {

constexpr double kHalf = 252;  // metres; 63 x 63 voxels

class Hills final : public SampleShape {
 public:
  Hills() {
    content_m = {{-kHalf, 8, -kHalf}, {kHalf, 112, kHalf}};
    grain = {0.5, 9, 4, 0, -1e9, 6};
    land = {30, 1500, 3400};
    height_ = TabulatedPlane({-kHalf - 20, -kHalf - 20}, {kHalf + 20, kHalf + 20}, 2, ground);
  }
  double value_m(glm::dvec3 p) const override { return height_.at(p.x, p.z) - p.y; }
  double ground_m(double x, double z) const override { return ground(x, z); }
  // Mountains in a wide ring.
  double far_m(double x, double z, double away_m) const override {
    const double stands = smooth_step((away_m - 700) / 1600);
    return stands > 0 ? 420 * stands * mountains(x, z, 1700, 36) : 0;
  }

 private:
  // Ridges wander through broad swells: noise whose place is itself moved by noise.
  static double ground(double x, double z) {
    const glm::dvec2 p(x, z);
    const glm::dvec2 moved = p + 34.0 * glm::dvec2(fbm(p / 150.0, 2, 31), fbm(p / 150.0, 2, 32));
    const double swell = fbm(moved / 230.0, 3, 33);
    const double n = noise(moved / 105.0, 34);
    const double ridge = 1 - std::sqrt(n * n + 0.012);
    const double rough = fbm(p / 60.0, 3, 35);
    return 52 + 30 * swell + 26 * ridge * ridge * smooth_step(0.55 + swell) + 4.5 * rough;
  }

  TabulatedPlane height_;
};

}  // namespace

std::unique_ptr<SampleShape> make_hills() {
  return std::make_unique<Hills>();
}

}  // namespace karst::bake
