// SPDX-License-Identifier: MIT
// Boxes over runs of consecutive patches. Patches follow the octree's order in space (surface.h), so eight in
// a row lie close together: a node of row 0 covers eight patches, a node of row r eight nodes of row r - 1.
// The tree is implicit, node n of row r covers the patches from n * 8^(r+1), and it costs 3.5 bytes a patch.
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/patch/bounds.h"
#include "terrain/surface/patch.h"
#include "terrain/view/frustum.h"

namespace karst::core {

// Box of one patch on the lattice.
inline LatticeBox patch_box(const Surface& surface, std::span<const PatchBounds> bounds, PatchId id) {
  const glm::ivec3 origin = patch_origin(surface.volume_of(id));
  const PatchBounds& b = bounds[id];
  return {origin + glm::ivec3(b.min[0], b.min[1], b.min[2]),
          origin + glm::ivec3(b.max[0], b.max[1], b.max[2])};
}

// The box of free slots (kFreeVolume).
inline constexpr std::int32_t kNowhereSteps = std::int32_t{kFreeCorner} << kLatticeBits;
inline bool is_nowhere(const LatticeBox& box) {
  return box.min.x == kNowhereSteps;
}

class BoundsTree {
 public:
  static constexpr int kFanOutLog2 = 3;
  static constexpr std::uint32_t kFanOut = 1u << kFanOutLog2;
  static constexpr int kMaxRows = 8;  // 8^8 = 2^24 patches
  static constexpr std::uint32_t kMaxPatches = 1u << (3 * kMaxRows);

  // Nodes that a tree over so many patches has.
  static constexpr std::uint32_t node_count(std::uint32_t patches) {
    std::uint32_t total = 0;
    for (std::uint32_t row = patches; row > 0;) {
      row = (row + kFanOut - 1) / kFanOut;
      total += row;
      if (row == 1) break;
    }
    return total;
  }

  // Lends memory for trees of up to as many patches as storage has room for; borrowed for the tree's life.
  void create(std::span<LatticeBox> storage) {
    storage_ = storage;
    patches_ = 0;
    rows_ = 0;
  }

  // Builds the tree anew. Free slots of the surface are in no box; a node of free ones alone is is_nowhere().
  // invalid_argument where bounds has not one box a patch; limit_reached, naming
  // max_patches, where storage is less than node_count(patches). The tree is unchanged on failure.
  Status build(const Surface& surface, std::span<const PatchBounds> bounds);

  // Brings the nodes above patches first .. first + count - 1 up to date after their bounds changed; cost
  // grows with count and the tree's height. invalid_argument where surface, bounds or the range do not fit
  // the tree.
  Status update(const Surface& surface, std::span<const PatchBounds> bounds, PatchId first,
                std::uint32_t count);

  std::uint32_t patches() const { return patches_; }
  // No patch's box has a longer diagonal, lattice steps. Updates never lower it; fit_diagonal() finds it
  // anew.
  float longest_diagonal() const { return longest_diagonal_; }
  void fit_diagonal(std::span<const PatchBounds> bounds);
  int rows() const { return rows_; }                                            // 0 only for an empty tree
  std::uint32_t nodes(int row) const { return begin_[row + 1] - begin_[row]; }  // the last row has one
  const LatticeBox& node(int row, std::uint32_t n) const { return storage_[node_index(row, n)]; }
  // Around all patches, seen from a world whose voxel `corner` is this one's first. There is one.
  LatticeBox around_all(glm::ivec3 corner) const {
    const LatticeBox& all = node(rows_ - 1, 0);
    return {all.min + corner * kStepsPerVoxel, all.max + corner * kStepsPerVoxel};
  }
  std::uint32_t node_index(int row, std::uint32_t n) const { return begin_[row] + n; }  // below node_count()

  // Patches that a node covers.
  std::uint32_t first_patch(int row, std::uint32_t n) const { return n << (kFanOutLog2 * (row + 1)); }
  std::uint32_t patch_count(int row, std::uint32_t n) const {
    const std::uint32_t whole = 1u << (kFanOutLog2 * (row + 1));
    const std::uint32_t rest = patches_ - first_patch(row, n);
    return rest < whole ? rest : whole;
  }

 private:
  void take_diagonals(std::span<const PatchBounds> bounds, std::uint32_t first, std::uint32_t last);
  void refit(const Surface& surface, std::span<const PatchBounds> bounds, std::uint32_t first,
             std::uint32_t last);

  std::span<LatticeBox> storage_;
  std::uint32_t begin_[kMaxRows + 1] = {};  // first node of each row in storage_
  std::uint32_t patches_ = 0;
  float longest_diagonal_ = 0.0f;
  int rows_ = 0;
};

}  // namespace karst::core
