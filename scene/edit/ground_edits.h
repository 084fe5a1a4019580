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

// nodes: that are made anew. As EditGround::apply(); limit_reached ("edit_tiles") where the plan has none.
Status edit_ground(WorldObject& world, const Edit& edit, UndoLog* log, GroundChange& change,
                   std::uint32_t& nodes);

// Room for what an edit of a region's voxels may change of the ground around it. "place": of no region's, or
// of two. As EditGround::reserve_region(); limit_reached ("edit_tiles") where the plan has none.
// Preconditions: check_edit(), and there is a ground.
Status reserve_region(WorldObject& world, const Edit& edit);
// A step of what edits of the ground left for later. Precondition: not EditGround::is_settled().
void settle_ground(WorldObject& world);
// What an edit of voxels changed of the ground: how near it may stand for the region. False: nothing.
bool grow_region(WorldObject& world, const EditChange& change);

// What EditGround::apply() or finish() changed. Returns how many nodes are made anew.
std::uint32_t show_ground_change(WorldObject& world, const GroundChange& change);

}  // namespace karst::core
