// SPDX-License-Identifier: MIT
#include "terrain/edit/follow_change.h"

#include <algorithm>

#include <glm/common.hpp>

#include "terrain/base/check.h"
#include "terrain/measure/measure_patches.h"

namespace karst::core {

void join(LatticeBox& box, const LatticeBox& other) {
  if (is_nowhere(other)) return;
  box = {glm::min(box.min, other.min), glm::max(box.max, other.max)};
}

void FollowChange::forget(PatchId slot) {
  if (!all_.surface.is_free(slot)) return;  // it is taken again
  all_.bounds[slot] = {};
  all_.cones[slot] = all_.shading_cones[slot] = {};
  const std::size_t values = level_error_values(level_);
  std::ranges::fill(all_.level_errors.subspan(slot * values, values), std::uint16_t{0});
  if (!all_.overrides.empty()) all_.overrides[slot] = 0;
}

void FollowChange::run(std::span<const PatchId> changed, std::span<const PatchId> vanished, bool voxels) {
  change_.vanished = vanished;
  const Status status = find_touched(all_.surface, changed, all_.room->touched, change_.touched);
  KARST_ASSERT(status.ok());  // counted before
  static_cast<void>(status);
  swept_ = change_.box;
  for (const std::span<const PatchId> list : {vanished, changed}) {
    for (const PatchId patch : list) include(patch);
  }
  measure(changed);
  derive(changed);
  if (voxels) all_.sky->outdate();
  name_for_world();
}

void FollowChange::name_for_world() {
  const World::EditRoom& room = *all_.room;
  KARST_ASSERT(change_.vanished.empty() || change_.vanished.data() == room.changed.data());
  if (all_.first == 0) return;
  for (PatchId& patch : room.changed.first(change_.vanished.size())) patch += all_.first;
  for (PatchId& patch : room.touched.first(change_.touched.size())) patch += all_.first;
}

// What a patch can touch as culling has it: its box, and its volume, which holds its control points.
void FollowChange::include(PatchId slot) {
  const LatticeBox box = box_before(slot);
  if (is_nowhere(box)) return;
  join(change_.box, box);
  join(swept_, box);
  const glm::ivec3 origin = all_.boxes[slot / PatchBoxes::kPatches].origin(slot % PatchBoxes::kPatches);
  join(swept_, {origin - kStepsPerHalfVoxel, origin + kStepsPerHalfVoxel});
  const glm::ivec3 corner = origin / kStepsPerVoxel;
  at_sides_ = at_sides_ || corner.y <= 1;
  for (const int axis : {0, 2})
    at_sides_ = at_sides_ || corner[axis] <= 1 || corner[axis] >= all_.extent[axis] - 1;
}

void FollowChange::measure(std::span<const PatchId> changed) {
  const PatchMeasures out{all_.level_errors, all_.bounds, all_.cones, all_.shading_cones};
  for (const PatchId slot : change_.vanished) all_.queue->forget(slot);
  all_.queue->add(all_.surface, all_.heights->heights(), changed, change_.touched,
                  make_patch_scratch(all_.room->scratch), out);
}

void FollowChange::derive(std::span<const PatchId> changed) {
  for (const std::span<const PatchId> list : {change_.vanished, changed}) {
    for (const PatchId patch : list) {
      fill_patch_boxes(all_.surface, all_.bounds, patch, patch + 1, all_.boxes);
      const Status status = all_.tree->update(all_.surface, all_.bounds, patch, 1);
      KARST_ASSERT(status.ok());
      static_cast<void>(status);
    }
  }
  for (const PatchId patch : changed) include(patch);
  swept_.min -= Occluders::kMargin;
  swept_.max += Occluders::kMargin;
  all_.occluders->update(*all_.octree, all_.surface, all_.bounds, *all_.tree, changed, swept_, at_sides_);
}

}  // namespace karst::core
