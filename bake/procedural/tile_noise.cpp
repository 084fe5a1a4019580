// SPDX-License-Identifier: MIT
#include "bake/procedural/tile_noise.h"

#include "bake/samples/noise.h"

#include <cmath>
#include <cstddef>

namespace karst::bake {
namespace {

constexpr float kNoiseScale = 1.45f;  // makes the largest values of 2D gradient noise about 1
constexpr int kRim = 2;               // cells around one that its border may be with

int wrap(int i, int period) {
  if (i >= 0 && i < period) return i;  // nearly always, and a division takes long
  const int rest = i % period;
  return rest < 0 ? rest + period : rest;
}

// std::floor is a call where the processor may be any. Of what int holds.
int floor_of(float x) {
  const int whole = static_cast<int>(x);
  return static_cast<float>(whole) > x ? whole - 1 : whole;
}

float fade(float t) {
  return t * t * t * (t * (t * 6 - 15) + 10);
}

// 16 directions of about the same length.
constexpr float kA = 0.38268343f, kB = 0.70710678f, kC = 0.92387953f;
constexpr glm::vec2 kGradients[16] = {{1, 0},    {kC, kA},  {kB, kB},  {kA, kC},   {0, 1},     {-kA, kC},
                                      {-kB, kB}, {-kC, kA}, {-1, 0},   {-kC, -kA}, {-kB, -kB}, {-kA, -kC},
                                      {0, -1},   {kA, -kC}, {kB, -kB}, {kC, -kA}};

float slope_at(glm::vec2 gradient, float x, float y) {
  return gradient.x * x + gradient.y * y;
}

std::size_t index_of(int i, int j, int row) {
  return static_cast<std::size_t>(j) * static_cast<std::size_t>(row) + static_cast<std::size_t>(i);
}

}  // namespace

TileNoise::TileNoise(glm::ivec2 period, std::uint32_t seed) : period_(period) {
  gradients_.reserve(index_of(0, period.y + 1, period.x + 1));
  for (int j = 0; j <= period.y; ++j) {
    for (int i = 0; i <= period.x; ++i) {
      gradients_.push_back(kGradients[hash_cell(wrap(i, period.x), wrap(j, period.y), 0, seed) & 15]);
    }
  }
}

float TileNoise::at(glm::vec2 p) const {
  const float x = p.x * static_cast<float>(period_.x), y = p.y * static_cast<float>(period_.y);
  const int whole_x = floor_of(x), whole_y = floor_of(y);
  const int i = wrap(whole_x, period_.x), j = wrap(whole_y, period_.y);
  const int row = period_.x + 1;
  const glm::vec2* low_row = &gradients_[index_of(i, j, row)];
  const glm::vec2* high_row = low_row + row;
  const float u = x - static_cast<float>(whole_x), v = y - static_cast<float>(whole_y);
  const float a = slope_at(low_row[0], u, v), b = slope_at(low_row[1], u - 1, v);
  const float c = slope_at(high_row[0], u, v - 1), d = slope_at(high_row[1], u - 1, v - 1);
  const float s = fade(u), t = fade(v);
  const float low = a + (b - a) * s, high = c + (d - c) * s;
  return kNoiseScale * (low + (high - low) * t);
}

TileFbm::TileFbm(glm::ivec2 period, int octaves, std::uint32_t seed, float gain) : gain_(gain) {
  float strength = 1;
  for (int k = 0; k < octaves; ++k) {
    octaves_.emplace_back(period, seed + static_cast<std::uint32_t>(k) * 101);
    all_ += strength;
    strength *= gain;
    period *= 2;
  }
}

float TileFbm::at(glm::vec2 p) const {
  float sum = 0, strength = 1;
  for (const TileNoise& octave : octaves_) {
    sum += strength * octave.at(p);
    strength *= gain_;
  }
  // The octaves rarely add up: this makes the range about that of one.
  return sum / all_ * 1.25f;
}

TileCells::TileCells(glm::ivec2 period, float jitter, std::uint32_t seed) : period_(period) {
  points_.reserve(index_of(0, period.y + 2 * kRim, period.x + 2 * kRim));
  for (int j = -kRim; j < period.y + kRim; ++j) {
    for (int i = -kRim; i < period.x + kRim; ++i) {
      const std::uint32_t id = hash_cell(wrap(i, period.x), wrap(j, period.y), 0, seed);
      const float s = 0.5f + jitter * (unit_of(id) - 0.5f),
                  t = 0.5f + jitter * (unit_of(mix_bits(id)) - 0.5f);
      points_.push_back({{s, t}, id});
    }
  }
}

const TileCells::Point* TileCells::cell_of(glm::ivec2 cell) const {
  const int i = wrap(cell.x, period_.x) + kRim, j = wrap(cell.y, period_.y) + kRim;
  return &points_[index_of(i, j, period_.x + 2 * kRim)];
}

TileCells::Nearest TileCells::nearest(glm::vec2 p) const {
  const float x = p.x * static_cast<float>(period_.x), y = p.y * static_cast<float>(period_.y);
  const int i = floor_of(x), j = floor_of(y);
  const Point* cell = cell_of({i, j});
  Nearest result;
  float best = 1e9f;
  for (int dj = -1; dj <= 1; ++dj) {
    const Point* row = cell + dj * (period_.x + 2 * kRim);
    for (int di = -1; di <= 1; ++di) {
      const Point& point = row[di];
      const glm::vec2 to(static_cast<float>(i + di) + point.place.x - x,
                         static_cast<float>(j + dj) + point.place.y - y);
      const float square = to.x * to.x + to.y * to.y;
      if (square >= best) continue;
      best = square;
      result.id = point.id;
      result.to = to;
    }
  }
  result.distance = std::sqrt(best);
  return result;
}

float TileCells::border(glm::vec2 p, const Nearest& nearest) const {
  const float x = p.x * static_cast<float>(period_.x), y = p.y * static_cast<float>(period_.y);
  const int i = floor_of(x), j = floor_of(y);
  const Point* cell = cell_of({i, j});
  float border = 1e9f;
  for (int dj = -kRim; dj <= kRim; ++dj) {
    const Point* row = cell + dj * (period_.x + 2 * kRim);
    for (int di = -kRim; di <= kRim; ++di) {
      const Point& point = row[di];
      const glm::vec2 to(static_cast<float>(i + di) + point.place.x - x,
                         static_cast<float>(j + dj) + point.place.y - y);
      const glm::vec2 way(to.x - nearest.to.x, to.y - nearest.to.y);
      const float square = way.x * way.x + way.y * way.y;
      if (square < 1e-6f) continue;
      const float along = (0.5f * (to.x + nearest.to.x) * way.x + 0.5f * (to.y + nearest.to.y) * way.y);
      // Of most points it is plain without a root that their border is further away.
      if (along > 0 && along * along > 1.0001f * (border * border) * square) continue;
      const float distance = along / std::sqrt(square);
      if (distance < border) border = distance;
    }
  }
  return border;
}

}  // namespace karst::bake
