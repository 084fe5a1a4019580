// SPDX-License-Identifier: MIT
#include "scene/edit/ground_edits.h"

namespace karst::core {

Status edit_ground(WorldObject& world, const Edit& edit, UndoLog* log, GroundChange& change,
                   std::uint32_t& nodes) {
  change = {};
  nodes = 0;
  if (world.ground_edits == nullptr)
    return {StatusCode::limit_reached, "there is no room for edits of the ground", "edit_tiles", 1};
  if (const Status status = world.ground_edits->apply(edit, log, change); !status.ok()) return status;
  nodes = show_ground_change(world, change);
  return {};
}

std::uint32_t show_ground_change(WorldObject& world, const GroundChange& change) {
  if (!change.changed) return 0;
  const EditGround& edits = *world.ground_edits;
  const GroundInfo& info = edits.info();
  world.terrain.world.set_ground_heights(info.low, info.high);
  for (QueryObject& query : world.queries) {
    query.asked.set_ground_heights(info.low, info.high);
    for (const EditedTile& tile : edits.overlay().tiles()) {
      if (tile.stamp == change.stamp) query.asked.forget_tile(tile.key);
    }
  }
  return edits.show(change, world.terrain.ground);
}

}  // namespace karst::core
