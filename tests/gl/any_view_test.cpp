// SPDX-License-Identifier: MIT
// Pictures through cameras of any rotation and projection: what a roll, a mirror, reversed depth, an axis off
// the centre and parallel rays change of a picture, and what they leave.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>

#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>

#include "tests/gl/gl_fixture.h"

namespace karst::core {
namespace {

using test::DrawnSettings;
using test::DrawnWorld;
using test::GlContext;
using test::Picture;

constexpr int kWidth = 160;
constexpr int kHeight = 90;

DrawnSettings settings_of(int width) {
  DrawnSettings settings;
  settings.picture.width = width;
  settings.picture.height = kHeight;
  settings.picture.keep_depth = true;
  settings.debug = true;
  return settings;
}

CameraMatrices matrices_of(const CameraSettings& settings) {
  Camera camera;
  EXPECT_TRUE(make_camera(settings, camera).ok());
  return {settings.position, camera.view_from_world, camera.clip_from_view, settings.reversed_depth};
}

CameraSettings over_the_hills() {
  CameraSettings settings;
  settings.position = {11, 15, 22};
  settings.yaw_deg = 10;
  settings.pitch_deg = -30;
  return settings;
}

Picture drawn(DrawnWorld& world, const CameraMatrices& matrices) {
  Camera camera;
  const Status made = make_camera(matrices, camera);
  EXPECT_TRUE(made.ok()) << made.field() << ": " << made.what();
  FrameCounts counts;
  EXPECT_TRUE(world.draw(camera, &counts).ok());
  EXPECT_GT(counts.triangles, 100u);
  Picture picture = world.picture();
  EXPECT_EQ(world.target().take_error(), GLenum{GL_NO_ERROR});
  return picture;
}

// Where a pixel of one picture is in the other.
using Place = std::function<glm::ivec2(glm::ivec2)>;

// The share of a's pixels that look the same at their place in b: but for dither, and edges that cross a
// pixel's centre.
double alike(const Picture& a, int a_width, const Picture& b, int b_width, const Place& place) {
  int same = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < a_width; ++x) {
      const glm::ivec2 there = place({x, y});
      const std::uint8_t* const p = a.data() + static_cast<std::size_t>(y * a_width + x) * 4;
      const std::uint8_t* const q = b.data() + static_cast<std::size_t>(there.y * b_width + there.x) * 4;
      int most = 0;
      for (int c = 0; c < 3; ++c) most = std::max(most, std::abs(p[c] - q[c]));
      same += most <= 2 ? 1 : 0;
    }
  }
  return static_cast<double>(same) / (a_width * kHeight);
}

glm::ivec2 stays(glm::ivec2 p) {
  return p;
}
glm::ivec2 flips(glm::ivec2 p) {
  return {kWidth - 1 - p.x, p.y};
}

class AnyView : public testing::Test {
 protected:
  AnyView() { world_.lod.mode = LodMode::full; }

  DrawnWorld world_{test::hills_with_cave(3), GlContext::get().gl(), settings_of(kWidth)};
};

TEST_F(AnyView, AMirrorFlipsThePicture) {
  const CameraMatrices plain = matrices_of(over_the_hills());
  const Picture picture = drawn(world_, plain);
  EXPECT_LT(alike(picture, kWidth, picture, kWidth, flips), 0.5) << "the picture is its own mirror image";
  CameraMatrices by_projection = plain;
  by_projection.clip_from_view[0][0] *= -1.0;
  EXPECT_GT(alike(picture, kWidth, drawn(world_, by_projection), kWidth, flips), 0.995);
  CameraMatrices by_rotation = plain;
  by_rotation.view_from_world =
      glm::transpose(glm::dmat3(-1, 0, 0, 0, 1, 0, 0, 0, 1)) * by_rotation.view_from_world;
  EXPECT_GT(alike(picture, kWidth, drawn(world_, by_rotation), kWidth, flips), 0.995);
  by_rotation.clip_from_view[0][0] *= -1.0;
  EXPECT_GT(alike(picture, kWidth, drawn(world_, by_rotation), kWidth, stays), 0.995) << "mirrored twice";
}

TEST_F(AnyView, HalfARollTurnsThePicture) {
  CameraSettings settings = over_the_hills();
  const Picture picture = drawn(world_, matrices_of(settings));
  settings.roll_deg = 180;
  const auto turned = [](glm::ivec2 p) { return glm::ivec2(kWidth - 1 - p.x, kHeight - 1 - p.y); };
  EXPECT_GT(alike(picture, kWidth, drawn(world_, matrices_of(settings)), kWidth, turned), 0.995);
}

