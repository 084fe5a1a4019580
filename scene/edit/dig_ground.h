// SPDX-License-Identifier: MIT
// Edits of voxels where there is only ground: a region is made there first, large enough for them.
#pragma once

#include "scene/world/world_object.h"
#include "terrain/edit/edit.h"
#include "terrain/edit/regions/make_region.h"

namespace karst::core {

// Whether an edit of voxels would change voxels that no region has. Preconditions: check_edit(), and the
// ground can be dug.
bool wants_region(const World& world, const Edit& edit);
// The region for it, begun. None, made.world being null, where nothing is that could be cleared. Errors of
// MakeRegion and edit_part(); invalid_argument ("place": too near to the ground's border or to another
// region); limit_reached ("edit_tiles"). After an error nothing has changed.
Status begin_region_for(WorldObject& world, const Edit& edit, MakeRegion& made);
// Frames and queries have what is staged from now on, and nodes around it know how far it is from the ground.
void show_region(WorldObject& world);

}  // namespace karst::core
