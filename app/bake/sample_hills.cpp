// SPDX-License-Identifier: MIT
// `hills`: rolling hills, a plain height field.
#include "app/bake/sample_solid.h"

#include <algorithm>

namespace karst::bake {
namespace {

constexpr double kHalf = 252;  // metres; 63 x 63 voxels

class Hills final : public Solid {
 public:
  Hills() { height_ = TabulatedPlane({-kHalf - 20, -kHalf - 20}, {kHalf + 20, kHalf + 20}, 2, ground); }
  double value_m(glm::dvec3 p) const override { return grain_.apply(height_.at(p.x, p.z) - p.y, p); }

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
  Grain grain_{0.5, 9, 0, 0, 6};
};

}  // namespace

Sample make_hills() {
  Sample sample;
  sample.solid = std::make_unique<Hills>();
  sample.content_m = {{-kHalf, 8, -kHalf}, {kHalf, 112, kHalf}};
  return sample;
}

}  // namespace karst::bake