TEST_F(AnyView, ReversedDepthShowsTheSame) {
  CameraSettings settings = over_the_hills();
  const Picture picture = drawn(world_, matrices_of(settings));
  settings.reversed_depth = true;
  EXPECT_GT(alike(picture, kWidth, drawn(world_, matrices_of(settings)), kWidth, stays), 0.995);
}

// Half of a picture by a projection whose axis is at its side: as displays beside one another show it.
TEST_F(AnyView, AnAxisAtTheSideShowsHalfThePicture) {
  const CameraMatrices whole = matrices_of(over_the_hills());
  const Picture picture = drawn(world_, whole);
  DrawnWorld half_world(test::hills_with_cave(3), GlContext::get().gl(), settings_of(kWidth / 2));
  half_world.lod.mode = LodMode::full;
  for (const bool right : {false, true}) {
    CameraMatrices half = whole;
    // x goes to 2 x -+ w.
    glm::dmat4 widened(1.0);
    widened[0][0] = 2.0;
    widened[3][0] = right ? -1.0 : 1.0;
    half.clip_from_view = widened * whole.clip_from_view;
    const int first = right ? kWidth / 2 : 0;
    EXPECT_GT(alike(drawn(half_world, half), kWidth / 2, picture, kWidth,
                    [&](glm::ivec2 p) { return glm::ivec2(p.x + first, p.y); }),
              0.99);
  }
}

CameraMatrices parallel(const CameraSettings& settings, double height, double moved) {
  CameraMatrices m = matrices_of(settings);
  const double width = height * kWidth / kHeight;
  m.clip_from_view = glm::dmat4(2 / width, 0, 0, 0, 0, 2 / height, 0, 0, 0, 0, -0.02, 0, 0, 0, 0, 1);
  // The eye beside the picture's middle.
  const glm::dvec3 right = glm::transpose(m.view_from_world)[0];
  m.position += right * moved;
  m.clip_from_view[3][0] = 2 / width * moved;
  return m;
}

// All rays go one way and haze follows depth: it does not matter where the eye lies beside the picture.
TEST_F(AnyView, AParallelPictureDoesNotDependOnTheEyesPlaceBesideIt) {
  world_.light.haze_voxels = 30;
  const Picture middle = drawn(world_, parallel(over_the_hills(), 16, 0));
  EXPECT_LT(alike(middle, kWidth, middle, kWidth, flips), 0.8);
  for (const double moved : {-40.0, 40.0, 200.0}) {
    EXPECT_GT(alike(middle, kWidth, drawn(world_, parallel(over_the_hills(), 16, moved)), kWidth, stays),
              0.99);
  }
  // With a bound of error as well: apparent distance is the same everywhere.
  world_.lod.mode = LodMode::error;
  world_.lod.error_px = 2;
  const Picture coarse = drawn(world_, parallel(over_the_hills(), 16, 0));
  EXPECT_GT(alike(coarse, kWidth, drawn(world_, parallel(over_the_hills(), 16, 40)), kWidth, stays), 0.99);
}

TEST(ParallelView, DrawsToScale) {
  DrawnWorld world(test::level_ground(5, 2), GlContext::get().gl(), settings_of(kWidth));
  CameraSettings level;
  level.position = {12, 7, 17};
  level.pitch_deg = -30;
  drawn(world, parallel(level, 9, 0));
  std::vector<float> depth(kWidth * kHeight);
  ASSERT_TRUE(world.target().read_depth(depth).ok());
  for (int y = 0; y < kHeight; ++y) {
    // 9 voxels in 90 rows, at 30 degrees to the ground, which is 2 voxels below the eye.
    const double up = 4.5 - 0.1 * (y + 0.5);
    const double away = 2 * (2 + up * std::sqrt(0.75));
    if (away > 12) continue;  // beyond the world's end
    EXPECT_NEAR(depth[static_cast<std::size_t>(y * kWidth + kWidth / 2)], 0.5 + 0.01 * away, 2e-5) << y;
  }
  // From above all is at one depth, 4 of -50..50 voxels.
  level.position = {12, 9, 12};
  level.pitch_deg = -90;
  drawn(world, parallel(level, 9, 0));
  ASSERT_TRUE(world.target().read_depth(depth).ok());
  for (const float value : depth) ASSERT_NEAR(value, 0.54f, 1e-5);
}

}  // namespace
}  // namespace karst::core
