// SPDX-License-Identifier: MIT
#include "terrain/procedural/procedural_surface.h"

#include "terrain/base/check.h"
#include "terrain/base/simd.h"
#include "terrain/procedural/simplex_noise.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace karst::core {

using simd::Float4;
using simd::splat;

namespace {

constexpr int kBlock = 16;  // samples: what is near is looked up once a block of kBlock^2
// How features differ from their bare shape, by the noise around them.
constexpr float kHillNoise = 0.5f;
constexpr float kMountainLeast = 0.55f, kMountainRidge = 1.0f;  // ridges are 0.4 on average
constexpr double kRidgePersistence = 0.55;
constexpr float kOutline = 0.4f;    // how much nearer than its radius a feature ends at most
constexpr float kBody = 0.55f;      // of a mountain; the rest is its top
constexpr float kTopReach = 1.7f;   // how much narrower the top is
constexpr float kWindward = 0.74f;  // of a dune's wavelength
constexpr float kDunePhase = 1.4f, kDuneFrom = 0.55f, kDuneNoise = 1.3f;
constexpr float kBank = 0.25f;  // how far banks stand above the level, in depths

// 1 at 0, 0 at 1, level at both (Zaijer 3.5); of 0..1.
Float4 cubic(Float4 t) {
  return (2.0f * t - 3.0f) * t * t + 1.0f;
}
Float4 within_one(Float4 t) {
  return simd::min(simd::max(t, splat(0.0f)), splat(1.0f));
}

struct Octaves {
  int count;
  double per_wave[kMostOctaves];
  float weight[kMostOctaves], ridge_weight[kMostOctaves];  // 1 together

  explicit Octaves(const NoiseSum& noise) : count(noise.octaves), per_wave{}, weight{}, ridge_weight{} {
    KARST_ASSERT(count >= 1 && count <= kMostOctaves);
    double sum = 0, ridge_sum = 0, strong = 1, ridge = 1, frequency = 1 / noise.wavelength_m;
    for (int i = 0; i < count; ++i) {
      per_wave[i] = frequency;
      weight[i] = static_cast<float>(strong);
      ridge_weight[i] = static_cast<float>(ridge);
      sum += strong;
      ridge_sum += ridge;
      strong *= noise.persistence;
      ridge *= kRidgePersistence;
      frequency *= 2;
    }
    for (int i = 0; i < count; ++i) {
      weight[i] /= static_cast<float>(sum);
      ridge_weight[i] /= static_cast<float>(ridge_sum);
    }
  }
};

// Four places, and the noise there: its sum, how near its octaves are to 0, and the first three.
struct Noisy {
  Places x, z;
  Float4 sum, ridges, octave[3];

