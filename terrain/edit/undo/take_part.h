// SPDX-License-Identifier: MIT
// A part of a step of a world of voxels is taken back, or done again, in the way of its kind. Parts of the
// ground are EditGround's.
#pragma once

#include "terrain/base/check.h"
#include "terrain/edit/follow_change.h"
#include "terrain/edit/patch/edit_heights.h"
#include "terrain/edit/shape/edit_shape.h"
#include "terrain/edit/undo_log.h"
#include "terrain/world/world.h"

namespace karst::core {

// Calls follow(EditChange) for what changed, once or several times; a change is valid until follow returns.
// Precondition: the world is as it was after the part, to take it back, else as before it.
template <class Follow>
void take_part(World& world, UndoPart part, bool back, const Follow& follow) {
  EditChange change;
  switch (part.kind()) {
    case CellKind::voxel_edit:
      back ? undo_shape(world, part, change) : redo_shape(world, part, change);
      follow(change);
      break;
    case CellKind::patch_heights:
      for (ExchangeHeights exchange(world, part); exchange.next(change);) follow(change);
      break;
    default:
      KARST_ASSERT(false);
  }
}

}  // namespace karst::core
