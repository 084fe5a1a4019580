// SPDX-License-Identifier: MIT
#include "app/motion/ground.h"

#include <algorithm>

#include "terrain/draw/index_batches.h"

namespace karst::app {
using namespace core;
namespace {

// The triangle at (x, z), none where it is not above or below that point, or stands upright.
std::optional<Ground::Surface> surface_at(const glm::dvec3 (&corner)[3], double x, double z) {
  const auto side = [&](int a, int b) {
    return (corner[b].x - corner[a].x) * (z - corner[a].z) - (corner[b].z - corner[a].z) * (x - corner[a].x);
  };
  const double w0 = side(1, 2);
  const double w1 = side(2, 0);
  const double w2 = side(0, 1);
  const double area = w0 + w1 + w2;
  const bool inside = (w0 >= 0 && w1 >= 0 && w2 >= 0) || (w0 <= 0 && w1 <= 0 && w2 <= 0);
  if (!inside || area == 0) return std::nullopt;
  // Fronts are counter-clockwise; seen from above, x to the right and z down, that is a negative area.
  return Ground::Surface{(w0 * corner[0].y + w1 * corner[1].y + w2 * corner[2].y) / area, area < 0};
}

}  // namespace

Ground::Ground(const World& world, Residency& residency)
    : world_(world),
      residency_(residency),
      vertices_(static_cast<std::size_t>(patch_vertices(world.info().level))) {}

std::optional<double> Ground::below(const glm::dvec3& place, double step, int level) {
  std::optional<double> best;
  for_each_at(place, level, [&](const Surface& surface) {
    if (surface.height <= place.y + step && (!best || surface.height > *best)) best = surface.height;
  });
  return best;
}

std::optional<Ground::Surface> Ground::above(const glm::dvec3& place) {
  std::optional<Surface> best;
  for_each_at(place, kFullLevel, [&](const Surface& surface) {
    if (surface.height > place.y && (!best || surface.height < best->height)) best = surface;
  });
  return best;
}

template <class Visit>
void Ground::for_each_at(const glm::dvec3& place, int level, Visit visit) {
  level = std::min(level, world_.info().level);
  const core::Surface patches = world_.surface();
  const std::span<const PatchBounds> bounds = world_.bounds();
  const glm::dvec3 steps = place * static_cast<double>(kStepsPerVoxel);
  for (PatchId patch = 0; patch < world_.patch_count(); ++patch) {
    const Volume& volume = patches.volume_of(patch);
    const PatchBounds& box = bounds[patch];
    const auto inside = [&](int axis, double at) {
      const double origin = static_cast<double>(volume.corner[axis]) * kStepsPerVoxel;
      return at >= origin + box.min[axis] && at <= origin + box.max[axis];
    };
    if (!inside(0, steps.x) || !inside(2, steps.z)) continue;
    if (!residency_.generate(patch, level, level, vertices_).ok()) continue;
    const auto vertex = [&](std::uint16_t index) {
      const GpuVertex& v = vertices_[index];
      const glm::dvec3 from_origin{v.position[0], v.position[1], v.position[2]};
      return glm::dvec3(volume.corner[0], volume.corner[1], volume.corner[2]) +
             from_origin / static_cast<double>(kStepsPerVoxel);
    };
    IndexRange ranges[kMaxIndexRanges];
    const int count = index_ranges(level, 0, 0, ranges);
    for (int r = 0; r < count; ++r) {
      const auto indices = world_.index_table().subspan(ranges[r].first, ranges[r].count);
      for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
        const glm::dvec3 corner[3] = {vertex(indices[i]), vertex(indices[i + 1]), vertex(indices[i + 2])};
        if (const std::optional<Surface> at = surface_at(corner, place.x, place.z)) visit(*at);
      }
    }
  }
}

}  // namespace karst::app
