// SPDX-License-Identifier: MIT
// A walk down the tree. Boxes of nodes are tested against all planes at once; in a node that planes cross,
// the boxes of eight patches against one plane at a time. Each box asks once whether rock hides it, and
// nothing below a hidden one does.
#include "terrain/cull/cull_view.h"

#include <algorithm>

#include "terrain/base/check.h"

namespace karst::core {
namespace {

// Levels from which on a patch is asked about: at level 1 its eight triangles cost less than asking does.
constexpr std::uint8_t kWorthAsking = 2;

class Walk {
 public:
  Walk(const CullView& stage, const Frustum& frustum)
      : stage_(stage),
        tree_(*stage.tree),
        frustum_(frustum),
        planes_(frustum),
        // A neighbour's box touches that of the patch in view.
        around_(tree_.longest_diagonal()),
        occlusion_(stage.occlusion != nullptr && stage.occlusion->active() ? stage.occlusion : nullptr) {}

  // mask: planes that cross the box around the node, or kOutside.
  void visit(int row, std::uint32_t n, PlaneMask mask, bool hidden) {
    if (mask != 0) {
      const PlaneLanes::Test test = planes_.test(tree_.node(row, n), around_);
      if (!test.is_near) return;
      mask = test.mask;
    }
    if (occlusion_ != nullptr && !hidden && mask != kOutside && row < Occlusion::kRows) {
      hidden = occlusion_->hides_node(tree_, row, n);
    }
    if (row == 0) {
      add(n, mask, hidden);
      return;
    }
    const std::uint32_t end = std::min((n + 1) * BoundsTree::kFanOut, tree_.nodes(row - 1));
    for (std::uint32_t child = n * BoundsTree::kFanOut; child < end; ++child) {
      visit(row - 1, child, mask, hidden);
    }
  }
  std::uint32_t count() const { return count_; }

 private:
  void add(std::uint32_t n, PlaneMask mask, bool hidden) {
    CulledEight eight;
    eight.n = n;
    if (mask != kOutside) {
      unsigned in_view = (1u << tree_.patch_count(0, n)) - 1;
      in_view &= ~unsigned{stage_.boxes[n].free};
      if (mask != 0) in_view &= ~outside(stage_.boxes[n], mask);
      eight.in_view = static_cast<std::uint8_t>(in_view);
      if (hidden) {
        eight.hidden = eight.in_view;
      } else if (occlusion_ != nullptr) {
        eight.hidden = occlusion_->hides_patches(stage_.boxes[n], n, worth_asking(n, eight.in_view));
      }
    }
    stage_.out[count_++] = eight;
  }

  std::uint8_t worth_asking(std::uint32_t n, unsigned in_view) const {
    if (stage_.levels.empty()) return static_cast<std::uint8_t>(in_view);
    unsigned worth = 0;
    for (std::uint32_t p = 0; p < tree_.patch_count(0, n); ++p) {
      worth |= (stage_.levels[n * PatchBoxes::kPatches + p] >= kWorthAsking ? 1u : 0u) << p;
    }
    return static_cast<std::uint8_t>(in_view & worth);
  }

  unsigned outside(const PatchBoxes& boxes, PlaneMask mask) const {
    const FourBoxes low(boxes, 0);
    const FourBoxes high(boxes, 1);
    unsigned result = 0;
    for (int n = 0; n < Frustum::kPlanes; ++n) {
      if ((mask >> n & 1u) == 0) continue;
      result |= low.outside(frustum_.planes[n]) | high.outside(frustum_.planes[n]) << 4;
    }
    return result;
  }

  const CullView& stage_;
  const BoundsTree& tree_;
  const Frustum& frustum_;
  const PlaneLanes planes_;
  const float around_;
  Occlusion* const occlusion_;
  std::uint32_t count_ = 0;
};

}  // namespace

Status CullView::validate() const {
  const auto refuse = [](const char* what, const char* field) {
    return Status{StatusCode::invalid_argument, what, field};
  };
  if (tree == nullptr) return refuse("missing", "tree");
  const std::uint32_t eights = PatchBoxes::count_for(tree->patches());
  if (!levels.empty() && levels.size() != tree->patches())
    return refuse("must hold one byte a patch", "levels");
  if (boxes.size() != eights) return refuse("must hold one entry eight patches", "boxes");
  if (out.size() < eights) return refuse("must hold one entry eight patches", "out");
  return {};
}

std::uint32_t CullView::run() const {
  KARST_ASSERT(validate().ok());
  if (tree->patches() == 0) return 0;
  const bool all = frustum == nullptr;
  const Frustum none{};
  Walk walk(*this, all ? none : *frustum);
  walk.visit(tree->rows() - 1, 0, all ? 0 : kAllPlanes, false);
  return walk.count();
}

}  // namespace karst::core
