// SPDX-License-Identifier: MIT
#include "bake/samples/sample_ground.h"

#include "bake/base/parallel.h"
#include "bake/samples/sample_solid.h"
#include "terrain/ground/ground.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace karst::bake {
using namespace core;
namespace {

constexpr double kSamplesAcross = 2048;  // of the sample's own spacing, half a voxel of its own
constexpr double kRoundingNodes = 1e-6;
// The border is level over this part of the way from the middle.
constexpr double kLevelFrom = 0.97;
// Grain of the sample's surface, by the distance from the middle: all of it, none of it.
constexpr double kGrainM = 500, kNoGrainM = 1600;

double height_m(const SampleShape& shape, double x, double z, double half_m) {
  const double away = std::sqrt(x * x + z * z);
  const SampleLand& land = shape.land;
  const double lies = 1 - smooth_step((away - land.fades_from_m) / (land.fades_to_m - land.fades_from_m));
  double height = land.plain_m;
  if (lies > 0) height += lies * (shape.ground_m(x, z) - land.plain_m);
  const double grain = lies * (1 - smooth_step((away - kGrainM) / (kNoGrainM - kGrainM)));
  if (grain > 0) height += grain * shape.grain.relief_m({x, height, z});
  const double inside = 1 - smooth_step((away / half_m - 0.6) / (kLevelFrom - 0.6));
  if (inside > 0) height += inside * shape.far_m(x, z, away);
  return std::max(height, land.plain_m);
}

}  // namespace

Error SampleGrid::around(const Sample& sample, double voxel_m, SampleGrid& grid) {
  WorldGrid voxels;
  if (Error error = WorldGrid::around(sample.content_m, voxel_m, voxels); !error.ok()) return error;
  const double own_m = 0.5 * sample.voxel_m;
  grid = {};
  grid.node_voxels_log2 =
      std::clamp(static_cast<int>(std::lround(std::log2(kNodeQuads * own_m / voxel_m))), 0, kMostLatticeSize);
  const double node_m = std::ldexp(voxel_m, grid.node_voxels_log2);
  grid.spacing_m = node_m / kNodeQuads;
  for (int axis = 0; axis < 2; ++axis) {
    const double wide_m = sample.content_m.max[2 * axis] - sample.content_m.min[2 * axis];
    grid.nodes[axis] = static_cast<int>(std::ceil(wide_m / node_m - kRoundingNodes));
    const double around_m = 0.5 * (kSamplesAcross * own_m - wide_m);
    grid.first_node[axis] = std::max(static_cast<int>(std::lround(around_m / node_m)), 1);
    grid.samples[axis] = kNodeQuads * (grid.nodes[axis] + 2 * grid.first_node[axis]) + 1;
    if ((grid.nodes[axis] << grid.node_voxels_log2) + 1 > (1 << kMaxDepth)) {
      // A node less than all of its content: what is cut off is less than a node.
      grid.nodes[axis] -= 1;
      grid.samples[axis] -= kNodeQuads;
    }
  }
  return {};
}

Box SampleGrid::rectangle_m() const {
  const double node_m = kNodeQuads * spacing_m;
  const glm::dvec3 half(0.5 * node_m * nodes[0], 0, 0.5 * node_m * nodes[1]);
  return {-half, half};
}

Elevation sample_elevation(const Sample& sample, const SampleGrid& grid, int threads) {
  Elevation made;
  made.width = grid.samples[0];
  made.height = grid.samples[1];
  made.spacing_x_m = made.spacing_z_m = grid.spacing_m;
  made.source = "sample";
  const auto wide = static_cast<std::size_t>(made.width), rows = static_cast<std::size_t>(made.height);
  made.heights_m.resize(wide * rows);
  made.valid.assign(wide * rows, 1);
  const double half_m = 0.5 * grid.spacing_m * (std::min(made.width, made.height) - 1);
  parallel_chunks(rows, 4, threads, [&](std::size_t first, std::size_t last, int) {
    for (std::size_t row = first; row < last; ++row) {
      const double z = (static_cast<double>(row) - 0.5 * (made.height - 1)) * grid.spacing_m;
      for (std::size_t column = 0; column < wide; ++column) {
        const double x = (static_cast<double>(column) - 0.5 * (made.width - 1)) * grid.spacing_m;
        const double height = height_m(*sample.shape, x, z, half_m);
        made.heights_m[row * wide + column] =
            static_cast<float>(std::round(height / kSampleUnitM) * kSampleUnitM);
      }
    }
  });
  return made;
}

double SampleInGround::value_m(glm::dvec3 p) const {
  const double side_m = std::min({p.x - rectangle_m_.min.x, rectangle_m_.max.x - p.x,
                                  p.z - rectangle_m_.min.z, rectangle_m_.max.z - p.z});
  const double share = smooth_step(side_m * per_width_);
  if (share >= 1) return sample_.value_m(p);
  const double below = ground_.at(p.x, p.z) - p.y;
  if (share <= 0) return below;
  return below + share * (sample_.value_m(p) - below);
}

// Mountains and mesas: what stands far away.
double mesas(double x, double z, double width_m, std::uint32_t seed) {
  const glm::dvec2 p = glm::dvec2(x, z) / width_m;
  const double rock = fbm(p, 3, seed) + 0.12 * noise(p * 7.0, seed + 7);
  // A foot of fallen rock, a wall, a bench and another wall.
  return 0.22 * smooth_step((rock - 0.16) / 0.2) + 0.45 * smooth_step((rock - 0.33) / 0.05) +
         0.33 * smooth_step((rock - 0.46) / 0.06);
}

double mountains(double x, double z, double width_m, std::uint32_t seed) {
  const glm::dvec2 p = glm::dvec2(x, z) / width_m;
  const glm::dvec2 moved = p + 0.35 * glm::dvec2(fbm(p * 1.3, 2, seed + 50), fbm(p * 1.3, 2, seed + 60));
  double sum = 0, strength = 0.55, rough = 1;
  glm::dvec2 at = moved;
  for (std::uint32_t k = 0; k < 5; ++k) {
    const double n = noise(at, seed + k);
    const double ridge = 1 - std::sqrt(n * n + 0.004);
    const double part = ridge * ridge * rough;
    sum += strength * part;
    // Valleys are smooth: what is added is less where the coarser part is low.
    rough = std::clamp(part * 1.2, 0.0, 1.0);
    at = at * 2.03;
    strength *= 0.5;
  }
  return std::max(sum - 0.15, 0.0);
}

}  // namespace karst::bake
