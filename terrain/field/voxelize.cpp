// SPDX-License-Identifier: MIT
#include "terrain/field/voxelize.h"

#include "terrain/base/lattice.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace karst::core {
namespace {

constexpr std::int32_t kMaxSize = std::int32_t{1} << kMaxDepth;

Status check_extent(glm::ivec3 extent, std::int32_t limit) {
  for (int axis = 0; axis < 3; ++axis) {
    if (extent[axis] < 1 || extent[axis] > limit) {
      return {StatusCode::invalid_argument, "extent is outside 1..the octree's size", "extent"};
    }
  }
  return {};
}

glm::ivec3 octant_corner(glm::ivec3 corner, std::int32_t half, int octant) {
  return {corner.x + (octant & 1 ? half : 0), corner.y + (octant & 2 ? half : 0),
          corner.z + (octant & 4 ? half : 0)};
}

// Number of voxels that a column's top fills, by the rule "y + 0.5 < top". In double, where top - 0.5 is
// exact for every float that is not clamped.
std::int32_t filled_below(float top, std::int32_t limit) {
  const double t = std::ceil(static_cast<double>(top) - 0.5);
  if (!(t > 0.0)) return 0;
  return t < static_cast<double>(limit) ? static_cast<std::int32_t>(t) : limit;
}

// Builds the tree of column heights; with no octree, only counts the octets it would take.
class HeightBuilder {
 public:
  HeightBuilder(const VoxelizeHeights& job, Octree* tree) : job_(job), tree_(tree) {}

  Octree::Node build(glm::ivec3 corner, std::int32_t size) {
    if (corner.x >= job_.extent.x || corner.y >= job_.extent.y || corner.z >= job_.extent.z)
      return Octree::kEmpty;
    std::int32_t low = 0;
    std::int32_t high = 0;
    column_range(corner, size, low, high);
    if (high <= corner.y) return Octree::kEmpty;
    if (low >= corner.y + size) return Octree::kFilled;
    // For a single voxel low equals high, and one of the two tests above held.
    const std::int32_t half = size / 2;
    Octree::Octet octet;
    for (int octant = 0; octant < 8; ++octant)
      octet.child[octant] = build(octant_corner(corner, half, octant), half);
    // One column reaches above this node's floor and another ends below its ceiling: the node is mixed, and
    // it does take an octet.
    ++octets_;
    Octree::Node node = 0;  // any value that is no leaf, when only counting
    if (tree_ != nullptr && status_.ok()) status_ = tree_->make_node(octet, node);
    return node;
  }

  std::uint32_t octets() const { return octets_; }
  Status status() const { return status_; }

 private:
  // Least and greatest number of filled voxels over the node's columns; columns beyond the extent have none.
  void column_range(glm::ivec3 corner, std::int32_t size, std::int32_t& low, std::int32_t& high) const {
    const std::int32_t x_end = std::min(corner.x + size, job_.extent.x);
    const std::int32_t z_end = std::min(corner.z + size, job_.extent.z);
    // In floats, and as voxels only at the end: filled_below rises with the top, and is slow to call for
    // each.
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    float lowest = kInfinity;
    float highest = -kInfinity;
    for (std::int32_t z = corner.z; z < z_end; ++z) {
      const float* row = job_.tops.data() + std::int64_t{z} * job_.extent.x;
      for (std::int32_t x = corner.x; x < x_end; ++x) {
        const float top = std::isnan(row[x]) ? -kInfinity : row[x];
        lowest = std::min(lowest, top);
        highest = std::max(highest, top);
      }
    }
    low = filled_below(lowest, job_.extent.y);
    high = filled_below(highest, job_.extent.y);
    if (corner.x + size > job_.extent.x || corner.z + size > job_.extent.z) low = 0;
  }

  const VoxelizeHeights& job_;
  Octree* tree_;
  std::uint32_t octets_ = 0;
  Status status_;
};

// Rewrites the part of a tree that a box covers, bottom-up. Recursion is bounded by the tree's depth.
class BoxEditor {
 public:
  BoxEditor(Octree& tree, glm::ivec3 box_min, glm::ivec3 box_max, const VoxelFunction& filled)
      : tree_(tree), min_(box_min), max_(box_max), filled_(filled) {}

