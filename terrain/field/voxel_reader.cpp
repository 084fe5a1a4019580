// SPDX-License-Identifier: MIT
#include "terrain/field/voxel_reader.h"

#include <algorithm>

namespace karst::core {
namespace {

// The lowest count bits, count in 0..32.
constexpr std::uint32_t low_bits(int count) {
  return count >= 32 ? 0xffffffffu : (1u << count) - 1u;
}

// A row of voxels inside the octree: x in [begin, end), at one y and z.
struct Row {
  std::int32_t begin;
  std::int32_t end;
  std::int32_t y;
  std::int32_t z;
};

// The row's bits inside node n of 2^bit voxels from x; bit 0 is row.begin. At each step y and z choose one of
// four pairs of children. Recursion is bounded by the tree's depth.
std::uint32_t row_in(const Octree& tree, Octree::Node n, int bit, std::int32_t x, const Row& row) {
  while (!Octree::is_leaf(n)) {
    --bit;
    const int octant = (row.y >> bit & 1) << 1 | (row.z >> bit & 1) << 2;
    const std::int32_t middle = x + (std::int32_t{1} << bit);
    const Octree::Node lower = tree.child(n, octant);
    const Octree::Node upper = tree.child(n, octant | 1);
    if (row.end <= middle) {
      n = lower;
    } else if (row.begin >= middle) {
      n = upper;
      x = middle;
    } else {
      return row_in(tree, lower, bit, x, row) | row_in(tree, upper, bit, middle, row);
    }
  }
  if (!Octree::is_filled(n)) return 0;
  const std::int32_t first = std::max(row.begin, x);
  const std::int32_t last = std::min(row.end, x + (std::int32_t{1} << bit));
  return low_bits(last - first) << (first - row.begin);
}

// Beyond the mirror of the other side: the outermost one.
std::int32_t mirrored(std::int32_t v, std::int32_t extent) {
  if (v < 0) v = v < -extent ? extent - 1 : -v;
  if (v >= extent) v = v > 2 * extent ? 0 : 2 * (extent - 1) - v;
  return std::clamp(v, 0, extent - 1);
}

}  // namespace

bool VoxelReader::filled(glm::ivec3 v) const {
  if (v.y < 0) return true;
  if (v.y >= extent_.y) return false;
  if (mirrors_) return tree_->filled({mirrored(v.x, extent_.x), v.y, mirrored(v.z, extent_.z)});
  return tree_->filled(glm::ivec3(std::clamp(v.x, 0, extent_.x - 1), v.y, std::clamp(v.z, 0, extent_.z - 1)));
}

std::uint32_t VoxelReader::read_row(std::int32_t x0, std::int32_t y, std::int32_t z, int count) const {
  if (count <= 0 || y >= extent_.y) return 0;
  count = std::min(count, kMaxRow);
  if (y < 0) return low_bits(count);
  if (mirrors_) return read_mirrored_row(x0, y, z, count);
  // Further out the answer is the same, and the sums below cannot overflow.
  x0 = std::clamp(x0, -kMaxRow, extent_.x);

  // The part of the row inside the extent; at least the nearest voxel of it, when the row lies wholly beyond
  // a side.
  const std::int32_t first = std::clamp(x0, 0, extent_.x - 1);
  const std::int32_t last = std::clamp(x0 + count - 1, 0, extent_.x - 1);
  const Row row{first, last + 1, y, std::clamp(z, 0, extent_.z - 1)};
  const std::uint32_t inside = row_in(*tree_, tree_->root(), tree_->depth(), 0, row);

  // Replicate the end voxels beyond the sides.
  const int before = std::clamp(first - x0, 0, count);
  const int after = std::clamp(x0 + count - 1 - last, 0, count);
  std::uint32_t bits = before < 32 ? inside << before : 0;
  if ((inside & 1u) != 0) bits |= low_bits(before);
  if ((inside >> (last - first) & 1u) != 0) bits |= low_bits(count) & ~low_bits(count - after);
  return bits & low_bits(count);
}

std::uint32_t VoxelReader::read_mirrored_row(std::int32_t x0, std::int32_t y, std::int32_t z,
                                             int count) const {
  z = mirrored(z, extent_.z);
  // Too far out for sums: those beyond the mirror's mirror are all alike.
  x0 = std::clamp(x0, -4 * (kMaxRow + extent_.x), 4 * (kMaxRow + extent_.x));
  const std::int32_t first = std::clamp(x0, 0, extent_.x);
  const std::int32_t last = std::clamp(x0 + count, first, std::max(first, extent_.x));
  std::uint32_t bits = 0;
  if (last > first) {
    const Row row{first, last, y, z};
    bits = row_in(*tree_, tree_->root(), tree_->depth(), 0, row) << (first - x0);
  }
  for (int k = 0; k < count; ++k) {
    const std::int32_t x = x0 + k;
    if (x >= 0 && x < extent_.x) continue;
    if (tree_->filled({mirrored(x, extent_.x), y, z})) bits |= 1u << k;
  }
  return bits;
}

}  // namespace karst::core
