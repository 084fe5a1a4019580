// SPDX-License-Identifier: MIT
#include "terrain/edit/undo/take_part.h"

#include "terrain/base/check.h"
#include "terrain/edit/shape/edit_shape.h"

namespace karst::core {

void take_part(World& world, UndoPart part, bool back, EditChange& change) {
  switch (part.kind()) {
    case CellKind::voxel_edit:
      return back ? undo_shape(world, part, change) : redo_shape(world, part, change);
    default:
      KARST_ASSERT(false);
  }
}

}  // namespace karst::core
