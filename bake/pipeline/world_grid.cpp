// SPDX-License-Identifier: MIT
#include "bake/samples/solid.h"

#include "terrain/base/lattice.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace karst::bake {
using namespace core;
namespace {

// A side that is a whole number of voxels but for rounding counts as whole.
constexpr double kRoundingVoxels = 1e-6;
constexpr double kMostVoxels = 1 << kMaxDepth;

// text: "x" or "y".
Error too_many(const char* axis, double voxels, double voxel_m) {
  const double fits = voxel_m * voxels / (kMostVoxels - 2);
  return "--voxel: voxels of " + std::to_string(voxel_m) + " m are " +
         std::to_string(static_cast<long long>(std::min(voxels, 1e15))) + " along " + axis +
         ", and the most is 512; try --voxel " +
         std::to_string(static_cast<long long>(std::ceil(fits * 1.02)));
}

}  // namespace

Error WorldGrid::around(const Box& content_m, double voxel_m, WorldGrid& grid) {
  const glm::dvec3 size = (content_m.max - content_m.min) / voxel_m;
  const double bottom = std::floor(content_m.min.y / voxel_m + kRoundingVoxels);
  const double top = std::ceil(content_m.max.y / voxel_m - kRoundingVoxels);
  if (!(std::floor(size.x + kRoundingVoxels) + 1 <= kMostVoxels)) return too_many("x", size.x, voxel_m);
  if (!(std::floor(size.z + kRoundingVoxels) + 1 <= kMostVoxels)) return too_many("z", size.z, voxel_m);
  const double layers = top - bottom + kLayersBelow + 1;
  if (!(layers <= kMostVoxels - 1)) return too_many("y", layers, voxel_m);

  grid = {};
  grid.voxel_m = voxel_m;
  const double x = std::floor(size.x + kRoundingVoxels), z = std::floor(size.z + kRoundingVoxels);
  if (x < 1 || z < 1) return "--voxel: a voxel of " + std::to_string(voxel_m) + " m is wider than the world";
  grid.extent = {static_cast<int>(x) + 1, static_cast<int>(layers), static_cast<int>(z) + 1};
  const glm::dvec3 middle = 0.5 * (content_m.min + content_m.max);
  grid.origin_m = {middle.x - 0.5 * voxel_m * grid.extent.x, voxel_m * (bottom - kLayersBelow),
                   middle.z - 0.5 * voxel_m * grid.extent.z};
  grid.depth = 1;
  while ((1 << grid.depth) < std::max({grid.extent.x, grid.extent.z, grid.extent.y + 1})) ++grid.depth;
  return {};
}

}  // namespace karst::bake
