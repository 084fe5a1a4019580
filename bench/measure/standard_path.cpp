// SPDX-License-Identifier: MIT
#include "bench/measure/standard_path.h"

#include <algorithm>
#include <cmath>

#include "terrain/base/lattice.h"

namespace karst::bench {
using namespace core;
namespace {

constexpr double kTurn = 2.0 * 3.14159265358979323846;

// Parts of the world's smaller side on the ground.
constexpr double kLowRadius = 0.32;
constexpr double kObliqueRadius = 0.30, kObliqueTarget = 0.15;
constexpr double kHighRadius = 0.45, kHighHeight = 0.55;
constexpr double kTeleportSpread = 0.45;

constexpr double kLowClearance = 0.75;  // voxels above the ground
constexpr int kLowReach = 2;            // columns that count as ground around
constexpr int kLowSmooth = 4;           // frames before and after that the height is averaged over

// The oblique camera is this far ahead of its target on the loop, as the peers' is.
constexpr double kObliqueLead = 1.0;  // radians

struct Place {
  glm::dvec3 centre{0.0};  // of the box, voxels
  double side = 0;         // the smaller one of the ground
  double top = 0;          // highest point
};

Place place_of(const LatticeBox& box) {
  const glm::dvec3 low = glm::dvec3(box.min) / static_cast<double>(kStepsPerVoxel);
  const glm::dvec3 high = glm::dvec3(box.max) / static_cast<double>(kStepsPerVoxel);
  return {(low + high) * 0.5, std::min(high.x - low.x, high.z - low.z), high.y};
}

glm::dvec3 on_circle(glm::dvec3 centre, double radius, double angle, double y) {
  return {centre.x + radius * std::cos(angle), y, centre.z + radius * std::sin(angle)};
}

CameraSettings looking(glm::dvec3 eye, glm::dvec3 target) {
  CameraSettings camera;
  camera.position = eye;
  // Fails where the two coincide only, which rings of different sizes or heights do not.
  (void)look_at(eye, target, camera.yaw_deg, camera.pitch_deg);
  return camera;
}

// SplitMix64 (G. Steele and others, "Fast Splittable Pseudorandom Number Generators", 2014): the same places
// on every machine.
double next_random(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

std::vector<CameraSettings> low_path(const GroundHeights& ground, const Place& place, int frames) {
  std::vector<double> heights;
  for (int i = 0; i < frames; ++i) {
    const glm::dvec3 at = on_circle(place.centre, kLowRadius * place.side, kTurn * i / frames, 0);
    heights.push_back(ground.highest(at.x, at.z, kLowReach));
  }
  std::vector<CameraSettings> path;
  for (int i = 0; i < frames; ++i) {
    // Never below the clearance of its own place; the average takes the jerks out of the flight.
    double sum = 0;
    for (int k = -kLowSmooth; k <= kLowSmooth; ++k) {
      sum += heights[static_cast<std::size_t>((i + k + kLowSmooth * frames) % frames)];
    }
    const double y =
        std::max(sum / (2 * kLowSmooth + 1), heights[static_cast<std::size_t>(i)]) + kLowClearance;
    const double angle = kTurn * i / frames;
    const double radius = kLowRadius * place.side;
    // Ahead by a tenth of the loop, and a little down.
    path.push_back(looking(on_circle(place.centre, radius, angle, y),
                           on_circle(place.centre, radius, angle + kTurn / 10, y - 0.06 * place.side)));
  }
  return path;
}

std::vector<CameraSettings> ring_path(const Place& place, int frames, bool high) {
  std::vector<CameraSettings> path;
  for (int i = 0; i < frames; ++i) {
    const double angle = kTurn * i / frames;
    if (high) {
      path.push_back(looking(
          on_circle(place.centre, kHighRadius * place.side, angle, place.top + kHighHeight * place.side),
          place.centre));
    } else {
      path.push_back(looking(
          on_circle(place.centre, kObliqueRadius * place.side, angle, place.top + 0.015 * place.side),
          on_circle(place.centre, kObliqueTarget * place.side, angle + kObliqueLead, place.centre.y)));
    }
  }
  return path;
}

std::vector<CameraSettings> teleport_path(const GroundHeights& ground, const Place& place, int frames) {
  std::vector<CameraSettings> path;
  std::uint64_t state = 1;
  for (int i = 0; i < frames; ++i) {
    CameraSettings camera;
    const double x = place.centre.x + (next_random(state) * 2 - 1) * kTeleportSpread * place.side;
    const double z = place.centre.z + (next_random(state) * 2 - 1) * kTeleportSpread * place.side;
    // Low places are as frequent as high ones, octave by octave.
    const double height = 0.5 * std::exp2(next_random(state) * std::log2(std::max(place.side, 2.0) * 0.5));
    camera.position = {x, ground.highest(x, z, kLowReach) + height, z};
    camera.yaw_deg = next_random(state) * 360 - 180;
    camera.pitch_deg = next_random(state) * 40 - 35;
    path.push_back(camera);
  }
  return path;
}

}  // namespace

GroundHeights::GroundHeights(glm::ivec2 extent) {
  const auto columns = [](int voxels, int shift) { return ((std::max(voxels, 1) - 1) >> shift) + 1; };
  while (std::int64_t{columns(extent.x, shift_)} * columns(extent.y, shift_) > kMostColumns) ++shift_;
  extent_ = {columns(extent.x, shift_), columns(extent.y, shift_)};
  heights_.resize(static_cast<std::size_t>(extent_.x) * static_cast<std::size_t>(extent_.y));
}

void GroundHeights::add(const LatticeBox& box) {
  const auto columns = [this](std::int32_t low, std::int32_t high, int extent) {
    return glm::ivec2(std::clamp(low / kStepsPerVoxel >> shift_, 0, extent - 1),
                      std::clamp(high / kStepsPerVoxel >> shift_, 0, extent - 1));
  };
  const glm::ivec2 x = columns(box.min.x, box.max.x, extent_.x);
  const glm::ivec2 z = columns(box.min.z, box.max.z, extent_.y);
  const float top = static_cast<float>(box.max.y) / static_cast<float>(kStepsPerVoxel);
  for (int j = z.x; j <= z.y; ++j) {
    for (int i = x.x; i <= x.y; ++i) {
      float& height = heights_[static_cast<std::size_t>(j * extent_.x + i)];
      height = std::max(height, top);
    }
  }
}

double GroundHeights::highest(double x, double z, int reach) const {
  const auto column = [this](double at, int way) {
    return (static_cast<int>(std::floor(at)) + way) >> shift_;
  };
  float best = 0;
  for (int j = std::max(column(z, -reach), 0); j <= std::min(column(z, reach), extent_.y - 1); ++j) {
    for (int i = std::max(column(x, -reach), 0); i <= std::min(column(x, reach), extent_.x - 1); ++i) {
      best = std::max(best, heights_[static_cast<std::size_t>(j * extent_.x + i)]);
    }
  }
  return double{best};
}

std::vector<CameraSettings> make_standard_path(std::string_view name, const GroundHeights& ground,
                                               const LatticeBox& box, int frames) {
  const Place place = place_of(box);
  if (name == "low") return low_path(ground, place, frames);
  if (name == "teleport") return teleport_path(ground, place, frames);
  return ring_path(place, frames, name == "high");
}

}  // namespace karst::bench
