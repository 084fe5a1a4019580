// SPDX-License-Identifier: MIT
// What the renderer computes on the CPU: the noise texture, the sky-line, the uniform block.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "renderer/frame_block.h"
#include "renderer/noise_texture.h"
#include "renderer/sky_line.h"
#include "terrain/base/checksum.h"
#include "tests/gl/gl_fixture.h"

namespace karst {
namespace {

std::vector<std::uint8_t> noise_texture() {
  std::vector<std::uint8_t> texels(kNoiseSide * kNoiseSide * 4);
  NoiseRows rows;
  for (std::size_t t = 0; t < kNoiseSide; ++t)
    rows.next(std::span(texels).subspan(t * kNoiseSide * 4, kNoiseSide * 4));
  return texels;
}

TEST(NoiseTexture, IsNeutralOnAverageAndHasContrast) {
  const std::vector<std::uint8_t> texels = noise_texture();
  for (std::size_t channel = 0; channel < 4; ++channel) {
    double sum = 0;
    double squares = 0;
    for (std::size_t i = channel; i < texels.size(); i += 4) {
      const double value = (texels[i] - 128.0) / 127.0;
      sum += value;
      squares += value * value;
    }
    const double n = kNoiseSide * kNoiseSide;
    EXPECT_NEAR(sum / n, 0.0, 0.01) << channel;
    EXPECT_NEAR(std::sqrt(squares / n), 0.35, 0.05) << channel;
  }
}

TEST(NoiseTexture, Tiles) {
  const std::vector<std::uint8_t> texels = noise_texture();
  const auto at = [&](int s, int t, std::size_t channel) {
    return static_cast<int>(
        texels[static_cast<std::size_t>((t & 255) * kNoiseSide + (s & 255)) * 4 + channel]);
  };
  // The step across the border is no larger than the largest step inside.
  for (std::size_t channel = 0; channel < 2; ++channel) {
    int inside = 0;
    int across = 0;
    for (int t = 0; t < kNoiseSide; ++t) {
      for (int s = 1; s < kNoiseSide; ++s) {
        inside = std::max({inside, std::abs(at(s, t, channel) - at(s - 1, t, channel)),
                           std::abs(at(t, s, channel) - at(t, s - 1, channel))});
      }
      across = std::max({across, std::abs(at(0, t, channel) - at(-1, t, channel)),
                         std::abs(at(t, 0, channel) - at(t, -1, channel))});
    }
    EXPECT_LE(across, inside);
  }
}

TEST(NoiseTexture, IsTheSameOnAllPlatforms) {
  const std::vector<std::uint8_t> texels = noise_texture();
  EXPECT_EQ(crc32c(std::as_bytes(std::span(texels))), 4240403726u);
}

// Against every column of the world at once.
TEST(SkyLine, IsTheLeastOfTopsAndDistances) {
  const test::TestWorld world = test::hills_with_cave(1);
  const glm::ivec3 extent = world.extent();
  const auto top = [&](int x, int z) {
    int y = extent.y;
    while (y > 0 && !world.octree().filled({x, y - 1, z})) --y;
    return y;
  };
  std::vector<float> row(static_cast<std::size_t>(extent.x));
  SkyLine rows(world.octree(), extent);
  for (int z = 0; z < extent.z; ++z) {
    rows.next(row);
    for (int x = 0; x < extent.x; ++x) {
      float least = 1e9f;
      for (int other_z = 0; other_z < extent.z; ++other_z) {
        for (int other_x = 0; other_x < extent.x; ++other_x) {
          if (std::max(std::abs(other_x - x), std::abs(other_z - z)) > kSkyReach) continue;
          const auto distance = static_cast<float>(std::hypot(other_x - x, other_z - z));
          least = std::min(least, static_cast<float>(top(other_x, other_z)) + kSkySlope * distance);
        }
      }
      ASSERT_NEAR(row[static_cast<std::size_t>(x)], least, 1e-5) << x << ' ' << z;
    }
  }
}

TEST(FrameBlock, SunAndRaysFollowTheConventions) {
  Camera camera;
  CameraSettings settings;
  ASSERT_TRUE(make_camera(settings, camera).ok());
  FrameLight light;
  light.sun_azimuth_deg = 90;
  light.sun_elevation_deg = 0;
  shader::FrameBlock block = make_frame_block(camera, 0.25f, light, {10, 20, 40}, 720);
  EXPECT_NEAR(block.sun_direction.x, 1, 1e-6) << "azimuth 90 is east";
  light.sun_azimuth_deg = 0;
  light.sun_elevation_deg = 30;
  block = make_frame_block(camera, 0.25f, light, {10, 20, 40}, 720);
  EXPECT_NEAR(block.sun_direction.z, -std::sqrt(0.75), 1e-6) << "azimuth 0 is north";
  EXPECT_NEAR(block.sun_direction.y, 0.5, 1e-6);
  // Yaw 0 looks north.
  EXPECT_EQ(block.ray_forward, glm::vec4(0, 0, -1, 0));
  EXPECT_EQ(block.morph_view, glm::vec4(0, 0, -1, 0.25f));
  EXPECT_NEAR(block.ray_up.y, std::tan(3.14159265358979 / 6), 1e-6) << "half of 60 degrees";
  EXPECT_NEAR(block.ray_right.x / block.ray_up.y, 16.0 / 9, 1e-6);
  EXPECT_NEAR(block.view_scale.y * 360, std::tan(3.14159265358979 / 6), 1e-6)
      << "360 pixels are half the picture";
  EXPECT_EQ(block.sky_line_scale.x, 0.1f);
  EXPECT_EQ(block.sky_line_scale.y, 0.025f);
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
}  // namespace karst
