// SPDX-License-Identifier: MIT
#include "terrain/ground/ground.h"

#include <cmath>

namespace karst::core {

std::int64_t sample_place(double steps, std::int64_t sample) {
  return static_cast<std::int64_t>(
      std::floor(steps * static_cast<double>(sample) * (1.0 / kVertexStep) + 0.5));
}

bool neighbour_of(const GroundInfo& info, NodeKey key, int east, int south, NodeKey& neighbour) {
  if (!info.is_cube()) {
    neighbour = {key.size, key.x + east, key.z + south};
    const std::int32_t last = last_column(info, key.size);
    if (info.closes()) neighbour.x = neighbour.x < 0 ? last : neighbour.x > last ? 0 : neighbour.x;
    return node_exists(info, neighbour);
  }
  const int cells = info.top_size() - key.size;
  const std::int64_t side = std::int64_t{1} << cells;  // nodes
  int face = face_of(info, key);
  int x = 0, z = 0;
  cube_cell(face, x, z);
  // Middles of nodes, in half nodes from the face's.
  std::int64_t u = 2 * (key.x + east - x * side) + 1 - side;
  std::int64_t v = 2 * (key.z + south - z * side) + 1 - side;
  if (!fold_cube(side, face, u, v)) return false;
  cube_cell(face, x, z);
  neighbour = {key.size, static_cast<std::int32_t>(x * side + (u - 1 + side) / 2),
               static_cast<std::int32_t>(z * side + (v - 1 + side) / 2)};
  return true;
}

NodePlaces::NodePlaces(const GroundInfo& info, NodeKey node) : info_(info), face_(face_of(info, node)) {
  for (int n = -kMostRim; n <= kNodeQuads + kMostRim; ++n) {
    for (int axis = 0; axis < 2; ++axis) {
      const std::int64_t first = axis == 0 ? node.x : node.z;
      const std::int64_t vertex = first * kNodeQuads + n;
      const std::int64_t sample = axis == 0 ? sample_around(info, node.size, vertex)
                                            : sample_of(info.samples[axis], node.size, vertex);
      if (info.basis.is_curved()) {
        axes_[axis][index(n)] = axis_place(info.basis, axis, face_, static_cast<double>(sample));
      } else {
        plane_[axis][index(n)] = sample_place(info, axis, sample);
      }
    }
  }
}

glm::i64vec3 NodePlaces::curved(int i, int k, std::int32_t height) const {
  return vertex_place(info_.basis, face_, axes_[0][index(i)], axes_[1][index(k)], height);
}

glm::dvec3 NodePlaces::up(int i, int k) const {
  return up_at(info_.basis, face_, axes_[0][index(i)], axes_[1][index(k)]);
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
