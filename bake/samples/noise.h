// SPDX-License-Identifier: MIT
// Gradient noise and distance functions for procedural solids. Only integer hashes, + - * / and sqrt: the
// same bits on every compiler (-ffp-contract=off). Perlin, "Improving noise" (2002), for the fade curve and
// the gradients; the hash is a multiply-xorshift with the constants of Wellons, "Prospecting for hash
// functions" (2018), lowbias32.
#pragma once

#include "bake/base/parallel.h"
#include "bake/elevation/solid.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cmath>
#include <cstdint>
#include <vector>

namespace karst::bake {

constexpr std::uint32_t mix_bits(std::uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  x ^= x >> 16;
  return x;
}

constexpr std::uint32_t hash_cell(int x, int y, int z, std::uint32_t seed) {
  const auto u = [](int v) { return static_cast<std::uint32_t>(v); };
  return mix_bits(u(x) * 0x9e3779b1u ^ u(y) * 0x85ebca77u ^ u(z) * 0xc2b2ae3du ^ seed * 0x27d4eb2fu);
}

// Gradient noise of period-free lattice 1, zero at lattice points, within +-1, slope at most about 2.
double noise(glm::dvec2 p, std::uint32_t seed);
double noise(glm::dvec3 p, std::uint32_t seed);

// Sum of octaves, each half as strong and half as wide (2.03: lattices never line up); within +-2.
double fbm(glm::dvec2 p, int octaves, std::uint32_t seed);
double fbm(glm::dvec3 p, int octaves, std::uint32_t seed);

// 0 below 0, 1 above 1, smooth between.
inline double smooth_step(double t) {
  if (t <= 0) return 0;
  if (t >= 1) return 1;
  return t * t * (3 - 2 * t);
}

// A sine made of parabolas, period 1, within +-1.
inline double wave(double t) {
  const double p = t - std::floor(t);
  return p < 0.5 ? 16 * p * (0.5 - p) : -16 * (p - 0.5) * (1 - p);
}

// max(a, b) with the kink rounded over `width` (Quilez, "Smooth minimum", 2013, the quadratic form). Never
// below max, above it by width / 4 at most.
inline double smooth_max(double a, double b, double width) {
  const double overlap = width - std::abs(a - b);
  const double round = overlap > 0 ? overlap * overlap / (4 * width) : 0;
  return (a > b ? a : b) + round;
}
inline double smooth_min(double a, double b, double width) {
  return -smooth_max(-a, -b, width);
}

// Distance to the line segment a b.
double segment_distance(glm::dvec3 a, glm::dvec3 b, glm::dvec3 p);
double segment_distance(glm::dvec2 a, glm::dvec2 b, glm::dvec2 p);
// About the distance to an ellipsoid's surface, negative inside; exact for a sphere.
double ellipsoid_distance(glm::dvec3 centre, glm::dvec3 radii, glm::dvec3 p);

// A function of x and z tabulated on a grid and read back through cubic B-splines: smooth to the second
// derivative, and far cheaper than what it stands for. Beyond the grid the nearest border value.
class TabulatedPlane {
 public:
  TabulatedPlane() = default;
  // function: double(double x, double z), called once a grid point over [min, max] and a margin.
  template <class F>
  TabulatedPlane(glm::dvec2 min, glm::dvec2 max, double spacing, const F& function)
      : origin_(min - 2 * spacing), per_unit_(1 / spacing) {
    width_ = static_cast<int>((max.x - min.x) / spacing) + 6;
    height_ = static_cast<int>((max.y - min.y) / spacing) + 6;
    for (int j = 0; j < height_; ++j) {
      for (int i = 0; i < width_; ++i)
        values_.push_back(function(origin_.x + i * spacing, origin_.y + j * spacing));
    }
  }

  double at(double x, double z) const;

 private:
  glm::dvec2 origin_{0.0};
  double per_unit_ = 1;
  int width_ = 0, height_ = 0;
  std::vector<double> values_;
};

// The same in space.
class TabulatedSpace {
 public:
  TabulatedSpace() = default;
  // function: double(glm::dvec3), called from `threads` threads, once a grid point over the box and a margin.
  template <class F>
  TabulatedSpace(const Box& box, double spacing, int threads, const F& function)
      : origin_(box.min - 2 * spacing), per_unit_(1 / spacing) {
    for (int k = 0; k < 3; ++k) size_[k] = static_cast<int>((box.max[k] - box.min[k]) / spacing) + 6;
    const auto row = static_cast<std::size_t>(size_.x), slice = row * static_cast<std::size_t>(size_.y);
    values_.resize(slice * static_cast<std::size_t>(size_.z));
    parallel_chunks(static_cast<std::size_t>(size_.z), 1, threads, [&](std::size_t z, std::size_t, int) {
      for (std::size_t k = 0; k < slice; ++k) {
        const glm::dvec3 cell(static_cast<double>(k % row), static_cast<double>(k / row),
                              static_cast<double>(z));
        values_[z * slice + k] = static_cast<float>(function(origin_ + spacing * cell));
      }
    });
  }

  double at(glm::dvec3 p) const;

 private:
  glm::dvec3 origin_{0.0};
  double per_unit_ = 1;
  glm::ivec3 size_{0};
  std::vector<float> values_;  // index (z * size_.y + y) * size_.x + x
};

}  // namespace karst::bake
