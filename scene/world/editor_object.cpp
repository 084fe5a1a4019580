// SPDX-License-Identifier: MIT
// karst::Editor.
#include "scene/world/world_object.h"

#include <glm/common.hpp>

#include "terrain/edit/save_world.h"

namespace karst {
namespace core {
namespace {

static_assert(static_cast<int>(karst::EditTool::paint) == static_cast<int>(EditTool::paint));
static_assert(static_cast<int>(karst::BrushShape::cylinder) == static_cast<int>(BrushShape::cylinder));

EditorObject& self(karst::Editor* editor) {
  return *static_cast<EditorObject*>(editor);
}

}  // namespace

core::Edit EditorObject::in_voxels(const karst::Edit& edit) const {
  const PlacementFrame& placement = world.placement;
  const double voxels = 1 / placement.world().voxel_size_m;
  core::Edit out;
  out.tool = static_cast<EditTool>(edit.tool);
  out.shape = static_cast<BrushShape>(edit.shape);
  out.octree_level = edit.octree_level;
  out.material = edit.material;
  out.place = placement.voxels(edit.place);
  out.to = placement.voxels(edit.to);
  out.half = to_glm(edit.half_m) * voxels;
  out.up = placement.world_direction(edit.up);
  out.radius = edit.radius_m * voxels;
  out.strength = edit.strength_m * voxels;
  out.amount = edit.amount;
  out.hardness = edit.hardness;
  out.wave = edit.wave_m * voxels;
  out.seed = edit.seed;
  return out;
}

Status EditorObject::apply(const karst::Edit& edit, EditResult& result) {
  result = {};
  result.version = version;
  const core::Edit made = in_voxels(edit);
  core::World& terrain = world.terrain.world;
  if (const Status status = check_edit(made, terrain); !status.ok()) return status;
  if (!edits_voxels(made.tool))
    return {StatusCode::invalid_argument, "voxels alone can be edited so far", "tool"};
  EditChange change;
  if (const Status status = edit_shape(terrain, made, change); !status.ok()) return status;
  return change.changed ? follow(change, result) : Status();
}

Status EditorObject::follow(const EditChange& change, EditResult& result) {
  ++version;
  if (change.sky_changed) sky_version = version;
  const Status status = world.terrain.residency.follow_edit(change.touched, change.vanished);
  for (QueryObject& query : world.queries) {
    query.asked.forget(change.touched);
    query.asked.forget(change.vanished);
  }
  world.show_box();
  result.changed = true;
  result.version = version;
  result.patches = static_cast<std::uint32_t>(change.touched.size());
  const glm::dvec3 side[2] = {glm::dvec3(change.box.min) / double{kStepsPerVoxel},
                              glm::dvec3(change.box.max) / double{kStepsPerVoxel}};
  glm::dvec3 low(0.0), high(0.0);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 at = to_glm(world.placement.place_of_voxels(
        {side[corner & 1].x, side[corner >> 1 & 1].y, side[corner >> 2 & 1].z}));
    low = corner == 0 ? at : glm::min(low, at);
    high = corner == 0 ? at : glm::max(high, at);
  }
  result.low = from_glm(low);
  result.high = from_glm(high);
  return status;
}

Status EditorObject::save(const Sink& sink) {
  if (sink.write == nullptr) return {StatusCode::invalid_argument, "missing", "sink"};
  const ByteSink bytes{&sink, [](const void* context, std::span<const std::byte> piece) {
                         const auto& host = *static_cast<const Sink*>(context);
                         return host.write(host.user, piece);
                       }};
  return SaveWorld{&world.terrain.world, nullptr, world.terrain.residency.lend_list()}.run(bytes);
}

}  // namespace core

Status Editor::apply(const Edit& edit, EditResult& result) noexcept {
  return core::self(this).apply(edit, result);
}

Status Editor::save(const Sink& sink) noexcept {
  return core::self(this).save(sink);
}

// Of strokes and steps nothing is kept.
void Editor::begin_stroke() noexcept {}
void Editor::end_stroke() noexcept {}
Status Editor::undo(EditResult& result) noexcept {
  result = {};
  return {};
}
Status Editor::redo(EditResult& result) noexcept {
  result = {};
  return {};
}
std::uint32_t Editor::undo_steps() const noexcept {
  return 0;
}
std::uint32_t Editor::redo_steps() const noexcept {
  return 0;
}
std::uint64_t Editor::lost_steps() const noexcept {
  return 0;
}

}  // namespace karst
