// SPDX-License-Identifier: MIT
#include "terrain/ground/ground.h"

#include <cmath>

namespace karst::core {

std::int64_t sample_place(double steps, std::int64_t sample) {
  return static_cast<std::int64_t>(
      std::floor(steps * static_cast<double>(sample) * (1.0 / kVertexStep) + 0.5));
}

bool place_region(GroundInfo& info, std::int32_t extent_x, std::int32_t extent_z, std::int32_t x,
                  std::int32_t z) {
  info.lattice_size = 0;
  info.corner[0] = info.corner[1] = 0;
  info.region = {};
  info.rim_edges = 0;
  int log2 = 0;
  if (info.steps[0] != info.steps[1] || std::frexp(info.steps[0], &log2) != 0.5) return false;
  const int g = log2 - 1 - (kLatticeBits - 2);
  if (g < 0 || g > kMostLatticeSize || info.top_size() + g > kMostSize) return false;
  const std::int32_t first[2] = {x, z};
  const std::int32_t voxels[2] = {extent_x - 1, extent_z - 1};  // between the outermost centres
  NodeRect rect;
  for (int axis = 0; axis < 2; ++axis) {
    if (voxels[axis] <= 0 || first[axis] < 1 || voxels[axis] % (1 << g) != 0) return false;
    const std::int64_t nodes = voxels[axis] >> g;
    if ((first[axis] + nodes) * kNodeQuads >= info.samples[axis] - 1) return false;
    rect.low[axis] = first[axis];
    rect.high[axis] = static_cast<std::int32_t>(first[axis] + nodes);
  }
  info.lattice_size = g;
  info.region = rect;
  for (int axis = 0; axis < 2; ++axis) {
    info.corner[axis] = kStepsPerHalfVoxel / kVertexStep -
                        sample_place(info.steps[axis], std::int64_t{first[axis]} * kNodeQuads);
  }
  return true;
}

}  // namespace karst::core
