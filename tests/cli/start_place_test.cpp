// SPDX-License-Identifier: MIT
// Where karst view begins when nobody says.
#include "app/view/start_place.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "karst/karst.h"
#include "tests/support/process.h"
#include "tests/support/test_world.h"

namespace karst::app {
namespace {

constexpr int kSide = 129;
constexpr double kSpacing_m = 30;
constexpr double kEye_m = 1.7;

using Heights = std::function<double(double east_m, double south_m)>;  // from the middle
using Words = std::vector<std::string>;

class StartPlace : public ::testing::Test {
 protected:
  // Begins in a world of these heights.
  void begin(const Heights& heights, const Words& more) {
    std::string samples;
    for (int k = 0; k < kSide; ++k) {
      for (int i = 0; i < kSide; ++i) {
        const int middle = kSide / 2;
        const auto height = static_cast<std::int16_t>(
            std::lround(heights((i - middle) * kSpacing_m, (k - middle) * kSpacing_m)));
        samples.push_back(static_cast<char>(height & 0xff));
        samples.push_back(static_cast<char>(height >> 8 & 0xff));
      }
    }
    const std::string side = std::to_string(kSide);
    folder_.write("dem.hdr", "NROWS " + side + "\nNCOLS " + side +
                                 "\nNBITS 16\nPIXELTYPE SIGNEDINT\nBYTEORDER I\nLAYOUT BIL\n");
    const std::string world = folder_.path("world.karst");
    Words words{folder_.write("dem.bil", samples), "-o", world, "--materials", "none", "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    const test::ProcessResult baked = test::run_process(KARST_BAKE_PATH, words);
    ASSERT_EQ(baked.code, 0) << baked.err;
    std::string bytes = test::read_text(world);
    const Source file{bytes.size(),
                      [](void* user, std::uint64_t offset, std::byte* out, std::size_t count) {
                        std::memcpy(out, static_cast<std::string*>(user)->data() + offset, count);
                        return true;
                      },
                      &bytes};
    Plan plan;
    plan.needs.queries = 1;
    plan.placement.axes = Axes::east_up_south;
    ASSERT_TRUE(make_plan(file, plan).ok());
    const test::AlignedBytes memory(plan.cpu_bytes);
    World* loaded = nullptr;
    ASSERT_TRUE(World::create(plan, file, memory.bytes(), loaded).ok());
    look(*loaded);
    loaded->destroy();
  }

  void look(World& world) {
    CameraGround ground;
    ASSERT_EQ(ground.open(world).text(), "");
    has_place_ = start_place(ground, world, kEye_m, place_);
    if (!has_place_) return;
    Hit hit;
    ASSERT_TRUE(ground.top(place_.position_m, true, hit));
    above_ground_m_ = place_.position_m.y - hit.place.y;
  }

  test::Folder folder_;
  bool has_place_ = false;
  CameraPlace place_;
  double above_ground_m_ = 0;
};

// Level, and a mountain in the north-west: of a ground, and of voxels.
TEST_F(StartPlace, InTheMiddleTowardsTheMountain) {
  const Heights heights = [](double east, double south) {
    return 100 + 500 * std::exp(-(std::pow(east + 1200, 2) + std::pow(south + 1200, 2)) / (2 * 300 * 300.0));
  };
  for (const Words& words : {Words{"--pixel-size", "30"}, Words{"--pixel-size", "30", "--voxel", "60"}}) {
    begin(heights, words);
    ASSERT_TRUE(has_place_);
    EXPECT_NEAR(above_ground_m_, kEye_m, 1e-3);
    EXPECT_NEAR(place_.position_m.x, 0, 1);
    EXPECT_NEAR(place_.position_m.z, 0, 1);
    EXPECT_NEAR(place_.yaw_deg, 45, 8);
    EXPECT_GT(place_.pitch_deg, 3);
    EXPECT_LT(place_.pitch_deg, 20);
  }
}

// A lake lies in the middle: the nearest ring around it that is dry.
TEST_F(StartPlace, OnDryLand) {
  const Heights heights = [](double east, double south) { return std::hypot(east, south) < 350 ? -20 : 30; };
  begin(heights, {"--pixel-size", "30", "--water", "0"});
  ASSERT_TRUE(has_place_);
  EXPECT_NEAR(above_ground_m_, kEye_m, 1e-3);
  EXPECT_NEAR(place_.position_m.y, 30 + kEye_m, 0.1);
  EXPECT_LT(std::hypot(place_.position_m.x, place_.position_m.z), 0.18 * kSide * kSpacing_m);
}

TEST_F(StartPlace, OverTheSeaWhereThereIsNoLand) {
  begin([](double east, double south) { return std::hypot(east, south) < 1200 ? -20 - east / 100 : 30; },
        {"--pixel-size", "30", "--water", "0"});
  ASSERT_TRUE(has_place_);
  EXPECT_NEAR(place_.position_m.y, kEye_m, 1e-6);
}

// Where the middle is a cliff: beside it, and not towards the wall at arm's length.
TEST_F(StartPlace, NotOnAFaceNorBeforeIt) {
  const Heights heights = [](double east, double) { return 100 + 10 * std::clamp(east, -30.0, 60.0); };
  begin(heights, {"--pixel-size", "30"});
  ASSERT_TRUE(has_place_);
  EXPECT_GT(std::abs(place_.position_m.x), 30);
  EXPECT_NEAR(above_ground_m_, kEye_m, 1e-3);
}

TEST_F(StartPlace, NotOnAPlanet) {
  begin([](double, double) { return 0; },
        {"--basis", "cube", "--crs", "EPSG:4326", "--bounds", "-180,-90,180,90"});
  EXPECT_FALSE(has_place_);
}

}  // namespace
}  // namespace karst::app
