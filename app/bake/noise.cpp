// SPDX-License-Identifier: MIT
#include "app/bake/noise.h"

#include <glm/geometric.hpp>

#include <algorithm>

namespace karst::bake {
namespace {

double fade(double t) {
  return t * t * t * (t * (t * 6 - 15) + 10);
}
double mix(double a, double b, double t) {
  return a + t * (b - a);
}

// One of the twelve directions to a cube's edges (four of them twice), times d.
double gradient(std::uint32_t hash, double x, double y, double z) {
  switch (hash >> 28) {
    case 0:
      return x + y;
    case 1:
      return y - x;
    case 2:
      return x - y;
    case 3:
      return -x - y;
    case 4:
      return x + z;
    case 5:
      return z - x;
    case 6:
      return x - z;
    case 7:
      return -x - z;
    case 8:
      return y + z;
    case 9:
      return z - y;
    case 10:
      return y - z;
    case 11:
      return -y - z;
    case 12:
      return x + y;
    case 13:
      return z - y;
    case 14:
      return y - x;
    default:
      return -y - z;
  }
}

// One of eight directions of equal length, times d.
double gradient(std::uint32_t hash, double x, double z) {
  constexpr double kDiagonal = 0.70710678118654752;
  switch (hash >> 29) {
    case 0:
      return x;
    case 1:
      return -x;
    case 2:
      return z;
    case 3:
      return -z;
    case 4:
      return kDiagonal * (x + z);
    case 5:
      return kDiagonal * (x - z);
    case 6:
      return kDiagonal * (z - x);
    default:
      return -kDiagonal * (x + z);
  }
}

constexpr double kLacunarity = 2.03;

template <class P>
double sum_octaves(P p, int octaves, std::uint32_t seed) {
  double sum = 0, strength = 1;
  for (int k = 0; k < octaves; ++k) {
    sum += strength * noise(p, seed + static_cast<std::uint32_t>(k));
    p = p * kLacunarity;
    strength *= 0.5;
  }
  return sum;
}

template <class P>
double distance_to_segment(P a, P b, P p) {
  const P ab = b - a, ap = p - a;
  const double length2 = glm::dot(ab, ab);
  const double t = length2 > 0 ? std::clamp(glm::dot(ap, ab) / length2, 0.0, 1.0) : 0.0;
  const P off = ap - t * ab;
  return std::sqrt(glm::dot(off, off));
}

// Weights of the four B-splines around t in [0, 1).
struct SplineWeights {
  double w[4];
  explicit SplineWeights(double t) {
    const double s = 1 - t;
    w[0] = s * s * s / 6;
    w[1] = (4 + t * t * (3 * t - 6)) / 6;
    w[2] = (4 + s * s * (3 * s - 6)) / 6;
    w[3] = t * t * t / 6;
  }
};

}  // namespace

double noise(glm::dvec2 p, std::uint32_t seed) {
  const double fx = std::floor(p.x), fz = std::floor(p.y);
  const int ix = static_cast<int>(fx), iz = static_cast<int>(fz);
  const double x = p.x - fx, z = p.y - fz;
  const double u = fade(x), v = fade(z);
  const auto corner = [&](int i, int k) {
    return gradient(hash_cell(ix + i, 0, iz + k, seed), x - i, z - k);
  };
  // 1.4: the largest value is sqrt(1/2).
  return 1.4 * mix(mix(corner(0, 0), corner(1, 0), u), mix(corner(0, 1), corner(1, 1), u), v);
}

double noise(glm::dvec3 p, std::uint32_t seed) {
  const double fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
  const int ix = static_cast<int>(fx), iy = static_cast<int>(fy), iz = static_cast<int>(fz);
  const double x = p.x - fx, y = p.y - fy, z = p.z - fz;
  const double u = fade(x), v = fade(y), w = fade(z);
  const auto corner = [&](int i, int j, int k) {
    return gradient(hash_cell(ix + i, iy + j, iz + k, seed), x - i, y - j, z - k);
  };
  const auto square = [&](int k) {
    return mix(mix(corner(0, 0, k), corner(1, 0, k), u), mix(corner(0, 1, k), corner(1, 1, k), u), v);
  };
  return mix(square(0), square(1), w);
}

double fbm(glm::dvec2 p, int octaves, std::uint32_t seed) {
  return sum_octaves(p, octaves, seed);
}
double fbm(glm::dvec3 p, int octaves, std::uint32_t seed) {
  return sum_octaves(p, octaves, seed);
}

double segment_distance(glm::dvec3 a, glm::dvec3 b, glm::dvec3 p) {
  return distance_to_segment(a, b, p);
}
double segment_distance(glm::dvec2 a, glm::dvec2 b, glm::dvec2 p) {
  return distance_to_segment(a, b, p);
}

double ellipsoid_distance(glm::dvec3 centre, glm::dvec3 radii, glm::dvec3 p) {
  const glm::dvec3 q = (p - centre) / radii;
  const glm::dvec3 g = q / radii;
  const double length = std::sqrt(glm::dot(q, q));
  const double slope = std::sqrt(glm::dot(g, g));
  const double least = std::min({radii.x, radii.y, radii.z});
  return slope > 0 ? length * (length - 1) / slope : -least;
}

double TabulatedPlane::at(double x, double z) const {
  const double i = std::clamp((x - origin_.x) * per_unit_, 1.0, width_ - 3.001);
  const double j = std::clamp((z - origin_.y) * per_unit_, 1.0, height_ - 3.001);
  const int column = static_cast<int>(i), row = static_cast<int>(j);
  const SplineWeights across(i - column), down(j - row);
  const auto width = static_cast<std::size_t>(width_);
  const double* first =
      values_.data() + static_cast<std::size_t>(row - 1) * width + static_cast<std::size_t>(column - 1);
  double sum = 0;
  for (int k = 0; k < 4; ++k, first += width_) {
    sum += down.w[k] * (across.w[0] * first[0] + across.w[1] * first[1] + across.w[2] * first[2] +
                        across.w[3] * first[3]);
  }
  return sum;
}

}  // namespace karst::bake
