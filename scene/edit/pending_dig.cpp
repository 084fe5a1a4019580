// SPDX-License-Identifier: MIT
// Edits in parts. Those that make a region: the region, the hole in it, and then all see both. Others: boxes.
#include <algorithm>
#include <limits>

#include <glm/common.hpp>

#include "scene/edit/dig_ground.h"
#include "scene/edit/ground_edits.h"
#include "scene/world/world_object.h"
#include "terrain/base/check.h"
#include "terrain/edit/settle.h"
#include "terrain/edit/shape/edit_shape.h"

namespace karst::core {
namespace {

using Stage = PendingDig::Stage;

// What two edits changed, as one.
void join(EditResult& told, const EditResult& more) {
  if (!more.changed) return;
  if (!told.changed) {
    told = more;
    return;
  }
  told.low = from_glm(glm::min(to_glm(told.low), to_glm(more.low)));
  told.high = from_glm(glm::max(to_glm(told.high), to_glm(more.high)));
  told.patches += more.patches;
  told.nodes += more.nodes;
  told.version = more.version;
  told.can_undo = more.can_undo;
}

}  // namespace

Status EditorObject::start(const karst::Edit& edit, EditResult& result) {
  return begin(edit, true, result);
}

void EditorObject::advance(EditResult& result) {
  result = {};
  if (dig.stage != Stage::none) {
    EditResult made;
    if (step_dig(made)) join(dig.untold, made);
  }
  if (dig.stage == Stage::none) std::swap(result, dig.untold);
  if (!result.changed) result.version = version;
  result.pending = dig.stage != Stage::none;
}

void EditorObject::finish() {
  if (log.is_taking()) {
    EditResult rest;
    static_cast<void>(take_parts(log.takes_back(), std::numeric_limits<double>::infinity(), rest));
    if (rest.changed) {
      rest.version = ++version;
      join(dig.untold, rest);
    }
  }
  if (dig.stage == Stage::none) return;
  EditResult made;
  while (!step_dig(made)) {
  }
  join(dig.untold, made);
}

Status EditorObject::begin_dig(const core::Edit& edit, EditResult& result) {
  const Status status = begin_region_for(world, edit, dig.make);
  if (!status.ok() || dig.make.world == nullptr) return status;
  dig.stage = Stage::region;
  dig.edit = edit;
  dig.ends_stroke = false;
  result.pending = true;
  return {};
}

bool EditorObject::step_dig(EditResult& result) {
  switch (dig.stage) {
    case Stage::none:
      return true;
    case Stage::region:
      if (dig.make.step()) dig.stage = Stage::hole;
      return false;
    case Stage::hole:
      dig_hole();
      dig.stage = Stage::hole_boxes;
      return false;
    case Stage::hole_boxes:
      if (fit_boxes(world.terrain.world.spare().region)) dig.stage = Stage::show;
      return false;
    case Stage::show:
      show_dig(result);
      dig.stage = Stage::none;
      return true;
    case Stage::boxes:
      result = {};
      if (!fit_boxes(dig.part)) return false;
      grow_at_last();
      dig.stage = Stage::none;
      return true;
  }
  return true;
}

// Frames and queries have the edit, with boxes that hold exact ones. Thresholds allow for what those may be.
void EditorObject::fit_later(const EditChange& change) {
  dig.stage = Stage::boxes;
  dig.ends_stroke = false;
  dig.part = change.part;
  dig.box = change.tight;
  if (!world.terrain.world.ground().exists()) return;
  dig.growth = world.ground_edits->growth(change.part);
  if (grow_region(world, change.part, change.box, nullptr)) ground_changed = true;
}

bool EditorObject::fit_boxes(std::size_t part) {
  core::World& terrain = world.terrain.world;
  const auto of_patch = static_cast<std::uint32_t>(patch_vertices(terrain.info().level));
  Settled done;
  const std::uint32_t most = std::clamp(PendingDig::kFittedVertices / of_patch, 1u, PendingDig::kFitted);
  for (std::uint32_t n = 0; n < most; ++n) {
    if (!fit_next(terrain, part, done, dig.box)) break;
    if (!terrain.is_staged(part)) world.terrain.residency.follow_measures(done.measured);
  }
  return terrain.edit(part).queue->loose() == 0;
}

// As it is where all boxes are exact at once.
void EditorObject::grow_at_last() {
  world.show_box();
  const core::World& terrain = world.terrain.world;
  if (terrain.ground().exists()) {
    world.ground_edits->restore_growth(dig.part, dig.growth);
    if (grow_region(world, dig.part, dig.box, log.exists() ? &log : nullptr)) ground_changed = true;
  }
  if (log.exists() && (dig.alone || dig.ends_stroke)) log.end();
}

// Nobody sees it yet.
void EditorObject::dig_hole() {
  if (log.exists() && dig.alone) log.begin();
  core::World& terrain = world.terrain.world;
  EditChange change;
  const Status status = edit_part(terrain, terrain.spare().region, dig.edit, log.exists() ? &log : nullptr,
                                  change, PendingDig::kExact);
  KARST_ASSERT(status.ok() && change.changed);  // tried before
  static_cast<void>(status);
  dig.box = change.tight;
  dig.touched = static_cast<std::uint32_t>(change.touched.size());
}

void EditorObject::show_dig(EditResult& result) {
  result = {};
  core::World& terrain = world.terrain.world;
  show_region(world);
  const std::size_t n = terrain.parts().size() - 1;
  const WorldPart& part = terrain.parts()[n];
  ground_changed = true;
  ++sky_version;
  shape_version = version + 1;
  world.show_box();
  const glm::dvec3 corner = part.corner;
  show_extent(corner + glm::dvec3(dig.box.min) / double{kStepsPerVoxel},
              corner + glm::dvec3(dig.box.max) / double{kStepsPerVoxel}, result);
  result.patches = dig.touched;
  static_cast<void>(grow_region(world, n, dig.box, log.exists() ? &log : nullptr));
  result.can_undo = log.exists() && !log.is_lost();
  if (log.exists() && (dig.alone || dig.ends_stroke)) log.end();
  result.version = ++version;
}

}  // namespace karst::core
