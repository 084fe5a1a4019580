// SPDX-License-Identifier: MIT
#include "terrain/edit/regions/region_growth.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "terrain/edit/reached_patches.h"
#include "terrain/edit/regions/region_heights.h"

namespace karst::core {
namespace {

// Thresholds grow by steps of so many voxels, so that not each edit changes them.
constexpr double kStepVoxels = 2;

double length(const glm::dvec3& v) {
  return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

double step_up(double voxels) {
  return std::ceil(voxels / kStepVoxels) * kStepVoxels;
}

// To the next voxel of the other kind along a line, or `best` where that is no further.
double way_along(const Octree& octree, glm::ivec3 extent, glm::ivec3 from, bool filled, glm::ivec3 way,
                 double best) {
  const double step = length(glm::dvec3(way));
  glm::ivec3 at = from;
  for (int steps = 1; steps * step < best; ++steps) {
    at += way;
    for (int axis = 0; axis < 3; ++axis) {
      if (at[axis] < 0) return best;
      // Above all there is air.
      if (at[axis] >= extent[axis]) return axis == 1 && filled ? steps * step : best;
    }
    if (octree.filled(at) != filled) return steps * step;
  }
  return best;
}

constexpr glm::ivec3 kWays[] = {{0, -1, 0}, {0, 1, 0}, {1, 0, 0},  {-1, 0, 0}, {0, 0, 1},
                                {0, 0, -1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, 1}, {-1, 0, -1}};

}  // namespace

// Samples of the ground as places in the region, voxels from its corner.
struct FindRegionGrowth::Ground {
  EditGround& edits;
  const GroundRegion& region;
  double spacing;  // voxels

  Ground(EditGround& ground, std::size_t n)
      : edits(ground), region(ground.info().regions()[n]), spacing(ground.info().steps[0] / kStepsPerVoxel) {}

  std::int64_t first(int axis) const { return std::int64_t{region.nodes.low[axis]} * kNodeQuads; }
  // Which quad of the region a place is in.
  std::int64_t quad(int axis, double voxels) const {
    const std::int64_t quads = std::int64_t{region.nodes.high[axis] - region.nodes.low[axis]} * kNodeQuads;
    return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor((voxels - 0.5) / spacing)), 0,
                                    quads - 1);
  }
  // Heights of a quad's corners: north-west, north-east, south-west, south-east.
  Status corners(std::int64_t i, std::int64_t k, double (&out)[4]) const {
    for (int n = 0; n < 4; ++n) {
      std::int32_t height = 0;
      const Status status = edits.height(first(0) + i + n % 2, first(1) + k + n / 2, height);
      if (!status.ok()) return status;
      out[n] = double{kVertexStep} * height / kStepsPerVoxel - region.corner.y;
    }
    return {};
  }
  // As nodes of size 0 have it.
  Status at(double x, double z, double& height) const {
    const std::int64_t i = quad(0, x), k = quad(1, z);
    double h[4] = {};
    if (const Status status = corners(i, k, h); !status.ok()) return status;
    const double u = (x - 0.5) / spacing - static_cast<double>(i);
    const double v = (z - 0.5) / spacing - static_cast<double>(k);
    height = height_in_quad(h, u, v, ((first(0) + i + first(1) + k) & 1) != 0);
    return {};
  }
  // sqrt(1 + s^2), s being the steepest slope between two places.
  Status stretch(glm::dvec2 low, glm::dvec2 high, double& out) const {
    double most = 0;
    for (std::int64_t k = quad(1, low.y); k <= quad(1, high.y); ++k) {
      for (std::int64_t i = quad(0, low.x); i <= quad(0, high.x); ++i) {
        double h[4] = {};
        if (const Status status = corners(i, k, h); !status.ok()) return status;
        const double east = std::max(std::abs(h[1] - h[0]), std::abs(h[3] - h[2]));
        const double south = std::max(std::abs(h[2] - h[0]), std::abs(h[3] - h[1]));
        most = std::max(most, (east * east + south * south) / (spacing * spacing));
      }
    }
    out = std::sqrt(1 + most);
    return {};
  }
};

// L of a column, or less than `enough` where that is so.
double FindRegionGrowth::column_way(int x, int z, double height, double enough) const {
  const WorldPart& part = world->parts()[region];
  const Octree& octree = *part.octree;
  const glm::ivec3 from(x, std::clamp(static_cast<int>(std::floor(height)), 0, part.extent.y - 1), z);
  const bool filled = octree.filled(from);
  double way = length(glm::dvec3(part.extent));
  for (const glm::ivec3 along : kWays) {
    if (way <= enough) break;
    way = way_along(octree, part.extent, from, filled, along, way);
  }
  // And what rises above it.
  const int top = std::min(part.extent.y - 1, box.max.y / kStepsPerVoxel + 1);
  for (int y = top; y > from.y + static_cast<int>(enough); --y) {
    if (octree.filled({x, y, z})) return std::max(way, y + 1 - height);
  }
  return way;
}