  // result is valid, and owns all octets of its subtree, also where the status is not ok.
  Status edit(Octree::Node node, glm::ivec3 corner, std::int32_t size, Octree::Node& result) {
    result = node;
    if (outside(corner, size)) return {};
    if (size == 1) {
      result = filled_(corner, Octree::is_filled(node)) ? Octree::kFilled : Octree::kEmpty;
      return {};
    }
    const std::int32_t half = size / 2;
    Octree::Octet octet = tree_.children(node);
    Status status;
    for (int octant = 0; octant < 8 && status.ok(); ++octant) {
      Octree::Node& child = octet.child[octant];
      status = edit(child, octant_corner(corner, half, octant), half, child);
    }
    if (!Octree::is_leaf(node)) {
      result = tree_.update_node(node, octet);
      return status;
    }
    if (status.ok()) status = tree_.make_node(octet, result);
    if (!status.ok()) {
      // No octet to link the children to: the leaf stays as it was.
      for (const Octree::Node child : octet.child) tree_.release(child);
      result = node;
    }
    return status;
  }

 private:
  bool outside(glm::ivec3 corner, std::int32_t size) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (corner[axis] >= max_[axis] || corner[axis] + size <= min_[axis]) return true;
    }
    return false;
  }

  Octree& tree_;
  glm::ivec3 min_;
  glm::ivec3 max_;
  const VoxelFunction& filled_;
};

}  // namespace

Status VoxelizeHeights::validate() const {
  if (const Status status = check_extent(extent, kMaxSize); !status.ok()) return status;
  const std::size_t columns = static_cast<std::size_t>(extent.x) * static_cast<std::size_t>(extent.z);
  if (tops.size() != columns) {
    return {StatusCode::invalid_argument, "not one column top for each x and z of the extent", "tops",
            columns};
  }
  return {};
}

Status VoxelizeHeights::run(Octree& tree) const {
  if (const Status status = validate(); !status.ok()) return status;
  if (const Status status = check_extent(extent, tree.size()); !status.ok()) return status;
  if (const Status status = tree.reset(tree.depth()); !status.ok()) return status;
  HeightBuilder builder(*this, &tree);
  const Octree::Node root = builder.build(glm::ivec3(0), tree.size());
  if (!builder.status().ok()) {
    const Status emptied = tree.reset(tree.depth());
    if (!emptied.ok()) return emptied;
    return {StatusCode::limit_reached, "the octree's octets are used up", "max_octets", builder.octets()};
  }
  tree.set_root(root);
  return {};
}

std::uint32_t VoxelizeHeights::count_octets(int depth) const {
  if (depth < 1 || depth > kMaxDepth || !validate().ok()) return 0;
  const std::int32_t size = std::int32_t{1} << depth;
  if (!check_extent(extent, size).ok()) return 0;
  HeightBuilder builder(*this, nullptr);
  builder.build(glm::ivec3(0), size);
  return builder.octets();
}

Status VoxelizePredicate::validate() const {
  return EditVoxels{glm::ivec3(0), extent, extent, filled}.validate();
}

Status VoxelizePredicate::run(Octree& tree) const {
  const EditVoxels job{glm::ivec3(0), extent, extent, filled};
  if (const Status status = job.validate(); !status.ok()) return status;
  if (const Status status = check_extent(extent, tree.size()); !status.ok()) return status;
  if (const Status status = tree.reset(tree.depth()); !status.ok()) return status;
  const Status status = job.run(tree);
  if (status.ok()) return status;
  const Status emptied = tree.reset(tree.depth());
  return emptied.ok() ? status : emptied;
}

Status EditVoxels::validate() const {
  if (const Status status = check_extent(extent, kMaxSize); !status.ok()) return status;
  if (!filled.exists())
    return {StatusCode::invalid_argument, "no function says which voxels are filled", "filled"};
  return {};
}

Status EditVoxels::run(Octree& tree) const {
  if (const Status status = validate(); !status.ok()) return status;
  if (const Status status = check_extent(extent, tree.size()); !status.ok()) return status;
  glm::ivec3 low(0);
  glm::ivec3 high(0);
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = std::max(box_min[axis], 0);
    high[axis] = std::min(box_max[axis], extent[axis]);
    if (low[axis] >= high[axis]) return {};
  }
  Octree::Node root = tree.root();
  const Status status = BoxEditor(tree, low, high, filled).edit(root, glm::ivec3(0), tree.size(), root);
  tree.set_root(root);
  return status;
}

}  // namespace karst::core
