// SPDX-License-Identifier: MIT
// Shadows of the four samples against rays cast on the CPU. They are baked here at level 3, or at
// KARST_SHADOW_LEVEL.
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/gl/shadow_rays.h"
#include "tests/support/elsewhere.h"

namespace karst::core {
namespace {

using test::ShadowedWorld;
using test::Tally;
using test::Triangles;

CameraSettings camera_at(glm::dvec3 eye, double yaw_deg, double pitch_deg) {
  CameraSettings camera;
  camera.position = eye;
  camera.yaw_deg = yaw_deg;
  camera.pitch_deg = pitch_deg;
  return camera;
}

// Two from above, one on the ground, and one between a roof and the ground below it where there is one.
std::vector<CameraSettings> cameras_of(const World& world, const Triangles& triangles) {
  const double unit = kStepsPerVoxel;
  const glm::dvec3 low = glm::dvec3(world.box().min) / unit;
  const glm::dvec3 size = glm::dvec3(world.box().max) / unit - low;
  const auto at = [&](double x, double y, double z) { return low + size * glm::dvec3(x, y, z); };
  std::vector<CameraSettings> cameras = {camera_at(at(0.5, 1.15, 0.98), 0, -35),
                                         camera_at(at(0.15, 0.95, 0.2), -130, -25)};
  const glm::dvec3 down(1e-9, -1, 1e-9);
  const glm::dvec3 above = at(0.45, 1.01, 0.55);
  cameras.push_back(camera_at(above + down * (triangles.first_hit(above, down, 0) - 1.5), 60, -8));
  for (int n = 0; n < 400; ++n) {
    const glm::dvec3 top = at(0.1 + 0.04 * (n % 20), 1.01, 0.1 + 0.04 * (n / 20));
    const double ground = triangles.first_hit(top, down, 0);
    const double roof = ground < 0 ? -1 : triangles.first_hit(top, down, ground + 0.01);
    const double floor = roof < 0 ? -1 : triangles.first_hit(top, down, roof + 0.01);
    if (floor - roof < 1.5) continue;
    cameras.push_back(camera_at(top + down * (0.5 * (floor + roof)), 37.0 * n, -5));
    break;
  }
  return cameras;
}

class ShadowsOfSamples : public testing::TestWithParam<const char*> {};

TEST_P(ShadowsOfSamples, AgreeWithRaysOnTheCpu) {
  const test::Folder folder;
  const char* const level = std::getenv("KARST_SHADOW_LEVEL");
  const test::BakedWorld baked = test::baked_world(folder, GetParam(), KARST_BAKE_PATH,
                                                   {"--sample", GetParam(), "--no-ground", "--levels",
                                                    level != nullptr ? level : "3", "--materials", "none"});
  if (baked.path.empty()) GTEST_SKIP() << baked.missing;
  const std::string file = test::read_text(baked.path);
  test::DrawnSettings settings;
  settings.picture.width = 160;
  settings.picture.height = 90;
  settings.picture.keep_depth = true;
  settings.debug = true;
  settings.cascades = CascadeSettings().count;
  ShadowedWorld world(std::as_bytes(std::span(file)), test::showing_shadows(), settings);
  const Triangles triangles(world.drawn);
  const std::vector<CameraSettings> cameras = cameras_of(world.drawn.world(), triangles);
  Tally all;
  for (const double elevation : {15.0, 35.0, 65.0}) {
    Tally tally;
    for (const double azimuth : {40.0, 205.0, 290.0}) {
      world.drawn.light.sun_azimuth_deg = azimuth;
      world.drawn.light.sun_elevation_deg = elevation;
      for (const CameraSettings& camera : cameras) judge(world, triangles, camera, 1.0, 3, tally);
    }
    std::printf("%s, sun at %.0f: %d of %d judged pixels in shadow, %.3f %% wrong, %.3f %% false shadow\n",
                GetParam(), elevation, tally.shaded, tally.judged, 100.0 * tally.wrong / tally.judged,
                100.0 * tally.acne / tally.judged);
    all.judged += tally.judged;
    all.shaded += tally.shaded;
    all.wrong += tally.wrong;
    all.acne += tally.acne;
  }
  std::printf("%s: %zu cameras, %d of %d judged pixels in shadow, %.3f %% wrong, %.3f %% false shadow\n",
              GetParam(), cameras.size(), all.shaded, all.judged, 100.0 * all.wrong / all.judged,
              100.0 * all.acne / all.judged);
  EXPECT_GT(all.judged, 10'000);
  EXPECT_GT(all.shaded, 500);
  EXPECT_LE(all.wrong, all.judged * 0.005);
  EXPECT_LE(all.acne, all.judged * 0.001);
}

INSTANTIATE_TEST_SUITE_P(All, ShadowsOfSamples, testing::Values("canyon", "caves", "arches", "hills"),
                         [](const auto& sample) { return std::string(sample.param); });

}  // namespace
}  // namespace karst::core