// How far surface and voxels of columns are apart, but for slopes: what patches reach out of their volumes,
// and half a voxel.
double FindRegionGrowth::surface_off(glm::dvec2 low, glm::dvec2 high) const {
  const WorldPart& part = world->parts()[region];
  const auto reaches = [&](const LatticeBox& other) {
    return other.max.x >= low.x * kStepsPerVoxel && other.min.x <= high.x * kStepsPerVoxel &&
           other.max.z >= low.y * kStepsPerVoxel && other.min.z <= high.y * kStepsPerVoxel;
  };
  double off = 0;
  const auto visit = [&](PatchId patch) {
    const PatchBounds& bounds = part.bounds[patch];
    for (int axis = 0; axis < 3; ++axis) {
      const int out = std::max(std::abs(int{bounds.min[axis]}), std::abs(int{bounds.max[axis]}));
      off = std::max(off, static_cast<double>(out) / kStepsPerVoxel - 0.5);
    }
  };
  ReachedPatches{*part.tree, part.surface, part.bounds, reaches, visit}.run();
  return off;
}

Status FindRegionGrowth::measure(RegionGrowth& growth) const {
  const WorldPart& part = world->parts()[region];
  const Ground heights(*ground, region);
  const double wide = length(glm::dvec3(part.extent));
  const double before = std::min(ground->error_before(region) / kStepsPerVoxel, wide);
  const glm::dvec3 low = glm::dvec3(box.min) / double{kStepsPerVoxel};
  const glm::dvec3 high = glm::dvec3(box.max) / double{kStepsPerVoxel};
  double stretch = 1;
  if (const Status status =
          heights.stretch({low.x - before, low.z - before}, {high.x + before, high.z + before}, stretch);
      !status.ok())
    return status;
  growth.stretch = std::max(growth.stretch, stretch);
  const double around = std::max(growth.way, 1.0);
  // And places of a column.
  const double slack = 1 + 0.71 * growth.stretch +
                       surface_off({low.x - around, low.z - around}, {high.x + around, high.z + around});
  const double enough = growth.way - slack;
  double most = 0;
  const auto column = [](double at, int last) {
    return std::clamp(static_cast<int>(std::floor(at)), 0, last);
  };
  for (int z = column(low.z - around, part.extent.z - 1); z <= column(high.z + around, part.extent.z - 1);
       ++z) {
    for (int x = column(low.x - around, part.extent.x - 1); x <= column(high.x + around, part.extent.x - 1);
         ++x) {
      double height = 0;
      if (const Status status = heights.at(x + 0.5, z + 0.5, height); !status.ok()) return status;
      most = std::max(most, column_way(x, z, height, std::max(enough, most)));
    }
  }
  growth.way = std::max(growth.way, step_up(most + slack));
  growth.error = std::max(growth.error, (growth.way + (growth.stretch - 1) * before) * kStepsPerVoxel);
  return {};
}

bool FindRegionGrowth::step(ColumnsOfRegion& columns) const {
  const WorldPart& part = world->parts()[region];
  const Ground heights(*ground, region);
  const FindRegionGrowth every{world, ground, region, {glm::ivec3(0), part.extent * kStepsPerVoxel}};
  double stretch = 1;
  bool known = true;
  for (int x = 0; x < part.extent.x && known; ++x) {
    double height = 0;
    known = heights.at(x + 0.5, columns.row + 0.5, height).ok();
    if (known) columns.most = std::max(columns.most, every.column_way(x, columns.row, height, columns.most));
  }
  known = known && heights.stretch({0, columns.row}, {part.extent.x, columns.row + 1}, stretch).ok();
  if (!known) columns.most = std::numeric_limits<double>::infinity();
  columns.stretch = std::max(columns.stretch, stretch);
  return ++columns.row == part.extent.z;
}

RegionGrowth FindRegionGrowth::run(const ColumnsOfRegion& columns) const {
  const WorldPart& part = world->parts()[region];
  RegionGrowth growth = ground->growth(region);
  growth.now = now(growth);
  const double off = surface_off({0, 0}, {part.extent.x, part.extent.z});
  growth.now.error =
      std::min(growth.now.error, step_up(columns.most + 1 + 0.71 * columns.stretch + off) * kStepsPerVoxel);
  return growth;
}

RegionMeasure FindRegionGrowth::now(const RegionGrowth& growth) const {
  if (!growth.exists()) return {};
  const WorldPart& part = world->parts()[region];
  std::int32_t ground_low = 0, ground_high = 0;
  ground->heights_beneath(region, ground_low, ground_high);
  const std::int64_t corner = std::int64_t{part.corner.y} * kStepsPerVoxel;
  const glm::ivec3 extent = part.extent * kStepsPerVoxel;
  glm::dvec3 low(0, static_cast<double>(std::int64_t{kVertexStep} * ground_low - corner), 0);
  glm::dvec3 high(extent.x, static_cast<double>(std::int64_t{kVertexStep} * ground_high - corner), extent.z);
  if (part.tree->rows() > 0) {
    const LatticeBox surface = part.tree->around_all(glm::ivec3(0));
    low = glm::min(low, glm::dvec3(surface.min));
    high = glm::max(high, glm::dvec3(surface.max));
  }
  RegionMeasure now;
  now.reach = step_up((length(high - low) / kStepsPerVoxel) + 2) * kStepsPerVoxel;
  now.error = std::min(ground->error_before(region) + growth.error, now.reach);
  return now;
}

RegionGrowth FindRegionGrowth::run() const {
  RegionGrowth growth = ground->growth(region);
  if (!measure(growth).ok()) {
    growth.way = std::max(growth.way, kStepVoxels);
    growth.error = std::numeric_limits<double>::infinity();
  }
  growth.now = now(growth);
  return growth;
}

}  // namespace karst::core
