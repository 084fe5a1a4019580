// SPDX-License-Identifier: MIT
// Edits that make a region, part by part: the region, the hole in it, and then all see both.
#include <algorithm>
#include <numeric>

#include <glm/common.hpp>

#include "scene/edit/dig_ground.h"
#include "scene/edit/ground_edits.h"
#include "scene/world/world_object.h"
#include "terrain/base/check.h"
#include "terrain/edit/paint/edit_paint.h"
#include "terrain/edit/shape/edit_shape.h"

namespace karst::core {
namespace {

using Stage = PendingDig::Stage;

// What two edits changed, as one.
void join(EditResult& told, const EditResult& more) {
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
  return begin(edit, result);
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
      dig.stage = Stage::show;
      return false;
    case Stage::show:
      show_dig(result);
      dig.stage = Stage::none;
      return true;
  }
  return true;
}

// Nobody sees it yet.
void EditorObject::dig_hole() {
  if (log.exists() && dig.alone) log.begin();
  core::World& terrain = world.terrain.world;
  EditChange change;
  const Status status =
      edit_part(terrain, terrain.spare().region, dig.edit, log.exists() ? &log : nullptr, change);
  KARST_ASSERT(status.ok() && change.changed);  // tried before
  static_cast<void>(status);
  dig.box = change.box;
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
