// SPDX-License-Identifier: MIT
// Edits of voxels in a loaded world: the octree, and all that follows from it. Afterwards everything is, by
// key and to the bit, what the edited world would have been loaded with.
//
//   EditChange change;
//   edit_shape(world, edit, change);     // World::is_editable()
//   // vertices of change.touched are to be made anew; those of change.vanished are nobody's
//   log.undo([&](UndoPart part) { undo_shape(world, part, change); ... });
#pragma once

#include "karst/status.h"
#include "terrain/edit/edit.h"
#include "terrain/edit/follow_change.h"
#include "terrain/edit/undo_log.h"
#include "terrain/world/world.h"

namespace karst::core {

// In regions of a ground the outermost voxels stay as they are, whatever the shape: kSideVoxels at the sides,
// so that the rim and the belt that joins it to the ground do, and the lowest one. An edit that reaches none
// of the others, or those of two regions, is refused ("place").
inline constexpr int kSideVoxels = 3;

// invalid_argument naming the field of the edit that is out of its range, or "world" where it cannot be
// edited. limit_reached ("max_octets", "edit_patches", value: that it, or taking it back, would take).
// Nothing has changed then, and nothing is in the log.
Status check_edit(const Edit& edit, const World& world);
// How many of the world's parts have voxels that an edit may change. Precondition: check_edit().
std::size_t regions_reached(const Edit& edit, const World& world);
// The same from a part's corner.
Edit from_part(const Edit& edit, const WorldPart& part);
// The part that an edit of voxels changes, or "place". Precondition: check_edit().
Status part_of_edit(const Edit& edit, const World& world, std::size_t& part);
// log: null, or with a step open. Precondition: edits_voxels(edit.tool).
Status edit_shape(World& world, const Edit& edit, UndoLog* log, EditChange& change);
// The same of a part, which may be staged (World::stage_region()). Precondition: check_edit().
// exact: how many patches get exact boxes at once (MeasureQueue::add()); fit_next() gives them to the others.
Status edit_part(World& world, std::size_t part, const Edit& edit, UndoLog* log, EditChange& change,
                 std::size_t exact = MeasureQueue::kAll);
// What that would say, and whether it would change anything. Nothing of the world changes. Measures and
// heights need not be there.
Status try_part(World& world, std::size_t part, const Edit& edit, bool& changes);
inline Status edit_shape(World& world, const Edit& edit, EditChange& change) {
  return edit_shape(world, edit, nullptr, change);
}

// A part of the kind voxel_edit is taken back, or done again: neither fails. Precondition: the world is as it
// was after the edit, or before it.
void undo_shape(World& world, UndoPart part, EditChange& change);
void redo_shape(World& world, UndoPart part, EditChange& change);

}  // namespace karst::core
