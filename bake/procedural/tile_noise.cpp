// SPDX-License-Identifier: MIT
#include "bake/procedural/tile_noise.h"

#include "bake/samples/noise.h"

#include <cmath>

namespace karst::bake {
namespace {

constexpr float kNoiseScale = 1.45f;  // makes the largest values of 2D gradient noise about 1

int wrap(int i, int period) {
  if (i >= 0 && i < period) return i;  // nearly always, and a division takes long
  const int rest = i % period;
  return rest < 0 ? rest + period : rest;
}

float fade(float t) {
  return t * t * t * (t * (t * 6 - 15) + 10);
}

// The gradient at a lattice point times the way from it: 16 directions of about the same length.
float slope_at(int i, int j, std::uint32_t seed, float x, float y) {
  const std::uint32_t hash = hash_cell(i, j, 0, seed);
  static constexpr float kA = 0.38268343f, kB = 0.70710678f, kC = 0.92387953f;
  static constexpr float kGradient[16][2] = {
      {1, 0},  {kC, kA},   {kB, kB},   {kA, kC},   {0, 1},  {-kA, kC}, {-kB, kB}, {-kC, kA},
      {-1, 0}, {-kC, -kA}, {-kB, -kB}, {-kA, -kC}, {0, -1}, {kA, -kC}, {kB, -kB}, {kC, -kA}};
  const float(&gradient)[2] = kGradient[hash & 15];
  return gradient[0] * x + gradient[1] * y;
}

}  // namespace

float tile_noise(glm::vec2 p, glm::ivec2 period, std::uint32_t seed) {
  const float x = p.x * static_cast<float>(period.x), y = p.y * static_cast<float>(period.y);
  const float fx = std::floor(x), fy = std::floor(y);
  const int i = static_cast<int>(fx), j = static_cast<int>(fy);
  const int i0 = wrap(i, period.x), i1 = wrap(i + 1, period.x);
  const int j0 = wrap(j, period.y), j1 = wrap(j + 1, period.y);
  const float u = x - fx, v = y - fy;
  const float a = slope_at(i0, j0, seed, u, v), b = slope_at(i1, j0, seed, u - 1, v);
  const float c = slope_at(i0, j1, seed, u, v - 1), d = slope_at(i1, j1, seed, u - 1, v - 1);
  const float s = fade(u), t = fade(v);
  const float low = a + (b - a) * s, high = c + (d - c) * s;
  return kNoiseScale * (low + (high - low) * t);
}

float tile_noise(glm::vec2 p, int period, std::uint32_t seed) {
  return tile_noise(p, glm::ivec2(period), seed);
}

float tile_fbm(glm::vec2 p, glm::ivec2 period, int octaves, std::uint32_t seed, float gain) {
  float sum = 0, strength = 1, all = 0;
  for (int k = 0; k < octaves; ++k) {
    sum += strength * tile_noise(p, period, seed + static_cast<std::uint32_t>(k) * 101);
    all += strength;
    strength *= gain;
    period *= 2;
  }
  // The octaves rarely add up: this makes the range about that of one.
  return sum / all * 1.25f;
}

float tile_fbm(glm::vec2 p, int period, int octaves, std::uint32_t seed, float gain) {
  return tile_fbm(p, glm::ivec2(period), octaves, seed, gain);
}

TileCell tile_cell(glm::vec2 p, glm::ivec2 period, float jitter, std::uint32_t seed) {
  const float x = p.x * static_cast<float>(period.x), y = p.y * static_cast<float>(period.y);
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  // The points of the cells around, up to two away.
  struct Point {
    glm::vec2 to;
    std::uint32_t id;
  };
  Point points[5][5];
  int column[5];
  for (int di = -2; di <= 2; ++di) column[di + 2] = wrap(i + di, period.x);
  for (int dj = -2; dj <= 2; ++dj) {
    const int row = wrap(j + dj, period.y);
    for (int di = -2; di <= 2; ++di) {
      const std::uint32_t id = hash_cell(column[di + 2], row, 0, seed);
      const float px = 0.5f + jitter * (unit_of(id) - 0.5f),
                  py = 0.5f + jitter * (unit_of(mix_bits(id)) - 0.5f);
      points[dj + 2][di + 2] = {{static_cast<float>(i + di) + px - x, static_cast<float>(j + dj) + py - y},
                                id};
    }
  }
  TileCell cell;
  float best = 1e9f;
  for (int dj = 1; dj <= 3; ++dj) {
    for (int di = 1; di <= 3; ++di) {
      const auto& [to, id] = points[dj][di];
      const float square = to.x * to.x + to.y * to.y;
      if (square >= best) continue;
      best = square;
      cell.id = id;
      cell.to = to;
    }
  }
  cell.nearest = std::sqrt(best);
  cell.border = 1e9f;
  for (const auto& row : points) {
    for (const auto& [to, id] : row) {
      const glm::vec2 way(to.x - cell.to.x, to.y - cell.to.y);
      const float square = way.x * way.x + way.y * way.y;
      if (square < 1e-6f) continue;
      const float along = (0.5f * (to.x + cell.to.x) * way.x + 0.5f * (to.y + cell.to.y) * way.y);
      const float distance = along / std::sqrt(square);
      if (distance < cell.border) cell.border = distance;
    }
  }
  return cell;
}

}  // namespace karst::bake
