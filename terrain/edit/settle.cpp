// SPDX-License-Identifier: MIT
#include "terrain/edit/settle.h"

#include "terrain/base/check.h"
#include "terrain/edit/follow_change.h"

namespace karst::core {

bool fit_next(World& world, std::size_t part, Settled& done, LatticeBox& tight) {
  const World::Editable all = world.edit(part);
  if (all.queue->loose() == 0) return false;
  const PatchId patch = all.queue->next_loose();
  EditChange change;
  change.tight = tight;
  FollowChange(all, world.info().level, change).fit(patch);
  done.part = part;
  done.measured = all.first + patch;
  tight = change.tight;
  return true;
}

void settle_some(World& world, Settled& done) {
  done = {};
  while (world.is_settled(done.part)) ++done.part;
  LatticeBox tight{};
  if (fit_next(world, done.part, done, tight)) return;
  const World::Editable all = world.edit(done.part);
  if (all.queue->left() > 0) {
    const MeasurePatches::Room room{make_patch_scratch(all.room->scratch), all.room->vertices};
    done.measured =
        all.first + all.queue->measure_next(all.surface, all.heights->heights(), room,
                                            {all.level_errors, all.bounds, all.cones, all.shading_cones});
    // What has shrunk.
    if (all.queue->left() == 0) all.tree->fit_diagonal(all.bounds);
    return;
  }
  KARST_ASSERT(all.sky->is_behind());
  done.sky_changed = all.sky->step(*all.octree, all.sky_room);
}

}  // namespace karst::core
