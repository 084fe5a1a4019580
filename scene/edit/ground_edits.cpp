// SPDX-License-Identifier: MIT
#include "scene/edit/ground_edits.h"

#include "terrain/edit/regions/region_growth.h"
#include "terrain/edit/shape/edit_shape.h"

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

Status reserve_region(WorldObject& world, const Edit& edit) {
  const World& terrain = world.terrain.world;
  std::size_t part = 0;
  if (const Status status = part_of_edit(edit, terrain, part); !status.ok()) return status;
  if (world.ground_edits == nullptr) {
    return {StatusCode::limit_reached, "there is no room for what edits of a region change of the ground",
            "edit_tiles", 1};
  }
  return world.ground_edits->reserve_region(part, terrain.parts()[part].tree->around_all(glm::ivec3(0)));
}

void settle_ground(WorldObject& world) {
  GroundChange change;
  world.ground_edits->settle_some(change);
  world.ground_edits->show_measures(change, world.terrain.ground);
}

bool grow_region(WorldObject& world, const EditChange& change) {
  EditGround& edits = *world.ground_edits;
  while (!edits.is_settled()) settle_ground(world);
  const FindRegionGrowth find{&world.terrain.world, &edits, change.part, change.box, change.touched};
  GroundChange grown;
  edits.grow_region(change.part, find.run(), grown);
  show_ground_change(world, grown);
  return grown.changed;
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
