// SPDX-License-Identifier: MIT
// What follows in a world from patches that an edit changed, whatever it edited: boxes, the tree, rock that
// hides, which are at once what a file of the edited world would be loaded with; and measures and the sky,
// which are that once they are settled (settle.h). Until then measures are on the safe side.
#pragma once

#include <cstddef>
#include <span>

#include "terrain/surface/patch.h"
#include "terrain/view/frustum.h"
#include "terrain/world/world.h"

namespace karst::core {

struct EditChange {
  bool changed = false;  // false: the world was so already
  std::size_t part = 0;  // the world's that changed
  LatticeBox box{};      // of all that changed, before and after; from the part's corner
  LatticeBox tight{};    // the same without what is loose (MeasureQueue) after
  // The world's patches whose vertices or measures may be others, ascending, and slots that became free.
  // Valid until the next edit.
  std::span<const PatchId> touched;
  std::span<const PatchId> vanished;
  // By touched: rows of its grid that hold all vertices that may be others; none: only measures may be.
  std::span<const GridRows> rows;
};

// Larger by another; by one of free slots not.
void join(LatticeBox& box, const LatticeBox& other);

class FollowChange {
 public:
  // change: the box of what changed so far; all else is filled in.
  FollowChange(const World::Editable& all, int level, EditChange& change)
      : all_(all), level_(level), change_(change) {}

  // The box of a patch before the edit, until run().
  LatticeBox box_before(PatchId slot) const {
    return all_.boxes[slot / PatchBoxes::kPatches].box(slot % PatchBoxes::kPatches);
  }
  // Nothing is known any more of a slot that is free now.
  void forget(PatchId slot);
  // changed: patches that are others now, in any order, none of them free; with those that share a corner
  // with them no more than EditRoom::touched has room for. vanished: slots that are free now, ascending, at
  // the front of EditRoom::changed. All of them are the part's own; in the change they are the world's.
  // extents: by changed, what moved of each; none: all of them. voxels: whether those changed, too. exact: as
  // MeasureQueue::add().
  void run(std::span<const PatchId> changed, std::span<const PatchId> vanished,
           std::span<const PatchExtent> extents, bool voxels, std::size_t exact = MeasureQueue::kAll);
  // The box of a patch that is loose becomes exact, and what follows from it. It joins the change's tight
  // box.
  void fit(PatchId patch);

 private:
  void include(PatchId slot);
  void find_rows(std::span<const PatchId> changed, std::span<const PatchExtent> extents);
  void join_rows(PatchId patch, GridRows rows);
  GridRows border_rows(PatchId patch, bool first, bool last) const;
  void measure(std::span<const PatchId> changed, std::size_t exact);
  void derive(std::span<const PatchId> changed);
  void name_for_world();

  World::Editable all_;
  int level_;
  EditChange& change_;
  LatticeBox swept_{};     // what patches swept before and after
  bool at_sides_ = false;  // some of them stand there
};

}  // namespace karst::core
