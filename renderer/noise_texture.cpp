// SPDX-License-Identifier: MIT
#include "renderer/noise_texture.h"

#include <algorithm>
#include <cmath>

namespace karst {
namespace {

// Cells of the coarsest octave across the texture. Four, so that the pattern is not seen to be one blob a
// tile.
constexpr int kBasePeriod = 4;
constexpr int kOctaves = 5;  // the finest has 4 texels a cell; finer would only be removed by filtering
constexpr float kGain = 0.55f;

// Standard deviations of 0.35 of a channel's range, so that one texel in 200 is cut off; kRidgeMean makes the
// mean of the height zero. Found by measuring the sums below.
constexpr float kMottleScale = 1.3f;
constexpr float kHeightScale = 1.1f;
constexpr float kSlopeScale = 0.036f * kNoiseSide;  // of the height's change a texel
constexpr float kRidgeMean = 0.349f;

std::uint32_t hash(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
  // Integer finaliser of MurmurHash3 (A. Appleby) over a combination with large odd constants.
  std::uint32_t h = x * 0x9e3779b1u + y * 0x85ebca77u + seed * 0xc2b2ae3du;
  h ^= h >> 16;
  h *= 0x85ebca6bu;
  h ^= h >> 13;
  h *= 0xc2b2ae35u;
  return h ^ h >> 16;
}

// Eight directions, turned by 22.5 degrees off the axes: noise with gradients along an axis shows its lattice
// as lines.
constexpr float kDirections[8][2] = {{0.9239f, 0.3827f},  {0.3827f, 0.9239f},   {-0.3827f, 0.9239f},
                                     {-0.9239f, 0.3827f}, {-0.9239f, -0.3827f}, {-0.3827f, -0.9239f},
                                     {0.3827f, -0.9239f}, {0.9239f, -0.3827f}};

// Dot product of the offset with a corner's direction.
float corner(int cell_x, int cell_y, int period, std::uint32_t seed, float dx, float dy) {
  const auto wrap = [period](int c) { return static_cast<std::uint32_t>(c & (period - 1)); };
  const float* d = kDirections[hash(wrap(cell_x), wrap(cell_y), seed) & 7u];
  return d[0] * dx + d[1] * dy;
}

// About -0.7..0.7. x, y in cells; period a power of two.
float gradient_noise(float x, float y, int period, std::uint32_t seed) {
  const int cx = static_cast<int>(std::floor(x));
  const int cy = static_cast<int>(std::floor(y));
  const float fx = x - static_cast<float>(cx);
  const float fy = y - static_cast<float>(cy);
  const auto fade = [](float t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); };
  const auto mix = [](float a, float b, float t) { return a + (b - a) * t; };
  const float u = fade(fx);
  const float low =
      mix(corner(cx, cy, period, seed, fx, fy), corner(cx + 1, cy, period, seed, fx - 1, fy), u);
  const float high = mix(corner(cx, cy + 1, period, seed, fx, fy - 1),
                         corner(cx + 1, cy + 1, period, seed, fx - 1, fy - 1), u);
  return mix(low, high, fade(fy));
}

// Octave n of a sum, at texel (s, t). Each is shifted by another part of a cell, so that lattice points,
// where all gradient noise is zero, do not fall on each other.
float octave_noise(int s, int t, int octave, std::uint32_t seed) {
  const int period = kBasePeriod << octave;
  const float cells_per_texel = static_cast<float>(period) / kNoiseSide;
  const float shift = 0.37f * static_cast<float>(octave);
  return gradient_noise(static_cast<float>(s) * cells_per_texel + shift,
                        static_cast<float>(t) * cells_per_texel - shift, period,
                        seed + static_cast<std::uint32_t>(octave));
}

float mottle(int s, int t) {
  float sum = 0;
  float amplitude = 1;
  for (int octave = 0; octave < kOctaves; ++octave) {
    sum += amplitude * octave_noise(s, t, octave, 0);
    amplitude *= kGain;
  }
  return sum;
}

// Ridged in the coarse octaves, plain in the fine ones: cracks with rough faces between.
float height(int s, int t) {
  float sum = 0;
  float amplitude = 1;
  for (int octave = 0; octave < kOctaves; ++octave) {
    const float n = octave_noise(s, t, octave, 16);
    sum += amplitude * (octave < 3 ? 2.0f * std::fabs(n) - kRidgeMean : n);
    amplitude *= kGain;
  }
  return sum;
}

std::uint8_t to_byte(float value) {
  return static_cast<std::uint8_t>(std::clamp(128.5f + 127.0f * value, 1.0f, 255.0f));
}

}  // namespace

NoiseRows::NoiseRows() {
  // Rows wrap around: the one before the first is the last.
  for (int t = -1; t <= 0; ++t) {
    for (int s = 0; s < kNoiseSide; ++s) heights_[(t + 3) % 3][static_cast<std::size_t>(s)] = height(s, t);
  }
}

void NoiseRows::next(std::span<std::uint8_t> rgba) {
  const Row& before = heights_[(row_ + 2) % 3];
  const Row& here = heights_[row_ % 3];
  Row& after = heights_[(row_ + 1) % 3];
  for (int s = 0; s < kNoiseSide; ++s) after[static_cast<std::size_t>(s)] = height(s, row_ + 1);
  for (std::size_t s = 0; s < kNoiseSide; ++s) {
    const float slope_s = 0.5f * (here[(s + 1) % kNoiseSide] - here[(s + kNoiseSide - 1) % kNoiseSide]);
    const float slope_t = 0.5f * (after[s] - before[s]);
    std::uint8_t* texel = rgba.data() + s * 4;
    texel[0] = to_byte(kMottleScale * mottle(static_cast<int>(s), row_));
    texel[1] = to_byte(kHeightScale * here[s]);
    texel[2] = to_byte(kSlopeScale * slope_s);
    texel[3] = to_byte(kSlopeScale * slope_t);
  }
  ++row_;
}

}  // namespace karst
