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
// so that a ground may have any number of samples. Of a curved basis (terrain/basis/basis.h) a sample lies
// where that puts it, in steps along the axes of its frame, rounded to kVertexStep likewise; steps[] are then
// the most that samples are apart at height 0.
//
// A cube has six roots, the nodes that its faces are; nodes in other cells of its grid do not exist. No edge
// of a face is one of the ground's: neighbours are found across (neighbour_of).
//
// A ground that goes once around closes: its last column of samples is its first one, and nodes at the two
// ends are neighbours.
//
// A vertex of size s lies on a lattice of 2^s times as coarse steps: place_at_size() of its place at size
// 0, which halves and rounds once a size. So two sizes agree on where the coarser one's vertices are,
// whichever tile they were read from.
//
// Regions. A world may have voxels besides: then rectangles of whole nodes, its *regions*, are theirs, and
// the ground leaves those out where they are drawn. Each has an octree of its own; all have the same voxel,
// the world's, and lie on its lattice, each octree's low corner at whole voxels from the world's. Patches end
// at the centres of the outermost voxels, and there a region's borders lie, on edges of nodes. So samples are
// square, 2^(kLatticeBits - 2 + g) steps apart, a node of size 0 is 2^g voxels wide, 0 <= g <=
// kMostLatticeSize, and sample (0, 0) lies at `corner`. Steps are too fine for nodes then: size s has the
// lattice of page size s + g. Between two regions lies a node of size 0 at least, along x or along z.
//
// A ground that can be dug has that lattice whether there are regions yet or not: then the world's corner is
// that of a region whose first node were (0, 0), and regions' corners are any whole voxels from it.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "terrain/base/config.h"
#include "terrain/base/lattice.h"
#include "terrain/basis/basis.h"

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
// On a curved basis, whose nodes have their origin in the middle: a voxel, so that a page of 16 bits holds
// four of them and a half to either side.
inline constexpr double kMostCurvedSteps = 8192;
// With a region: 2^g times as many.
inline constexpr int kMostLatticeSize = 8;  // g: 512 voxels a side hold two nodes
inline constexpr double kMostRegionSteps = kMostSampleSteps * (1 << kMostLatticeSize);
// Heights are integers of kVertexStep steps, so that a height of the file is a vertex's place without
// rounding.
inline constexpr std::int32_t kMostHeight = 1 << 26;  // and its negative; 2^14 voxels

// Nodes of size 0: low..high - 1 along x and z. Empty: none.
struct NodeRect {
  std::int32_t low[2] = {};
  std::int32_t high[2] = {};

  bool exists() const { return high[0] > low[0]; }
  friend bool operator==(const NodeRect&, const NodeRect&) = default;
};

// Voxels that stand in the ground.
struct GroundRegion {
  NodeRect nodes;
  // Of its octree, voxels from the world's; the least of all regions' is 0, but where the ground can be dug.
  glm::ivec3 corner{0};
  glm::ivec3 extent{0};      // voxels in use: WorldInfo
  std::int32_t depth = 0;    // of the octree
  std::uint32_t octets = 0;  // of the octree; the others as extraction makes them
  std::uint32_t volumes = 0;
  std::uint32_t patches = 0;
  std::uint32_t rim_edges = 0;  // of patches at its border (terrain/regions/region_rim.h)
  // Heights that its belt may reach, lattice steps: by its extent, or, once it is loaded, by its rim.
  std::int64_t belt_low = 0;
  std::int64_t belt_high = 0;

  // What stands there is the world's isosurface. Its octree has voxels, of which the sky is seen, and no
  // surface; rim_edges are those of its finest meshes.
  bool is_field() const { return patches == 0; }
  friend bool operator==(const GroundRegion&, const GroundRegion&) = default;
};
inline constexpr std::int32_t kMostRegionHeight = 1 << 20;  // of corner.y, and where it may be its negative

