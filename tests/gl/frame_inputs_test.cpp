// SPDX-License-Identifier: MIT
// What the renderer computes on the CPU: the noise between materials, the uniform block.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/input/frame_block.h"
#include "renderer/resources/variation_texture.h"
#include "terrain/base/checksum.h"
#include "terrain/field/sky_visibility.h"
#include "terrain/view/projection.h"
#include "tests/gl/gl_fixture.h"
#include "tests/support/any_camera.h"

namespace karst::core {
namespace {

std::vector<std::uint8_t> variation_texture() {
  constexpr std::size_t kLayer = std::size_t{kVariationSide} * kVariationSide;
  std::vector<std::uint8_t> texels(kLayer * kVariationSide);
  for (int z = 0; z < kVariationSide; ++z)
    variation_layer(z, std::span(texels).subspan(static_cast<std::size_t>(z) * kLayer, kLayer));
  return texels;
}

TEST(Variation, IsNeutralOnAverageAndHasContrast) {
  double sum = 0;
  double squares = 0;
  const std::vector<std::uint8_t> texels = variation_texture();
  for (const std::uint8_t texel : texels) {
    const double value = (texel - 128.0) / 127.0;
    sum += value;
    squares += value * value;
  }
  const auto n = static_cast<double>(texels.size());
  EXPECT_NEAR(sum / n, 0.0, 0.03);
  EXPECT_NEAR(std::sqrt(squares / n), 0.38, 0.05);
}

// Simplex noise is smooth, lies within -1..1, repeats after its period and not before.
TEST(Variation, TilesAndIsSmooth) {
  test::Random random{7};
  int differs[3] = {};
  for (int n = 0; n < 20'000; ++n) {
    const auto place = [&] { return static_cast<float>(6 * random.unit()); };
    const glm::vec3 at(place(), place(), place());
    const float value = simplex_noise(at, 6);
    ASSERT_LE(std::fabs(value), 1.0f);
    for (int axis = 0; axis < 3; ++axis) {
      glm::vec3 other = at;
      other[axis] += 6.0f;
      ASSERT_NEAR(simplex_noise(other, 6), value, 3e-5f);
      other[axis] = at[axis] + 1e-3f;
      ASSERT_NEAR(simplex_noise(other, 6), value, 0.01f);
      other[axis] = at[axis] + 3.0f;
      differs[axis] += std::fabs(simplex_noise(other, 6) - value) > 0.05f;
    }
  }
  for (const int count : differs) EXPECT_GT(count, 10'000);
}

TEST(Variation, IsTheSameOnAllPlatforms) {
  const std::vector<std::uint8_t> texels = variation_texture();
  EXPECT_EQ(crc32c(std::as_bytes(std::span(texels))), 4284184494u);
}

TEST(FrameBlock, SunAndRaysFollowTheConventions) {
  Camera camera;
  CameraSettings settings;
  ASSERT_TRUE(make_camera(settings, camera).ok());
  FrameLight light;
  light.sun_azimuth_deg = 90;
  light.sun_elevation_deg = 0;
  shader::FrameBlock block = make_frame_block(camera, 0.25f, light, {{10, 20, 40}, 1}, 720);
  EXPECT_NEAR(block.sun_direction.x, 1, 1e-6) << "azimuth 90 is east";
  light.sun_azimuth_deg = 0;
  light.sun_elevation_deg = 30;
  block = make_frame_block(camera, 0.25f, light, {{10, 20, 40}, 1}, 720);
  EXPECT_NEAR(block.sun_direction.z, -std::sqrt(0.75), 1e-6) << "azimuth 0 is north";
  EXPECT_NEAR(block.sun_direction.y, 0.5, 1e-6);
  // Yaw 0 looks north.
  EXPECT_EQ(block.ray_forward, glm::vec4(0, 0, -1, 0));
  EXPECT_EQ(block.morph_view, glm::vec4(0, 0, -1, 0.25f));
  EXPECT_NEAR(block.ray_up.y, std::tan(3.14159265358979 / 6), 1e-6) << "half of 60 degrees";
  EXPECT_NEAR(block.ray_right.x / block.ray_up.y, 16.0 / 9, 1e-6);
  EXPECT_NEAR(block.view_scale.y * 360, std::tan(3.14159265358979 / 6), 1e-6)
      << "360 pixels are half the picture";
  EXPECT_EQ(block.sky_scale, glm::vec4(0.05f, 0.0125f, 0.025f, 2)) << "x, z, y";
}

// Where a picture's point is drawn, its ray leads; on screens that stand on their side as well.
TEST(FrameBlock, RaysOfAnyCameraLeadToWhatIsDrawnThere) {
  test::Random random{77};
  for (const test::AnyProjection kind : test::kAnyProjections) {
    for (int n = 0; n < 100; ++n) {
      const CameraMatrices matrices = test::any_matrices(random, kind, 0.1, 40);
      const Camera camera = test::camera_of(matrices);
      shader::FrameBlock block = make_frame_block(camera, 0.25f, {}, {}, 720);
      EXPECT_EQ(block.view_scale.z, camera.parallel ? 1.0f : 0.0f);
      const double upwards = vertical_scale(camera);
      EXPECT_NEAR(block.view_scale.y * 360 * upwards, 1, 1e-5) << "a pixel's size";
      turn_frame_block(block, n);
      const glm::vec3 forward(block.ray_forward);
      if (camera.parallel) {
        EXPECT_EQ(block.ray_right, glm::vec4(0));
        EXPECT_EQ(block.ray_up, glm::vec4(0));
        EXPECT_EQ(forward, glm::vec3(camera.forward));
        continue;
      }
      const glm::vec2 ndc(test::between(random, -1, 1), test::between(random, -1, 1));
      const glm::vec3 ray = forward + ndc.x * glm::vec3(block.ray_right) + ndc.y * glm::vec3(block.ray_up);
      const glm::vec4 clip =
          block.clip_from_lattice * glm::vec4(camera.fine + ray * (10.0f * kStepsPerVoxel), 1.0f);
      EXPECT_NEAR(clip.w, 10, 1e-2);
      EXPECT_NEAR(clip.x / clip.w, ndc.x, 1e-3);
      EXPECT_NEAR(clip.y / clip.w, ndc.y, 1e-3);
    }
  }
}

TEST(FrameLight, NamesTheFieldThatIsWrong) {
  EXPECT_TRUE(FrameLight().validate().ok());
  const double bad[] = {NAN, INFINITY, 361, -1e9};
  for (const double value : bad) {
    FrameLight light;
    light.sun_azimuth_deg = value;
    EXPECT_STREQ(light.validate().field(), "sun_azimuth_deg");
    light = {};
    light.sun_elevation_deg = value;
    EXPECT_STREQ(light.validate().field(), "sun_elevation_deg");
    light = {};
    light.haze_voxels = value == 361 ? 0 : value;
    EXPECT_STREQ(light.validate().field(), "haze_voxels");
  }
}

}  // namespace
}  // namespace karst::core
