// SPDX-License-Identifier: MIT
// A part of a step of a world of voxels is taken back, or done again, in the way of its kind. Parts of the
// ground are EditGround's.
#pragma once

#include "terrain/edit/follow_change.h"
#include "terrain/edit/undo_log.h"
#include "terrain/world/world.h"

namespace karst::core {

// Precondition: the world is as it was after the part, to take it back, else as before it.
void take_part(World& world, UndoPart part, bool back, EditChange& change);

}  // namespace karst::core
