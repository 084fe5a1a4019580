// SPDX-License-Identifier: MIT
// Edits of patches' heights by brush: extrude, smooth, noise, flatten and level (karst/edit.h), over borders
// and corners of patches. A vertex moves along its own direction of displacement (displacement.h), where the
// brush reaches its displaced place in space; all copies of a vertex that patches share get one height. What
// follows is, by key and to the bit, what the edited world would have been loaded with.
//
// In a region of a ground the rim moves with it, in the region's sides, whose directions lie in them. Near
// the sides extrude and noise move a vertex so far along its direction that the surface rises by as much as
// samples of the ground beside it do; from kSideVoxels on by as much along the direction, as everywhere.
//
//   EditChange change;
//   edit_heights(world, edit, nullptr, change);     // World::is_editable()
#pragma once

#include <cstddef>
#include <span>

#include "karst/status.h"
#include "terrain/edit/edit.h"
#include "terrain/edit/follow_change.h"
#include "terrain/edit/undo_log.h"
#include "terrain/world/world.h"

namespace karst::core {

// Of what a vertex's direction has along the plane's normal, where flatten and level move it all the way onto
// the plane; where it has less they move it less, and not at all where it runs along the plane.
inline constexpr double kLeastAcross = 0.1;

// Heights stay within kMaxHeight: a vertex that would go further stays there.
//
// invalid_argument names the field. limit_reached: "edit_patches" with how many would do. Nothing has changed
// then. log: null, or with a step open; cells are PatchCell (shape_undo.h) and the heights that patches had,
// by key, with the part's number as the region. Preconditions: edits_heights(edit.tool), part is one of the
// world's.
Status edit_heights(World& world, std::size_t part, const Edit& edit, UndoLog* log, EditChange& change);
inline Status edit_heights(World& world, const Edit& edit, UndoLog* log, EditChange& change) {
  return edit_heights(world, 0, edit, log, change);
}
// Whether that would succeed, and how many patches would change; nothing does.
Status try_heights(World& world, std::size_t part, const Edit& edit, std::size_t& patches);

// What edit_heights() refuses, but for want of room.
Status check_heights_edit(const Edit& edit, const World& world);

// A part of a step of the log that edit_heights() made, taken back or done again. What follows comes in
// several goes where there is not room for all of it at once.
//
//   ExchangeHeights exchange(world, part);
//   for (EditChange change; exchange.next(change);) ...
class ExchangeHeights {
 public:
  // Exchanges all heights. Preconditions: the world's patches are those that the part was made of.
  ExchangeHeights(World& world, UndoPart part);
  // False: there is no more that follows. Then nothing of the world is left out.
  bool next(EditChange& change);

 private:
  PatchId find(UndoCell cell, std::size_t& part) const;

  World& world_;
  UndoPart part_;
  UndoPart::Iterator at_;
};

// patch: of the part. A block of heights that is all zeros is none.
void put_heights(const World::Editable& all, PatchId patch, std::span<const std::int16_t> heights);

}  // namespace karst::core
