// SPDX-License-Identifier: MIT
#include "renderer/input/surroundings_block.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace karst::core {
namespace {

constexpr double kTurn = 2.0 * 3.14159265358979323846;
constexpr double kGoldenTurn = kTurn * 0.38196601125010515;
constexpr double kGravity = 9.81;      // m / s^2
constexpr double kLongestM = 87.0;     // of waves
constexpr double kNextLength = 0.477;  // times that of the wave before
constexpr double kWind = 0.6;          // radians from x to z: where waves run to
// Radians from there, so that no two waves run alike.
constexpr double kSpread[KARST_WAVES] = {0.12, -0.45, 0.62, -0.21, 0.93, -0.83};
constexpr float kNone = 1e9f;   // voxels
constexpr double kDeepM = 1e4;  // of a sea whose bed is not known

float smooth_step(float low, float high, float value) {
  const float t = std::clamp((value - low) / (high - low), 0.0f, 1.0f);
  return t * t * (3.0f - 2.0f * t);
}

float coverage(float low, float high, float soft, float value) {
  return smooth_step(low - soft, low + soft, value) * (1.0f - smooth_step(high - soft, high + soft, value));
}

}  // namespace

glm::vec3 level_ground(const MaterialSet& materials, float height) {
  glm::vec3 albedo = FrameSurroundings().plain_albedo;
  for (std::uint32_t n = 0; n < materials.count; ++n) {
    const Material& m = materials.materials[n];
    const float lies = coverage(m.slope_low, m.slope_high, m.slope_soft, 1.0f) *
                       coverage(m.height_low, m.height_high, m.height_soft, height);
    const glm::vec3 average(m.average[0], m.average[1], m.average[2]);
    albedo += (average - albedo) * (n == 0 ? 1.0f : lies);
  }
  return albedo;
}

void set_surroundings(const Camera& camera, const FrameSurroundings& surroundings,
                      shader::FrameBlock& block) {
  const Surroundings& world = surroundings.world;
  const glm::dvec3 eye = eye_lattice(camera) / static_cast<double>(kStepsPerVoxel);
  const double size = surroundings.voxel_size_m;
  block.water = {-kNone, static_cast<float>(size), 0.0f, 0.0f};
  block.plain = glm::vec4(surroundings.plain_albedo, kNone);
  if (surroundings.has_plain) block.plain.w = static_cast<float>(double{world.plain_level} - eye.y);
  double length_m = kLongestM;
  for (int n = 0; n < KARST_WAVES; ++n, length_m *= kNextLength) {
    const double k = kTurn / length_m;  // radians a metre
    if (surroundings.curved) {
      // Ways evenly spread over the sphere: some run along what is level wherever that is.
      const double up = (2.0 * n + 1.0) / KARST_WAVES - 1.0;
      const double turn = kGoldenTurn * n;
      const double level = std::sqrt(1.0 - up * up);
      const glm::dvec3 way = glm::dvec3(level * std::cos(turn), up, level * std::sin(turn)) * (k * size);
      const double at_eye = glm::dot(way, eye) - std::sqrt(kGravity * k) * surroundings.water_time_s;
      block.water_wave[n] = glm::vec4(glm::vec3(way), static_cast<float>(std::remainder(at_eye, kTurn)));
      continue;
    }
    const double x = std::cos(kWind + kSpread[n]);
    const double z = std::sin(kWind + kSpread[n]);
    // Deep water waves: those of a length have one speed.
    const double phase =
        k * size * (x * eye.x + z * eye.z) - std::sqrt(kGravity * k) * surroundings.water_time_s;
    block.water_wave[n] = {static_cast<float>(k * size * x), static_cast<float>(k * size * z),
                           static_cast<float>(std::remainder(phase, kTurn)), static_cast<float>(k * size)};
  }
  if (!world.has_water()) return;
  block.water.x = static_cast<float>(double{world.water_level} - eye.y);
  if (!surroundings.has_plain) block.plain.w = block.water.x - static_cast<float>(kDeepM / size);
}

}  // namespace karst::core
