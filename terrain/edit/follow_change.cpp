// SPDX-License-Identifier: MIT
#include "terrain/edit/follow_change.h"

#include <algorithm>

#include <glm/common.hpp>

#include "terrain/base/check.h"
#include "terrain/base/checksum.h"
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
  measure();
  derive(voxels);
  name_for_world();
}

void FollowChange::name_for_world() {
  const World::EditRoom& room = *all_.room;
  KARST_ASSERT(change_.vanished.empty() || change_.vanished.data() == room.changed.data());
  if (all_.first == 0) return;
  for (PatchId& patch : room.changed.first(change_.vanished.size())) patch += all_.first;
  for (PatchId& patch : room.touched.first(change_.touched.size())) patch += all_.first;
}

void FollowChange::measure() {
  const std::span<const PatchId> touched = change_.touched;
  if (touched.empty()) return;
  MeasurePatches measure;
  measure.surface = all_.surface;
  measure.heights = all_.heights->heights();
  measure.list = touched;
  measure.borders = all_.room->borders.first(touched.size());
  measure.out = {all_.level_errors, all_.bounds, all_.cones, all_.shading_cones};
  KARST_ASSERT(measure.validate().ok());
  const MeasurePatches::Room room{make_patch_scratch(all_.room->scratch), all_.room->vertices};
  for (const PatchId patch : touched) join(change_.box, box_before(patch));
  measure.measure(0, measure.count(), room);
  measure.join(0, measure.count());
  for (const PatchId patch : touched) join(change_.box, patch_box(all_.surface, all_.bounds, patch));
}

void FollowChange::derive(bool voxels) {
  for (const std::span<const PatchId> list : {change_.vanished, change_.touched}) {
    for (const PatchId patch : list) {
      fill_patch_boxes(all_.surface, all_.bounds, patch, patch + 1, all_.boxes);
      const Status status = all_.tree->update(all_.surface, all_.bounds, patch, 1);
      KARST_ASSERT(status.ok());
      static_cast<void>(status);
    }
  }
  all_.occluders->build(*all_.octree, all_.extent, all_.surface, all_.bounds);
  if (!voxels) return;
  const std::uint32_t sky = crc32c(std::as_bytes(all_.sky->cells()));
  all_.sky->build(*all_.octree, all_.extent, all_.mirrors);
  change_.sky_changed = crc32c(std::as_bytes(all_.sky->cells())) != sky;
}

}  // namespace karst::core
