// SPDX-License-Identifier: MIT
// Edits of voxels in a loaded world: the octree, and all that follows from it. Afterwards everything is, by
// key and to the bit, what the edited world would have been loaded with.
//
//   EditChange change;
//   edit_shape(world, edit, change);     // World::is_editable()
//   // vertices of change.touched are to be made anew; those of change.vanished are nobody's
#pragma once

#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/edit/edit.h"
#include "terrain/surface/patch.h"
#include "terrain/view/frustum.h"
#include "terrain/world/world.h"

namespace karst::core {

struct EditChange {
  bool changed = false;  // false: the world was so already
  std::size_t part = 0;  // the world's that changed
  LatticeBox box{};      // of all that changed, before and after; from the part's corner
  bool sky_changed = false;
  // The world's patches whose vertices or measures may be others, ascending, and slots that became free.
  // Valid until the next edit.
  std::span<const PatchId> touched;
  std::span<const PatchId> vanished;
};

// In regions of a ground the outermost voxels stay as they are, whatever the shape: kSideVoxels at the sides,
// so that the rim and the belt that joins it to the ground do, and the lowest one. An edit that reaches none
// of the others, or those of two regions, is refused ("place").
inline constexpr int kSideVoxels = 3;

// invalid_argument naming the field of the edit that is out of its range, or "world" where it cannot be
// edited. limit_reached ("max_octets", "edit_patches", value: that it would take). Nothing has changed then.
Status check_edit(const Edit& edit, const World& world);
// The part that an edit of voxels changes, or "place". Precondition: check_edit().
Status part_of_edit(const Edit& edit, const World& world, std::size_t& part);
// Precondition: edits_voxels(edit.tool).
Status edit_shape(World& world, const Edit& edit, EditChange& change);

}  // namespace karst::core
