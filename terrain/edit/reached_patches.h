// SPDX-License-Identifier: MIT
// Which patches an edit may reach: those whose boxes it does, found by the world's tree.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "terrain/cull/bounds_tree.h"
#include "terrain/surface/patch.h"

namespace karst::core {

template <class Reaches, class Visit>
struct ReachedPatches {
  const BoundsTree& tree;
  const Surface& surface;
  std::span<const PatchBounds> bounds;
  const Reaches& reaches;  // bool(const LatticeBox&)
  const Visit& visit;      // void(PatchId), ascending

  ReachedPatches(const BoundsTree& t, const Surface& s, std::span<const PatchBounds> b, const Reaches& r,
                 const Visit& v)
      : tree(t), surface(s), bounds(b), reaches(r), visit(v) {}

  void run() const {
    if (tree.rows() > 0) visit_node(tree.rows() - 1, 0);
  }

 private:
  void visit_node(int row, std::uint32_t n) const {
    if (is_nowhere(tree.node(row, n)) || !reaches(tree.node(row, n))) return;
    if (row > 0) {
      const std::uint32_t first = n * BoundsTree::kFanOut;
      const std::uint32_t end = std::min(first + BoundsTree::kFanOut, tree.nodes(row - 1));
      for (std::uint32_t k = first; k < end; ++k) visit_node(row - 1, k);
      return;
    }
    for (std::uint32_t k = 0; k < tree.patch_count(0, n); ++k) {
      const PatchId patch = tree.first_patch(0, n) + k;
      if (!surface.is_free(patch) && reaches(patch_box(surface, bounds, patch))) visit(patch);
    }
  }
};

}  // namespace karst::core