struct GroundInfo {
  std::int64_t samples[2] = {};  // along x (east) and z (south), 2..kMostSamples; 0: there is no ground
  // Lattice steps from one to the next, kLeastSampleSteps..kMostSampleSteps * 2^lattice_size; of a curved
  // basis ..kMostCurvedSteps.
  double steps[2] = {};
  bool can_be_dug = false;
  // Where there are regions, or may be (place_regions()), else 0: g, which is the page size of nodes of size
  // 0, and the place of sample (0, 0), kVertexStep.
  int lattice_size = 0;
  std::int64_t corner[2] = {};
  std::int32_t region_count = 0;
  std::array<GroundRegion, kMostRegions> region_list{};
  std::int32_t low = 0;  // heights of all samples, +-kMostHeight
  std::int32_t high = 0;
  Basis basis;  // finished; its height_unit_m are the metres of kVertexStep

  bool exists() const { return samples[0] > 0; }
  bool has_voxel_lattice() const { return region_count > 0 || can_be_dug; }
  std::span<const GroundRegion> regions() const {
    return std::span(region_list).first(static_cast<std::size_t>(region_count));
  }
  // Of the page that a node of a size has.
  int page_size(int size) const { return size + lattice_size; }
  bool is_cube() const { return basis.kind == BasisKind::cube; }
  // East and west meet: the last sample of a row is its first.
  bool closes() const { return basis.turn_quads > 0 && basis.turn_quads == samples[0] - 1; }
  // Of the one root, the least size at which one node covers everything; of the cube's six, that of a face.
  int top_size() const {
    if (is_cube()) {
      int size = 0;
      while ((kNodeQuads << size) < basis.face_quads) ++size;
      return size;
    }
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

// The face that a node lies on: of a cube, of the cell of its grid, or -1; else 0.
inline int face_of(const GroundInfo& info, NodeKey key) {
  if (!info.is_cube()) return 0;
  const int cells = info.top_size() - key.size;
  return cells < 0 ? -1 : cube_face(key.x >> cells, key.z >> cells);
}

// Whether any of the node has area.
inline bool node_exists(const GroundInfo& info, NodeKey key) {
  if (info.is_cube()) return key.x >= 0 && key.z >= 0 && face_of(info, key) >= 0;
  return key.x >= 0 && key.z >= 0 && (std::int64_t{key.x} * kNodeQuads << key.size) < info.samples[0] - 1 &&
         (std::int64_t{key.z} * kNodeQuads << key.size) < info.samples[1] - 1;
}

// The last node of a size along x.
static_assert(kNodeQuads == 1 << 2);
inline std::int32_t last_column(const GroundInfo& info, int size) {
  return static_cast<std::int32_t>((info.samples[0] - 2) >> (size + 2));
}

// Whether a node of a ground that closes has children in its western half alone: the seam then lies on the
// line in its middle.
inline bool has_seam_inside(const GroundInfo& info, NodeKey key) {
  return info.closes() && key.size > 0 && key.x == last_column(info, key.size) &&
         last_column(info, key.size - 1) == 2 * key.x;
}

// The edges of a node at which the ground ends: bit e, edges as family_row.h numbers them.
inline unsigned node_walls(const GroundInfo& info, NodeKey key) {
  if (info.is_cube()) return 0;
  const unsigned walls = (node_exists(info, {key.size, key.x, key.z + 1}) ? 0u : 2u) | (key.z == 0 ? 8u : 0u);
  if (info.closes()) return walls;
  return walls | (key.x == 0 ? 1u : 0u) | (node_exists(info, {key.size, key.x + 1, key.z}) ? 0u : 4u);
}
// Whether some of a node's descendants may not exist.
inline bool has_end(const GroundInfo& info, NodeKey key) {
  return node_walls(info, key) != 0 || (info.closes() && key.x == last_column(info, key.size));
}

// Index of a vertex of a size's grid among the samples of size 0.
inline std::int64_t sample_of(std::int64_t samples, int size, std::int64_t index) {
  const std::int64_t at = index << size;
  return at < 0 ? 0 : at < samples - 1 ? at : samples - 1;
}

// The same along x, of vertices beside the grid too: of a ground that closes those beyond its other end, but
// to the east where that is not an edge of a node, whose vertices are the last sample.
inline std::int64_t sample_around(const GroundInfo& info, int size, std::int64_t index) {
  const std::int64_t last = (info.samples[0] - 2 + (std::int64_t{1} << size)) >> size;
  if (info.closes() && index < 0) return sample_of(info.samples[0], size, last + index);
  if (info.closes() && index > last && last % kNodeQuads == 0) index -= last;
  return sample_of(info.samples[0], size, index);
}

// A coordinate in kVertexStep of size 0 on the lattice of a size, in kVertexStep of that size.
inline std::int64_t place_at_size(std::int64_t value, int size) {
  for (int s = 0; s < size; ++s) value = (value + 1) >> 1;
  return value;
}

// x or z of a sample of size 0 from sample 0, in kVertexStep; of a plane.
std::int64_t sample_place(double steps, std::int64_t sample);
// The same from the world's corner. axis: 0 x, 1 z.
inline std::int64_t sample_place(const GroundInfo& info, int axis, std::int64_t sample) {
  return info.corner[axis] + sample_place(info.steps[axis], sample);
}

// Whether a node has a part of a region's border, in it or at its own.
inline bool borders(const GroundRegion& region, NodeKey key) {
  const std::int64_t at[2] = {key.x, key.z};
  bool inside = true;
  for (int axis = 0; axis < 2; ++axis) {
    const std::int64_t low = at[axis] << key.size;
    const std::int64_t high = (at[axis] + 1) << key.size;
    if (high < region.nodes.low[axis] || low > region.nodes.high[axis]) return false;
    inside = inside && low > region.nodes.low[axis] && high < region.nodes.high[axis];
  }
  return !inside;
}

// Makes regions of the octrees of which first nodes (nodes.low), extents and corner.y are given: the other
// ends of the rectangles, corners along x and z, and the ground's own place. False: the steps are not those
// above, an extent is not that of whole nodes, there is no ground all around a region, two lie nearer than a
// node, or a corner is out of its range; info then has none, and cannot be dug.
bool place_regions(GroundInfo& info);
// Makes the voxels of one octree of extent_x x extent_z the only region, its first node being (x, z). False:
// the same.
bool place_region(GroundInfo& info, std::int32_t extent_x, std::int32_t extent_z, std::int32_t x,
                  std::int32_t z);

// How much of a node a region has, or the one of all that has most.
enum class InRegion : std::uint8_t { none, part, all };
inline InRegion in_region(const GroundRegion& region, NodeKey key) {
  const std::int64_t at[2] = {key.x, key.z};
  bool all = true;
  for (int axis = 0; axis < 2; ++axis) {
    const std::int64_t low = at[axis] << key.size;
    const std::int64_t high = (at[axis] + 1) << key.size;
    if (high <= region.nodes.low[axis] || low >= region.nodes.high[axis]) return InRegion::none;
    all = all && low >= region.nodes.low[axis] && high <= region.nodes.high[axis];
  }
  return all ? InRegion::all : InRegion::part;
}
inline InRegion in_region(const GroundInfo& info, NodeKey key) {
  InRegion most = InRegion::none;
  for (const GroundRegion& region : info.regions()) {
    const InRegion in = in_region(region, key);
    if (in > most) most = in;
  }
  return most;
}

// The node of its size beside one, so many to the east and to the south of it, -1..1: of a cube over an edge
// of the face too, of a ground that closes over its ends. False: there is none, as at a corner of a cube,
// where three faces meet.
bool neighbour_of(const GroundInfo& info, NodeKey key, int east, int south, NodeKey& neighbour);

// The places of a node's vertices and of those around it, from vertex -kMostRim to kNodeQuads + kMostRim of
// its grid.
class NodePlaces {
 public:
  static constexpr int kMostRim = 2;

  // Precondition: the node exists.
  NodePlaces(const GroundInfo& info, NodeKey node);

  // kVertexStep of size 0 from the ground's corner or its frame's origin.
  glm::i64vec3 at(int i, int k, std::int32_t height) const {
    if (info_.basis.is_curved()) return curved(i, k, height);
    return {plane_[0][index(i)], height, plane_[1][index(k)]};
  }
  std::int64_t x(int i) const { return plane_[0][index(i)]; }  // of a plane
  std::int64_t z(int k) const { return plane_[1][index(k)]; }
  glm::dvec3 up(int i, int k) const;  // of a curved basis

 private:
  static constexpr int kCount = kNodeSide + 2 * kMostRim;
  static std::size_t index(int n) { return static_cast<std::size_t>(n + kMostRim); }
  glm::i64vec3 curved(int i, int k, std::int32_t height) const;

  const GroundInfo& info_;
  int face_;
  std::int64_t plane_[2][kCount];
  AxisPlace axes_[2][kCount];
};

}  // namespace karst::core
