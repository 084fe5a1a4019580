// SPDX-License-Identifier: MIT
#include "terrain/ground/ground.h"

#include <algorithm>
#include <cmath>

#include "terrain/patch/heights.h"

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

namespace {

// A rim leaves the voxels that it lies between by what displacement reaches, and a voxel.
constexpr std::int32_t kBeltVoxels = kMaxHeight / kStepsPerVoxel + 1;

// Whether a node of size 0 lies between two rectangles, along an axis.
bool are_apart(const NodeRect& a, const NodeRect& b) {
  for (int axis = 0; axis < 2; ++axis) {
    if (a.high[axis] < b.low[axis] || b.high[axis] < a.low[axis]) return true;
  }
  return false;
}

bool find_nodes(const GroundInfo& info, int g, GroundRegion& region) {
  for (int axis = 0; axis < 2; ++axis) {
    const std::int32_t voxels = region.extent[2 * axis] - 1;  // between the outermost centres
    if (voxels <= 0 || region.nodes.low[axis] < 1 || voxels % (1 << g) != 0) return false;
    const std::int64_t high = std::int64_t{region.nodes.low[axis]} + (voxels >> g);
    if (high * kNodeQuads >= info.samples[axis] - 1) return false;
    region.nodes.high[axis] = static_cast<std::int32_t>(high);
  }
  const std::int32_t least = info.can_be_dug ? -kMostRegionHeight : 0;
  return region.corner.y >= least && region.corner.y <= kMostRegionHeight;
}

bool place_all(GroundInfo& info) {
  int log2 = 0;
  if (info.steps[0] != info.steps[1] || std::frexp(info.steps[0], &log2) != 0.5) return false;
  const int g = log2 - 1 - (kLatticeBits - 2);
  if (g < 0 || g > kMostLatticeSize || info.top_size() + g > kMostSize) return false;
  const auto regions = std::span(info.region_list).first(static_cast<std::size_t>(info.region_count));
  std::int32_t first[2] = {};
  if (!info.can_be_dug) std::copy_n(regions[0].nodes.low, 2, first);
  for (std::size_t n = 0; n < regions.size(); ++n) {
    if (!find_nodes(info, g, regions[n])) return false;
    for (std::size_t other = 0; other < n; ++other) {
      if (!are_apart(regions[n].nodes, regions[other].nodes)) return false;
    }
    for (int axis = 0; axis < 2 && !info.can_be_dug; ++axis)
      first[axis] = std::min(first[axis], regions[n].nodes.low[axis]);
  }
  for (GroundRegion& region : regions) {
    for (int axis = 0; axis < 2; ++axis)
      region.corner[2 * axis] = (region.nodes.low[axis] - first[axis]) * (1 << g);
    region.belt_low = std::int64_t{region.corner.y - kBeltVoxels} * kStepsPerVoxel;
    region.belt_high = std::int64_t{region.corner.y + region.extent.y + kBeltVoxels} * kStepsPerVoxel;
  }
  info.lattice_size = g;
  for (int axis = 0; axis < 2; ++axis) {
    info.corner[axis] = kStepsPerHalfVoxel / kVertexStep -
                        sample_place(info.steps[axis], std::int64_t{first[axis]} * kNodeQuads);
  }
  return true;
}

}  // namespace

bool place_regions(GroundInfo& info) {
  info.lattice_size = 0;
  info.corner[0] = info.corner[1] = 0;
  const bool any = info.has_voxel_lattice() && info.region_count >= 0 &&
                   info.region_count <= static_cast<std::int32_t>(kMostRegions);
  if (any && place_all(info)) return true;
  info.lattice_size = 0;
  info.region_count = 0;
  info.can_be_dug = false;
  return false;
}

bool place_region(GroundInfo& info, std::int32_t extent_x, std::int32_t extent_z, std::int32_t x,
                  std::int32_t z) {
  info.region_count = 1;
  GroundRegion& region = info.region_list[0] = {};
  region.nodes.low[0] = x;
  region.nodes.low[1] = z;
  region.extent = {extent_x, 1, extent_z};
  return place_regions(info);
}

}  // namespace karst::core
