// SPDX-License-Identifier: MIT
// Depth over a range of a million: as an eye at a person's height over a world of 100 km has it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/library/host.h"
#include "tests/support/hilly_world.h"

namespace karst {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 180;
constexpr double kNearOfFar = 1e-6;  // 0.1 m of 100 km
constexpr double kPlainNear = 0.2;   // m; less than the way to anything that the views see
constexpr int kViews = 16;

// Views along the ground from one side to another, ridge behind ridge.
ViewState along_the_ground(const World& world, int n) {
  const WorldInfo& info = world.info();
  const Vec3 middle{(info.low_m.x + info.high_m.x) / 2, 0, (info.low_m.z + info.high_m.z) / 2};
  const double angle = n * (6.283185307179586 / kViews);
  const double radius = 0.45 * (info.high_m.x - info.low_m.x);
  const Vec3 eye{middle.x + radius * std::cos(angle), info.high_m.y + 0.5,
                 middle.z + radius * std::sin(angle)};
  return test::looking(world, eye, {middle.x, info.high_m.y - 2, middle.z}, kWidth, kHeight);
}

// Just beyond the world's farthest corner on the ground.
double far_of(const World& world, const ViewState& view) {
  const WorldInfo& info = world.info();
  double farthest = 0;
  for (const double x : {info.low_m.x, info.high_m.x}) {
    for (const double z : {info.low_m.z, info.high_m.z}) {
      farthest = std::max(farthest, std::hypot(x - view.eye.x, z - view.eye.z));
    }
  }
  return 1.01 * farthest;
}

class Depth : public testing::Test {
 protected:
  test::Pixels shot(const test::HostPicture& picture, Renderer& renderer, int n, double near_m, double far_m,
                    bool reversed) const {
    ViewState view = along_the_ground(*host_.world, n);
    view.reversed_depth = reversed;
    set_perspective(view, 60, near_m, far_m);
    Target target;
    target.viewport = {0, 0, kWidth, kHeight};
    target.depth_zero_to_one = reversed;
    test::draw_frame(renderer, picture, {view}, 0, &target);
    return picture.read();
  }
  // Pixels of all views that show another surface than with a near plane further away.
  std::size_t order_errors(GLenum format, bool reversed, double near_of_far) {
    test::HostPicture picture(kWidth, kHeight, format);
    Renderer* renderer = nullptr;
    EXPECT_TRUE(Renderer::create(*host_.world, picture.loader(), {}, renderer).ok());
    if (renderer == nullptr) return 0;
    double errors = 0;
    for (int n = 0; n < kViews; ++n) {
      const double far_m = far_of(*host_.world, along_the_ground(*host_.world, n));
      const test::Pixels plain = shot(picture, *renderer, n, kPlainNear, far_m, false);
      errors +=
          test::share_beyond(plain, shot(picture, *renderer, n, near_of_far * far_m, far_m, reversed), 0);
    }
    renderer->destroy();
    return static_cast<std::size_t>(errors * kWidth * kHeight + 0.5);
  }

  test::HostWorld host_{{}, {}, test::wide_world().file()};
};

TEST_F(Depth, ReversedFloatsHaveNoOrderErrors) {
  for (const double part : {1.0, 0.1}) {
    EXPECT_EQ(order_errors(GL_DEPTH_COMPONENT32F, true, part * kNearOfFar), 0u) << part;
  }
}

// Why docs/library.md names a format.
TEST_F(Depth, WholeNumbersHave) {
  const std::size_t errors = order_errors(GL_DEPTH_COMPONENT24, false, kNearOfFar);
  EXPECT_GT(errors, 0u);
  std::printf("%zu of %d pixels\n", errors, kViews * kWidth * kHeight);
}

}  // namespace
}  // namespace karst