  Noisy(const Octaves& octaves, std::uint32_t seed, const Places& at_x, const Places& at_z)
      : x(at_x), z(at_z), sum(splat(0.0f)), ridges(sum), octave{sum, sum, sum} {
    Float4 rough = splat(1.0f);
    for (int i = 0; i < octaves.count; ++i) {
      // Moved, so that the octaves' zeros do not all lie at the origin.
      const Float4 noise =
          simplex_noise(x * octaves.per_wave[i] + (0.371 * i + 0.13),
                        z * octaves.per_wave[i] + (0.617 * i + 0.41), seed + static_cast<std::uint32_t>(i));
      sum += octaves.weight[i] * noise;
      // Fine ridges are on coarse ones, and valleys stay smooth.
      const Float4 ridge = 1.0f - simd::abs(noise);
      const Float4 sharp = ridge * ridge * rough;
      rough = within_one(2.0f * sharp);
      ridges += octaves.ridge_weight[i] * sharp;
      if (i < 3) octave[i] = noise;
    }
  }
};

struct Away {
  Float4 x, z;
  Float4 square() const { return x * x + z * z; }
};
Away away_from(const Noisy& at, glm::dvec2 place) {
  return {to_float(at.x + -place.x), to_float(at.z + -place.y)};
}

Float4 dunes_profile(const Feature& dunes, const Noisy& at) {
  const double per_x = dunes.towards.x / dunes.wavelength_m, per_z = dunes.towards.y / dunes.wavelength_m;
  const Places along = at.x * per_x + at.z * per_z;
  const auto fraction = [](simd::Double2 v) {
    return simd::Double2{v[0] - std::floor(v[0]), v[1] - std::floor(v[1])};
  };
  Float4 phase = to_float({fraction(along.first), fraction(along.second)}) +
                 kDunePhase * (at.octave[0] + 0.4f * at.octave[1] + 0.15f * at.octave[2]);
  phase -= simd::to_float(simd::to_int(phase + 8.0f)) - 8.0f;
  const Float4 rise = phase * (1 / kWindward), fall = (1.0f - phase) * (1 / (1 - kWindward));
  const Float4 t = within_one(simd::min(rise, fall));
  return t * t * (2.0f - t);
}

Float4 with_feature(Float4 height, const Feature& feature, const Noisy& at) {
  const Away away = away_from(at, feature.place_m);
  const Float4 share = within_one(simd::sqrt(away.square()) * static_cast<float>(1 / feature.radius_m) *
                                  (1.0f + kOutline * within_one(0.5f + 0.5f * at.octave[1])));
  const Float4 body = cubic(share);
  const auto high = static_cast<float>(feature.height_m);
  if (feature.kind == FeatureKind::hill) return height + high * body * (1.0f + kHillNoise * at.sum);
  if (feature.kind == FeatureKind::mountain) {
    const auto sharp = static_cast<float>(feature.peakiness);
    const Float4 inner = within_one(kTopReach * share);
    const Float4 top = (1 - sharp) * cubic(inner) + sharp * cubic(simd::sqrt(inner));
    const Float4 shape = kBody * body + (1 - kBody) * top;
    return height + high * shape * (kMountainLeast + kMountainRidge * at.ridges);
  }
  const Float4 lies = within_one(kDuneFrom + kDuneNoise * at.octave[1]);
  return height + high * body * lies * dunes_profile(feature, at);
}

Float4 with_river(Float4 height, const Feature& river, std::span<const RiverPiece> all,
                  std::span<const std::uint32_t> near, const Noisy& at) {
  Float4 least = splat(3e38f), level = splat(0.0f);
  for (const std::uint32_t n : near) {
    const RiverPiece& piece = all[n];
    const Away away = away_from(at, piece.from_m);
    const glm::dvec2 way = piece.to_m - piece.from_m;
    const double length = glm::dot(way, way);
    const auto x = static_cast<float>(way.x), z = static_cast<float>(way.y);
    const float per_length = length > 0 ? static_cast<float>(1 / length) : 0.0f;
    const Float4 t = within_one((away.x * x + away.z * z) * per_length);
    const Away rest{away.x - t * x, away.z - t * z};
    const Float4 square = rest.square();
    const simd::Int4 is_nearer = square < least;
    least = simd::select(is_nearer, square, least);
    level = simd::select(is_nearer, piece.from_level_m + t * (piece.to_level_m - piece.from_level_m), level);
  }
  const Float4 away = simd::sqrt(least);
  const auto half = static_cast<float>(0.5 * river.width_m), depth = static_cast<float>(river.depth_m);
  const Float4 wide = 1.0f + 2 * kOutline * within_one(0.5f + 0.5f * at.octave[2]);
  const Float4 valley = cubic(within_one(wide * (away - half) * static_cast<float>(1 / river.valley_m)));
  const Float4 bed = cubic(within_one(away * (1 / half)));
  const Float4 banks = level + kBank * depth;
  return height + valley * (banks - height) - (1 + kBank) * depth * bed;
}

double away_m(const RiverPiece& piece, glm::dvec2 place) {
  const glm::dvec2 way = piece.to_m - piece.from_m, from = place - piece.from_m;
  const double length = glm::dot(way, way);
  const double t = length > 0 ? std::clamp(glm::dot(from, way) / length, 0.0, 1.0) : 0.0;
  return glm::length(from - t * way);
}

// What acts in a block: numbers of features, and behind each river's how many pieces and their numbers.
class Near {
 public:
  Near(const ProceduralSurface& surface, std::span<std::uint32_t> room, glm::dvec2 middle, double reach)
      : room_(room), used_(0) {
    // More than rounding can hide, so that what is left out would have changed no bit.
    reach += 1e-3 + 1e-6 * (reach + glm::length(middle));
    for (std::uint32_t n = 0; n < surface.features.size(); ++n) {
      const Feature& feature = surface.features[n];
      if (feature.kind != FeatureKind::river) {
        if (glm::length(middle - feature.place_m) <= feature.radius_m * (1 + 1e-6) + reach) add(n);
        continue;
      }
      if (glm::length(middle - feature.place_m) > feature.radius_m * (1 + 1e-6) + reach) continue;
      add_river(surface, n, middle, reach);
    }
  }
  std::span<const std::uint32_t> all() const { return room_.first(used_); }

 private:
  void add(std::uint32_t n) { room_[used_++] = n; }
  void add_river(const ProceduralSurface& surface, std::uint32_t n, glm::dvec2 middle, double reach) {
    const Feature& river = surface.features[n];
    double least = 1e300;
    for (std::uint32_t k = 0; k < river.pieces; ++k)
      least = std::min(least, away_m(surface.pieces[river.first_piece + k], middle));
    if (least > (0.5 * river.width_m + river.valley_m) * (1 + 1e-6) + reach) return;
    add(n);
    const std::size_t count = used_;
    add(0);
    for (std::uint32_t k = 0; k < river.pieces; ++k) {
      // A piece that is nearest anywhere in the block is not farther than this from its middle.
      if (away_m(surface.pieces[river.first_piece + k], middle) <= least + 2 * reach)
        add(river.first_piece + k);
    }
    room_[count] = static_cast<std::uint32_t>(used_ - count - 1);
  }

