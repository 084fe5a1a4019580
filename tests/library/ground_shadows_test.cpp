// SPDX-License-Identifier: MIT
// Ground whose slopes are less steep than the sun is high shades nothing, whatever levels cast.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/library/ground_file.h"
#include "tests/library/host.h"

namespace karst {
namespace {

using test::Pixels;

constexpr int kWidth = 320;
constexpr int kHeight = 120;
constexpr int kSide = 769;  // samples, 2 m apart
constexpr double kSpacing_m = 2;
constexpr double kUnit_m = kSpacing_m / 1024;  // of a height
constexpr int kPictures = 16;

// Hills of all sizes, 21 degrees steep at most, where the sun is 32 high.
double height_m(double x, double z) {
  double height = 0, length = 700;
  for (int n = 0; n < 5; ++n, length *= 0.41) {
    const double turn = 0.7 + 1.9 * n;
    const double along = (x * std::cos(turn) + z * std::sin(turn)) / length;
    height += 0.012 * length * std::sin(6.2832 * along + n);
  }
  return height;
}

class GroundShadows : public test::HostTest {
 protected:
  GroundShadows() : HostTest(kWidth, kHeight) {}

  static const std::vector<std::byte>& file() {
    static const std::vector<std::byte> bytes = test::ground_file(
        test::MemoryGround(kSide, kSide, core::kMostSampleSteps, core::kMostSampleSteps,
                           [](std::int64_t i, std::int64_t k) {
                             return static_cast<std::int32_t>(std::lround(
                                 height_m(kSpacing_m * double(i), kSpacing_m * double(k)) / kUnit_m));
                           }),
        kSpacing_m);
    return bytes;
  }

  // Pictures from random places, all of what lacks made first.
  std::vector<Pixels> pictures(std::uint32_t shadow_maps, std::uint64_t vertex_bytes, double error_px) {
    Needs needs;
    needs.shadow_maps = shadow_maps;
    needs.vertex_bytes = vertex_bytes;
    open(needs, {}, {}, file());
    std::mt19937 random(5);
    const auto between = [&](double a, double b) {
      return std::uniform_real_distribution<double>(a, b)(random);
    };
    std::vector<Pixels> all;
    for (int n = 0; n < kPictures; ++n) {
      const double x = between(300, 1200), z = between(300, 1200), turn = between(0, 6.28);
      const Vec3 eye{x, height_m(x, z) + std::exp2(between(2, 6)), z};
      ViewState shown =
          test::looking(*host_->world, eye, {eye.x + std::cos(turn), eye.y - 0.15, eye.z + std::sin(turn)},
                        kWidth, kHeight);
      shown.error_px = error_px;
      result_ = test::draw_frame(*renderer_, picture_, {shown});
      limits_ |= result_.limits;
      most_px_ = std::max(most_px_, result_.error_px[0]);
      all.push_back(picture_.read());
    }
    return all;
  }

  // Pixels that shadow maps make darker.
  int darker(std::uint64_t vertex_bytes, double error_px) {
    const std::vector<Pixels> without = pictures(0, vertex_bytes, error_px);
    const std::vector<Pixels> with = pictures(2, vertex_bytes, error_px);
    int count = 0;
    for (std::size_t n = 0; n < with.size(); ++n) {
      int here = 0;
      for (std::size_t at = 1; at < with[n].rgba.size(); at += 4)
        here += with[n].rgba[at] + 24 < without[n].rgba[at] ? 1 : 0;
      if (here > 0) std::printf("picture %zu: %d pixels\n", n, here);
      count += here;
    }
    return count;
  }

  FrameResult result_;
  double most_px_ = 0;  // of all pictures
  std::uint32_t limits_ = 0;
};

TEST_F(GroundShadows, ThereAreNoneWhereLevelsDiffer) {
  EXPECT_EQ(darker(0, 4), 0);
  EXPECT_EQ(darker(0, 16), 0);
}

// Errors grow until views and casters find room together. Casters that had to be coarser still may darken a
// few of the million pixels.
TEST_F(GroundShadows, ThereAreNoneWhereMemoryIsShort) {
  constexpr std::uint64_t kShort = 512u << 10;
  EXPECT_LT(darker(kShort, 0.5), 10);
  EXPECT_NE(limits_ & kLimitVertexMemory, 0u);
  EXPECT_GT(most_px_, 0.5);
  EXPECT_LT(most_px_, 16);
  const std::vector<Pixels> once = pictures(2, kShort, 0.5), again = pictures(2, kShort, 0.5);
  for (std::size_t n = 0; n < once.size(); ++n) EXPECT_TRUE(once[n].rgba == again[n].rgba) << n;
}

}  // namespace
}  // namespace karst
