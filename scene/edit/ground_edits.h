// SPDX-License-Identifier: MIT
// Edits of a world's ground, as frames and queries see them from then on: all of an edit or nothing of it.
// By the thread that draws, between frames and while no query of the world is asked.
#pragma once

#include "scene/world/world_object.h"
#include "terrain/edit/edit.h"
#include "terrain/edit/follow_change.h"
#include "terrain/edit/ground/edit_ground.h"
#include "terrain/edit/undo_log.h"

namespace karst::core {

// nodes: that are made anew. As EditGround::apply(), beneath regions too; limit_reached ("edit_tiles") where
// the plan has none.
Status edit_ground(WorldObject& world, const Edit& edit, UndoLog* log, GroundChange& change,
                   std::uint32_t& nodes);

// Room for what an edit of a region's voxels may change of the ground around it. "place": of no region's, or
// of two. As EditGround::reserve_region(); limit_reached ("edit_tiles") where the plan has none.
// Preconditions: check_edit(), and there is a ground.
Status reserve_region(WorldObject& world, const Edit& edit);
// A step of what edits of the ground left for later. Precondition: not EditGround::is_settled().
void settle_ground(WorldObject& world);
// The same of all regions whose heights, or the ground's beneath them, an edit of heights may change.
// regions: bit n where patches of region n do. Errors too of what those would be. Precondition: there is a
// ground.
Status plan_heights(WorldObject& world, const Edit& edit, std::uint32_t& regions);
// After an edit of a region or of the ground beneath: how near the ground may stand for it. box: all that
// changed, from the region's corner. False: nothing of that changed.
bool grow_region(WorldObject& world, std::size_t region, const LatticeBox& box, UndoLog* log);
// The same where growth is known.
bool measure_region(WorldObject& world, std::size_t region);
// A step of what those leave for later. Precondition: EditorObject::loose is not 0.
bool measure_columns(WorldObject& world);
// After an edit of a region's heights: how high its belt is.
void show_belt(WorldObject& world, std::size_t region);
// Samples of the ground as a box from a region's corner.
LatticeBox box_in_region(const WorldObject& world, std::size_t region, const GroundChange& change);

// What EditGround::apply() or finish() changed. Returns how many nodes are made anew.
std::uint32_t show_ground_change(WorldObject& world, const GroundChange& change);

}  // namespace karst::core
