// SPDX-License-Identifier: MIT
// What the renderer computes on the CPU: the noise between materials, the uniform block.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

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
  shader::FrameBlock block = make_frame_block(camera, 0.25f, light, SkyGrid{{10, 20, 40}, 1}, 720);
  EXPECT_NEAR(block.sun_direction.x, 1, 1e-6) << "azimuth 90 is east";
  light.sun_azimuth_deg = 0;
  light.sun_elevation_deg = 30;
  block = make_frame_block(camera, 0.25f, light, SkyGrid{{10, 20, 40}, 1}, 720);
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

shader::FrameBlock block_at(double elevation_deg) {
  Camera camera;
  EXPECT_TRUE(make_camera(CameraSettings(), camera).ok());
  FrameLight light;
  light.sun_azimuth_deg = 120;
  light.sun_elevation_deg = elevation_deg;
  return make_frame_block(camera, 0.25f, light, SkyGrid{{10, 10, 10}, 1}, 720);
}

// As light.glsl has it, without shadows.
glm::vec3 light_on(const shader::FrameBlock& block, glm::vec3 normal) {
  const float facing = glm::dot(normal, glm::vec3(block.sun_direction));
  const auto grazes = static_cast<float>(KARST_SUN_GRAZES);
  const auto shines = static_cast<float>(KARST_SUN_SHINES);
  const float t = std::clamp((facing - grazes) / (shines - grazes), 0.0f, 1.0f);
  const float sun = std::max(facing, 0.0f) * t * t * (3 - 2 * t);
  const float up = 0.5f + 0.5f * normal.y;
  const glm::vec3 sky = glm::vec3(block.ground_light) * (1 - up) + glm::vec3(block.sky_light) * up;
  return glm::vec3(block.sun_light) * sun + sky * (0.8f + block.sun_direction.w * facing);
}

TEST(FrameLight, NothingJumpsFromNoonToMidnight) {
  const glm::vec3 normals[] = {{0, 1, 0}, {0.8f, 0.6f, 0}, {-0.8f, 0.6f, 0}, {0, 0, -1}, {0, -1, 0}};
  constexpr double kStep = 0.02;  // degrees
  for (double elevation = -90; elevation + kStep <= 90; elevation += kStep) {
    const shader::FrameBlock a = block_at(elevation);
    const shader::FrameBlock b = block_at(elevation + kStep);
    // The sun's own light goes within three degrees, by a third of it in one.
    const auto near = [&](glm::vec3 x, glm::vec3 y) { return glm::length(x - y) <= 1.5 * kStep; };
    for (const glm::vec3 normal : normals) {
      ASSERT_TRUE(near(light_on(a, normal), light_on(b, normal))) << elevation << ' ' << normal.x;
    }
    ASSERT_TRUE(near(glm::vec3(a.sky_zenith), glm::vec3(b.sky_zenith))) << elevation;
    ASSERT_TRUE(near(glm::vec3(a.sky_horizon), glm::vec3(b.sky_horizon))) << elevation;
  }
}

TEST(FrameLight, ANightIsLitFromOneSideAndHasStars) {
  for (const double elevation : {-14.0, -35.0, -60.0}) {
    const shader::FrameBlock night = block_at(elevation);
    const glm::vec3 moon(night.sun_direction);
    EXPECT_NEAR(moon.y, std::sin(-elevation * 3.14159265358979 / 180), 1e-6) << "full, opposite to the sun";
    EXPECT_GT(light_on(night, moon).g, 3 * light_on(night, -moon).g);
    // A white surface that faces it is shown neither black nor as by day.
    const glm::vec3 shown = encode_picture(0.3f * light_on(night, moon));
    EXPECT_GT(shown.g, 0.2f);
    EXPECT_LT(shown.g, 0.5f);
    EXPECT_EQ(night.sky_zenith.w, 1);
  }
  const shader::FrameBlock day = block_at(20);
  EXPECT_EQ(day.sky_zenith.w, 0);
  EXPECT_EQ(day.sun_direction.w, 0.4f);
  EXPECT_GT(day.sun_direction.y, 0);
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
