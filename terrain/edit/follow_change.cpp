// SPDX-License-Identifier: MIT
#include "terrain/edit/follow_change.h"

#include <algorithm>

#include <glm/common.hpp>

#include "terrain/base/check.h"
#include "terrain/measure/measure_patches.h"
#include "terrain/patch/corner_fan.h"

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

// Rows of a patch's border in which normals may be others.
GridRows FollowChange::border_rows(PatchId patch, bool first, bool last) const {
  const GridRows all = GridRows::all(level_);
  if (all_.patches[patch].collapsed != 0) return all;
  return {last ? all.high : all.low, first ? all.low : all.high};
}

void FollowChange::join_rows(PatchId patch, GridRows rows) {
  const auto at = std::ranges::lower_bound(change_.touched, patch) - change_.touched.begin();
  all_.room->rows[static_cast<std::size_t>(at)].join(rows);
}

// A normal depends on places beside it. Those on the border of a patch depend on its neighbours' there.
void FollowChange::find_rows(std::span<const PatchId> changed, std::span<const PatchExtent> extents) {
  const std::span<GridRows> rows = all_.room->rows.first(change_.touched.size());
  change_.rows = rows;
  std::ranges::fill(rows, extents.empty() ? GridRows::all(level_) : GridRows{});
  if (extents.empty()) return;
  const std::span<const Patch> patches = all_.surface.patches;
  for (std::size_t n = 0; n < changed.size(); ++n) {
    const PatchId patch = changed[n];
    PatchExtent extent = extents[n];
    if (!extent.rows.any()) continue;
    if (patches[patch].collapsed != 0) extent = PatchExtent::all(level_);
    if (extent.rows.low > 0) --extent.rows.low;
    if (extent.rows.high < patch_cells(level_)) ++extent.rows.high;
    join_rows(patch, extent.rows);
    for (int e = 0; e < 4; ++e) {
      const PatchEdge other = patches[patch].neighbour[e];
      if ((extent.around >> e & 1) == 0 || !other.exists()) continue;
      join_rows(other.patch(), border_rows(other.patch(), other.edge() == 0, other.edge() == 2));
    }
    for (int corner = 0; corner < 4; ++corner) {
      if ((extent.around >> (4 + corner) & 1) == 0) continue;
      PatchCorner fan[kMaxCornerFan];
      const int count = corner_fan(patches, {patch, corner}, fan);
      for (int f = 1; f < count; ++f)
        join_rows(fan[f].patch, border_rows(fan[f].patch, fan[f].corner < 2, fan[f].corner >= 2));
    }
  }
}

void FollowChange::run(std::span<const PatchId> changed, std::span<const PatchId> vanished,
                       std::span<const PatchExtent> extents, bool voxels, std::size_t exact) {
  change_.vanished = vanished;
  const Status status = find_touched(all_.surface, changed, all_.room->touched, change_.touched);
  KARST_ASSERT(status.ok());  // counted before
  static_cast<void>(status);
  find_rows(changed, extents);
  swept_ = change_.box;
  for (const std::span<const PatchId> list : {vanished, changed}) {
    for (const PatchId patch : list) include(patch);
  }
  measure(changed, exact);
  change_.tight = change_.box;
  for (const PatchId patch : changed.first(std::min(exact, changed.size()))) {
    join(change_.tight, patch_box(all_.surface, all_.bounds, patch));
  }
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

void FollowChange::fit(PatchId patch) {
  swept_ = box_before(patch);
  include(patch);
  all_.queue->fit(all_.surface, all_.heights->heights(), patch, make_patch_scratch(all_.room->scratch),
                  {all_.level_errors, all_.bounds, all_.cones, all_.shading_cones});
  join(change_.tight, patch_box(all_.surface, all_.bounds, patch));
  derive({&patch, 1});
}

void FollowChange::measure(std::span<const PatchId> changed, std::size_t exact) {
  const PatchMeasures out{all_.level_errors, all_.bounds, all_.cones, all_.shading_cones};
  for (const PatchId slot : change_.vanished) all_.queue->forget(slot);
  all_.queue->add(all_.surface, all_.heights->heights(), changed, change_.touched, change_.rows,
                  make_patch_scratch(all_.room->scratch), out, exact);
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