  std::span<std::uint32_t> room_;
  std::size_t used_;
};

// Those of a kind come first, all in their order; returns how many. Without memory of its own, unlike
// std::stable_partition.
std::size_t gather(std::span<Feature> features, FeatureKind kind) {
  if (features.size() < 2) return !features.empty() && features[0].kind == kind ? 1 : 0;
  const std::size_t half = features.size() / 2;
  const std::size_t left = gather(features.first(half), kind);
  const std::size_t right = gather(features.subspan(half), kind);
  const auto at = [&](std::size_t n) { return features.begin() + static_cast<std::ptrdiff_t>(n); };
  std::rotate(at(left), at(half), at(half + right));
  return left + right;
}

}  // namespace

std::size_t river_pieces(std::span<const RiverPoint> points, double tolerance_m, std::span<RiverPiece> out) {
  KARST_ASSERT(points.size() >= 2 && tolerance_m > 0);
  std::size_t pieces = 0;
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    const glm::dvec2 b = points[k].place_m, c = points[k + 1].place_m;
    const glm::dvec2 a = k > 0 ? points[k - 1].place_m : b;
    const glm::dvec2 d = k + 2 < points.size() ? points[k + 2].place_m : c;
    // b + t one + t^2 two + t^3 three. A chord is off by an eighth of its square times the greatest second
    // derivative, which is at an end.
    const glm::dvec2 one = 0.5 * (c - a), two = a - 2.5 * b + 2.0 * c - 0.5 * d;
    const glm::dvec2 three = 0.5 * (d - a) + 1.5 * (b - c);
    const double bend = std::max(glm::length(2.0 * two), glm::length(2.0 * two + 6.0 * three));
    const double parts = std::clamp(std::ceil(std::sqrt(bend / (8 * tolerance_m))), 1.0, 65'536.0);
    const auto place = [&](double t) { return b + t * (one + t * (two + t * three)); };
    const auto level = [&](double t) {
      return static_cast<float>(points[k].level_m + t * (points[k + 1].level_m - points[k].level_m));
    };
    for (double n = 0; n < parts; ++n, ++pieces) {
      const double from = n / parts, to = (n + 1) / parts;
      if (pieces >= out.size()) continue;
      out[pieces] = {place(from), n + 1 < parts ? place(to) : c, level(from), level(to)};
    }
  }
  return pieces;
}

void order_features(std::span<Feature> features) {
  for (const FeatureKind kind : {FeatureKind::hill, FeatureKind::mountain, FeatureKind::dunes})
    features = features.subspan(gather(features, kind));
}

void procedural_heights(const ProceduralSurface& surface, const SampleRect& rect,
                        std::span<std::uint32_t> near, std::span<float> out) {
  KARST_ASSERT(near.size() > 2 * surface.features.size() + surface.pieces.size());
  KARST_ASSERT(out.size() >= static_cast<std::size_t>(rect.columns) * static_cast<std::size_t>(rect.rows));
  const Octaves octaves(surface.noise);
  const auto amplitude = static_cast<float>(surface.noise.amplitude_m);
  const auto base = static_cast<float>(surface.noise.base_m);
  const auto place = [&](std::int64_t first, int n) {
    return static_cast<double>(first + n * rect.step) * rect.spacing_m;
  };
  const double reach = 0.75 * kBlock * static_cast<double>(rect.step) * rect.spacing_m;  // half of a diagonal
  for (int top = 0; top < rect.rows; top += kBlock) {
    for (int left = 0; left < rect.columns; left += kBlock) {
      const double half = 0.5 * (kBlock - 1) * static_cast<double>(rect.step) * rect.spacing_m;
      const glm::dvec2 middle(place(rect.first_x, left) + half, place(rect.first_z, top) + half);
      const Near in_block(surface, near, middle, reach);
      const std::span<const std::uint32_t> acts = in_block.all();
      for (int row = top; row < std::min(top + kBlock, rect.rows); ++row) {
        const double z = place(rect.first_z, row);
        for (int column = left; column < std::min(left + kBlock, rect.columns); column += simd::kLanes) {
          const auto x = [&](int lane) { return place(rect.first_x, column + lane); };
          const Places east{simd::Double2{x(0), x(1)}, simd::Double2{x(2), x(3)}};
          const Noisy at(octaves, surface.seed, east, Places{splat(z), splat(z)});
          Float4 height = base + amplitude * at.sum;
          for (std::size_t k = 0; k < acts.size(); ++k) {
            const Feature& feature = surface.features[acts[k]];
            if (feature.kind != FeatureKind::river) {
              height = with_feature(height, feature, at);
              continue;
            }
            const std::span<const std::uint32_t> pieces = acts.subspan(k + 2, acts[k + 1]);
            height = with_river(height, feature, surface.pieces, pieces, at);
            k += 1 + pieces.size();
          }
          height = height + 0.0f;  // no -0, which what adds nothing makes 0
          const auto lanes = static_cast<std::size_t>(std::min(simd::kLanes, rect.columns - column));
          float* to = &out[static_cast<std::size_t>(row) * static_cast<std::size_t>(rect.columns) +
                           static_cast<std::size_t>(column)];
          std::memcpy(to, &height, lanes * sizeof(float));
        }
      }
    }
  }
}

}  // namespace karst::core
