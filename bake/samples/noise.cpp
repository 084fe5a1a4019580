// SPDX-License-Identifier: MIT
#include "bake/samples/noise.h"

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

// The twelve directions to a cube's edges (four of them twice), and eight of equal length in the plane.
// Looked up rather than branched to: the branches of a hash are never predicted.
constexpr double kEdges[16][3] = {{1, 1, 0},  {-1, 1, 0},  {1, -1, 0}, {-1, -1, 0}, {1, 0, 1},  {-1, 0, 1},
                                  {1, 0, -1}, {-1, 0, -1}, {0, 1, 1},  {0, -1, 1},  {0, 1, -1}, {0, -1, -1},
                                  {1, 1, 0},  {0, -1, 1},  {-1, 1, 0}, {0, -1, -1}};
constexpr double kDiagonal = 0.70710678118654752;
constexpr double kWays[8][2] = {{1, 0},
                                {-1, 0},
                                {0, 1},
                                {0, -1},
                                {kDiagonal, kDiagonal},
                                {kDiagonal, -kDiagonal},
                                {-kDiagonal, kDiagonal},
                                {-kDiagonal, -kDiagonal}};

double gradient(std::uint32_t hash, double x, double y, double z) {
  const double* g = kEdges[hash >> 28];
  return g[0] * x + g[1] * y + g[2] * z;
}
double gradient(std::uint32_t hash, double x, double z) {
  const double* g = kWays[hash >> 29];
  return g[0] * x + g[1] * z;
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

double TabulatedSpace::at(glm::dvec3 p) const {
  std::size_t cell[3];
  double t[3];
  for (int k = 0; k < 3; ++k) {
    const double c = std::clamp((p[k] - origin_[k]) * per_unit_, 1.0, size_[k] - 3.001);
    const int whole = static_cast<int>(c);
    cell[k] = static_cast<std::size_t>(whole - 1);
    t[k] = c - whole;
  }
  const SplineWeights wx(t[0]), wy(t[1]), wz(t[2]);
  const auto row = static_cast<std::size_t>(size_.x), slice = row * static_cast<std::size_t>(size_.y);
  const float* first = values_.data() + cell[2] * slice + cell[1] * row + cell[0];
  double sum = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    double plane = 0;
    for (std::size_t j = 0; j < 4; ++j) {
      const float* v = first + k * slice + j * row;
      plane += wy.w[j] * ((wx.w[0] * double{v[0]} + wx.w[1] * double{v[1]}) +
                          (wx.w[2] * double{v[2]} + wx.w[3] * double{v[3]}));
    }
    sum += wz.w[k] * plane;
  }
  return sum;
}

}  // namespace karst::bake
