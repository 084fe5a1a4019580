// SPDX-License-Identifier: MIT
// The ground: a height field of any size as a quadtree of nodes (design 4.12).
//
// A *node* is a square of kNodeQuads x kNodeQuads quads, 25 vertices, one page. A node of *size* s has
// vertices at every 2^s-th sample; size 0 has all of them. A *family* is the four children of one node; they
// are drawn together or not at all.
//
// Lattice. The ground's space is measured in lattice steps, kStepsPerVoxel a voxel; here a voxel is only a
// unit. Sample (i, k) of size 0 lies at x = steps[0] i, y = kVertexStep times its height, z = steps[1] k,
// rounded to kVertexStep. Samples beyond the last one lie where the last one does: quads there have no area,
// so that a ground may have any number of samples.
//
// A vertex of size s lies on a lattice of 2^s times as coarse steps: place_at_size() of its place at size
// 0, which halves and rounds once a size. So two sizes agree on where the coarser one's vertices are,
// whichever tile they were read from.
#pragma once

#include <cstdint>

#include "terrain/base/lattice.h"

namespace karst::core {

inline constexpr int kNodeQuads = 4;
inline constexpr int kNodeSide = kNodeQuads + 1;             // vertices
inline constexpr int kNodeVertices = kNodeSide * kNodeSide;  // 25
// In its page there are four more, below its corners, for the walls where the ground ends.
inline constexpr int kNodePageVertices = kNodeVertices + 4;
inline constexpr int kNodeLevel = 2;  // of the index batches that draw a node
inline constexpr int kMostSize = 20;  // 2^22 samples a side
inline constexpr std::int64_t kMostSamples = (std::int64_t{kNodeQuads} << kMostSize) + 1;  // a side
inline constexpr double kMostSampleSteps = 2048;  // between samples: a quarter of a voxel
inline constexpr double kLeastSampleSteps = 2;
// Heights are integers of kVertexStep steps, so that a height of the file is a vertex's place without
// rounding.
inline constexpr std::int32_t kMostHeight = 1 << 26;  // and its negative; 2^14 voxels

struct GroundInfo {
  std::int64_t samples[2] = {};  // along x (east) and z (south), 2..kMostSamples; 0: there is no ground
  double steps[2] = {};          // lattice steps from one to the next, kLeastSampleSteps..kMostSampleSteps
  std::int32_t low = 0;          // heights of all samples, +-kMostHeight
  std::int32_t high = 0;

  bool exists() const { return samples[0] > 0; }
  // Of the one root: the least size at which one node covers everything.
  int top_size() const {
    const std::int64_t most = (samples[0] > samples[1] ? samples[0] : samples[1]) - 1;
    int size = 0;
    while ((std::int64_t{kNodeQuads} << size) < most) ++size;
    return size;
  }
};

// A node, or a vertex of the grid of a size where that is said. x to the east, z to the south.
struct NodeKey {
  std::int32_t size = 0;
  std::int32_t x = 0;
  std::int32_t z = 0;

  NodeKey parent() const { return {size + 1, x >> 1, z >> 1}; }
  // quadrant: bit 0 east, bit 1 south.
  NodeKey child(int quadrant) const { return {size - 1, 2 * x + (quadrant & 1), 2 * z + (quadrant >> 1)}; }
  int quadrant() const { return (x & 1) | (z & 1) << 1; }
  friend bool operator==(const NodeKey&, const NodeKey&) = default;
};

// Whether any of the node has area.
inline bool node_exists(const GroundInfo& info, NodeKey key) {
  return key.x >= 0 && key.z >= 0 && (std::int64_t{key.x} * kNodeQuads << key.size) < info.samples[0] - 1 &&
         (std::int64_t{key.z} * kNodeQuads << key.size) < info.samples[1] - 1;
}

// The edges of a node at which the ground ends: bit e, edges as family_row.h numbers them.
inline unsigned node_walls(const GroundInfo& info, NodeKey key) {
  return (key.x == 0 ? 1u : 0u) | (node_exists(info, {key.size, key.x, key.z + 1}) ? 0u : 2u) |
         (node_exists(info, {key.size, key.x + 1, key.z}) ? 0u : 4u) | (key.z == 0 ? 8u : 0u);
}

// Index of a vertex of a size's grid among the samples of size 0.
inline std::int64_t sample_of(std::int64_t samples, int size, std::int64_t index) {
  const std::int64_t at = index << size;
  return at < 0 ? 0 : at < samples - 1 ? at : samples - 1;
}

// A coordinate in kVertexStep of size 0 on the lattice of a size, in kVertexStep of that size.
inline std::int64_t place_at_size(std::int64_t value, int size) {
  for (int s = 0; s < size; ++s) value = (value + 1) >> 1;
  return value;
}

// x or z of a sample of size 0, in kVertexStep.
std::int64_t sample_place(double steps, std::int64_t sample);

}  // namespace karst::core
