// SPDX-License-Identifier: MIT
// CullView over a surface, with the memory that it takes.
#pragma once

#include <span>
#include <vector>

#include "terrain/cull/cull_view.h"

namespace karst::test {

using namespace core;

class CulledView {
 public:
  CulledView(const Surface& surface, std::span<const PatchBounds> bounds)
      : boxes_(PatchBoxes::count_for(static_cast<std::uint32_t>(bounds.size()))), culled_(boxes_.size()) {
    fill_patch_boxes(surface, bounds, 0, static_cast<PatchId>(bounds.size()), boxes_);
  }

  std::span<const PatchBoxes> boxes() const { return boxes_; }
  // frustum: null where all patches are in view. Valid until the next call, which takes no memory.
  std::span<const CulledEight> find(const Frustum* frustum, const BoundsTree& tree,
                                    Occlusion* occlusion = nullptr) {
    CullView cull;
    cull.frustum = frustum;
    cull.tree = &tree;
    cull.boxes = boxes_;
    cull.occlusion = occlusion;
    cull.out = culled_;
    return std::span(culled_).first(cull.validate().ok() ? cull.run() : 0);
  }

 private:
  std::vector<PatchBoxes> boxes_;
  std::vector<CulledEight> culled_;
};

}  // namespace karst::test
