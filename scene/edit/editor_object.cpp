// SPDX-License-Identifier: MIT
// karst::Editor.
#include <chrono>
#include <limits>

#include <glm/common.hpp>

#include "scene/edit/dig_ground.h"
#include "scene/edit/ground_edits.h"
#include "scene/world/world_object.h"
#include "terrain/base/check.h"
#include "terrain/edit/patch/edit_heights.h"
#include "terrain/edit/save_world.h"
#include "terrain/edit/settle.h"
#include "tiles/write_tile.h"

namespace karst {
namespace core {
namespace {

static_assert(static_cast<int>(karst::EditTool::paint) == static_cast<int>(EditTool::paint));
static_assert(static_cast<int>(karst::BrushShape::cylinder) == static_cast<int>(BrushShape::cylinder));
static_assert(kNoMaterial == kNoPaint);

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
  out.octree_depth = static_cast<std::uint8_t>(world.shown.octree_depth);
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
  if (const Status status = begin(edit, false, result); !status.ok() || !result.pending) return status;
  while (!step_dig(result)) {
  }
  return {};
}

// Of what makes a region, the first part.
Status EditorObject::begin(const karst::Edit& edit, bool spreads, EditResult& result) {
  finish();
  result = {};
  result.version = version;
  // In a stroke a step is open.
  const bool alone = log.exists() && !log.is_open();
  if (alone) log.begin();
  dig.spreads = spreads;
  const Status status = make(in_voxels(edit), result);
  result.can_undo = result.changed && log.exists() && !log.is_lost();
  if (alone && dig.stage != PendingDig::Stage::boxes) log.end();
  if (result.changed) result.version = ++version;
  if (result.pending) dig.alone = alone;
  return status;
}

Status EditorObject::make(const core::Edit& edit, EditResult& result) {
  UndoLog* const kept = log.exists() ? &log : nullptr;
  core::World& terrain = world.terrain.world;
  if (edit.tool == EditTool::paint && is_of_field(edit)) {
    FieldChange change;
    const PaintField paint{&terrain.field(), terrain.materials().count, terrain.field_kept(), kept};
    const Status status = paint.run(edit, change);
    follow_field(change, result);
    return status;
  }
  if (edit.tool == EditTool::paint) {
    PaintChange change;
    const Status status = edit_paint(terrain, world.span(), edit, kept, change);
    follow_paint(change, result);
    return status;
  }
  if (is_of_field(edit)) {
    FieldChange change;
    const Status status = edit_field({&terrain.field(), terrain.field_kept()}, edit, kept, change);
    follow_field(change, result);
    return status;
  }
  if (terrain.ground().exists() && !edits_voxels(edit.tool)) return make_heights(edit, kept, result);
  if (const Status status = check_edit(edit, terrain); !status.ok()) return status;
  if (edits_voxels(edit.tool) && wants_region(terrain, edit)) return begin_dig(edit, result);
  if (terrain.ground().exists()) {
    if (const Status status = reserve_region(world, edit); !status.ok()) return status;
  }
  EditChange change;
  if (edits_heights(edit.tool)) {
    const Status status = edit_heights(terrain, edit, kept, change);
    return status.ok() ? follow(change, result) : status;
  }
  if (const Status status = part_of_edit(edit, terrain, change.part); !status.ok()) return status;
  const std::size_t exact = dig.spreads ? PendingDig::kExact : MeasureQueue::kAll;
  Status status = edit_part(terrain, change.part, edit, kept, change, exact);
  if (!status.ok()) return status;
  status = follow(change, result);
  if (change.changed && terrain.edit(change.part).queue->loose() > 0) {
    fit_later(change);
    result.pending = true;
    return status;
  }
  if (change.changed && terrain.ground().exists() && grow_region(world, change.part, change.box, kept))
    ground_changed = true;
  return status;
}

// What reaches a field is of it alone.
bool EditorObject::is_of_field(const core::Edit& edit) const {
  const core::World& terrain = world.terrain.world;
  // Belts and thresholds around one in a ground are made for it as it was baked.
  if (!terrain.field().exists() || terrain.field().info().in_region) return false;
  const bool is_alone = terrain.patch_count() == 0 && !terrain.ground().exists();
  const bool is_one = edits_fields(edit.tool) || edit.tool == EditTool::paint;
  // Without room for voxels' materials, paint lies in the blend map, over it as over all else.
  if (edit.tool == EditTool::paint && !terrain.field().materials().exists()) return false;
  return is_alone || (is_one && reaches_field(edit, terrain.field().info()));
}

// Of a ground and of the patches that stand in it: all of it or nothing.
Status EditorObject::make_heights(const core::Edit& edit, UndoLog* kept, EditResult& result) {
  core::World& terrain = world.terrain.world;
  std::uint32_t regions = 0, nodes = 0;
  if (const Status status = plan_heights(world, edit, regions); !status.ok()) return status;
  GroundChange change;
  if (const Status status = edit_ground(world, edit, kept, change, nodes); !status.ok()) return status;
  follow_ground(change, nodes, result);
  const std::uint32_t beneath = change.changed ? world.ground_edits->regions_with(change.samples) : 0;
  Status first;
  for (std::size_t n = 0; n < terrain.parts().size(); ++n) {
    const bool own = (regions >> n & 1u) != 0, below = (beneath >> n & 1u) != 0;
    if (!own && !below) continue;
    LatticeBox box = below ? box_in_region(world, n, change) : LatticeBox{};
    if (own) {
      EditChange patches;
      Status status = edit_heights(terrain, n, edit, kept, patches);
      KARST_ASSERT(status.ok());  // planned
      status = follow(patches, result);
      if (first.ok()) first = status;
      const LatticeBox all = patches.box;
      box = below ? LatticeBox{glm::min(box.min, all.min), glm::max(box.max, all.max)} : all;
      show_belt(world, n);
    }
    if (grow_region(world, n, box, kept)) ground_changed = true;
  }
  // Of others nothing changed but what is measured of the ground around them.
  const std::uint32_t looking = change.changed ? world.ground_edits->regions_looking_at(change.samples) : 0;
  for (std::size_t n = 0; n < terrain.parts().size(); ++n) {
    if ((looking & ~regions & ~beneath) >> n & 1u && measure_region(world, n)) ground_changed = true;
  }
  return first;
}

// Vertices say what their patch needs of shading.
void EditorObject::follow_paint(const PaintChange& change, EditResult& result) {
  if (!change.changed) return;
  unshown.changed = true;
  unshown.texels.join(change.texels);
  unshown.materials = unshown.materials || change.materials;
  const BlendMap& map = world.terrain.world.materials().blend_map;
  world.shown.blend_map[0] = map.width;
  world.shown.blend_map[1] = map.depth;
  const BlendSpan span = world.span();
  const glm::dvec2 texel = span.size / glm::dvec2(map.width, map.depth);
  const glm::dvec2 low = span.low + glm::dvec2(change.texels.low) * texel;
  const glm::dvec2 high = span.low + glm::dvec2(change.texels.high) * texel;
  const LatticeBox box = world.terrain.world.box();
  show_extent({low.x, box.min.y / double{kStepsPerVoxel}, low.y},
              {high.x, box.max.y / double{kStepsPerVoxel}, high.y}, result);
  if (!change.patches) return;
  for (std::size_t part = 0; part < world.terrain.world.parts().size(); ++part)
    world.terrain.residency.follow_sky(part);
}

void EditorObject::follow_ground(const GroundChange& change, std::uint32_t nodes, EditResult& result) {
  if (!change.changed) return;
  shape_version = version + 1;
  ground_changed = true;
  world.show_box();
  const GroundInfo& ground = world.terrain.world.ground();
  const auto voxels = [&](std::int64_t i, std::int32_t height, std::int64_t k) {
    return glm::dvec3(ground.steps[0] * static_cast<double>(i), double{kVertexStep} * height,
                      ground.steps[1] * static_cast<double>(k)) /
           double{kStepsPerVoxel};
  };
  show_extent(voxels(change.samples.low[0], change.least, change.samples.low[1]),
              voxels(change.samples.high[0], change.greatest, change.samples.high[1]), result);
  result.nodes += nodes;
}

void EditorObject::follow_field(const FieldChange& change, EditResult& result) {
  if (!change.changed) return;
  shape_version = version + 1;
  world.terrain.isosurface.change(change.first, change.last);
  const FieldInfo& info = world.terrain.world.field().info();
  const double voxels = 1.0 / (1 << (kMostCellLog2 - info.cell_log2));  // a cell
  // The surface lies between samples.
  show_extent(glm::dvec3(info.corner) + glm::dvec3(change.first - 1) * voxels,
              glm::dvec3(info.corner) + glm::dvec3(change.last + 1) * voxels, result);
}

void EditorObject::show_extent(const glm::dvec3& low_voxels, const glm::dvec3& high_voxels,
                               EditResult& result) const {
  const glm::dvec3 side[2] = {low_voxels, high_voxels};
  glm::dvec3 low = to_glm(result.low), high = to_glm(result.high);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 at = to_glm(world.placement.place_of_voxels(
        {side[corner & 1].x, side[corner >> 1 & 1].y, side[corner >> 2 & 1].z}));
    const bool first = corner == 0 && !result.changed;
    low = first ? at : glm::min(low, at);
    high = first ? at : glm::max(high, at);
  }
  result.changed = true;
  result.low = from_glm(low);
  result.high = from_glm(high);
}

Status EditorObject::follow(const EditChange& change, EditResult& result) {
  if (!change.changed) return {};
  shape_version = version + 1;
  core::World& terrain = world.terrain.world;
  if (terrain.is_paintable()) static_cast<void>(mark_painted(terrain, world.span(), change.touched));
  world.terrain.residency.follow_edit(change.touched, change.rows, change.vanished);
  for (QueryObject& query : world.queries) {
    query.asked.forget(change.touched);
    query.asked.forget(change.vanished);
  }
  world.show_box();
  const glm::dvec3 corner = world.terrain.world.parts()[change.part].corner;
  show_extent(corner + glm::dvec3(change.box.min) / double{kStepsPerVoxel},
              corner + glm::dvec3(change.box.max) / double{kStepsPerVoxel}, result);
  result.patches += static_cast<std::uint32_t>(change.touched.size());
  return {};
}

void EditorObject::settle(double most_ms) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  const auto spent_ms = [&] {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  };
  core::World& terrain = world.terrain.world;
  // Frames leave boxes to advance(): queries read them.
  while (dig.stage != PendingDig::Stage::boxes && !terrain.is_settled() && spent_ms() < most_ms) {
    Settled done;
    settle_some(terrain, done);
    if (done.measured != Settled::kNone) world.terrain.residency.follow_measures(done.measured);
    if (!done.sky_changed) continue;
    world.terrain.residency.follow_sky(done.part);
    ++sky_version;
  }
  // Regions are measured over a ground that is, and what follows from that is the ground's again.
  const EditGround* const ground = world.ground_edits;
  const auto settle_all = [&] {
    while (ground != nullptr && !ground->is_settled() && spent_ms() < most_ms) settle_ground(world);
  };
  settle_all();
  while (dig.stage != PendingDig::Stage::boxes && loose != 0 && spent_ms() < most_ms) {
    if (measure_columns(world)) ground_changed = true;
  }
  settle_all();
}

bool EditorObject::is_settled() const {
  return world.terrain.world.is_settled() && loose == 0 &&
         (world.ground_edits == nullptr || world.ground_edits->is_settled());
}

Status EditorObject::save(const Sink& sink) {
  if (sink.write == nullptr) return {StatusCode::invalid_argument, "missing", "sink"};
  finish();
  settle(std::numeric_limits<double>::infinity());
  const ByteSink bytes{&sink, [](const void* context, std::span<const std::byte> piece) {
                         const auto& host = *static_cast<const Sink*>(context);
                         return host.write(host.user, piece);
                       }};
  const core::World& terrain = world.terrain.world;
  const std::span<PatchId> room = world.terrain.residency.lend_list();
  if (!ground_changed) return SaveWorld{&terrain, nullptr, room}.run(bytes);
  static_assert(tiles::kWriteTileRoom <= EditGround::kWritingRoom);
  SaveTiles tiles = world.ground_edits->saving(terrain.reader(), tiles::write_tile);
  if (const Status status = tiles.plan(); !status.ok()) return status;
  return SaveWorld{&terrain, tiles.added(), room}.run(bytes);
}

}  // namespace core

Status Editor::apply(const Edit& edit, EditResult& result) noexcept {
  return core::self(this).apply(edit, result);
}

Status Editor::start(const Edit& edit, EditResult& result) noexcept {
  return core::self(this).start(edit, result);
}

bool Editor::is_pending() const noexcept {
  return static_cast<const core::EditorObject*>(this)->is_pending();
}

void Editor::advance(EditResult& result) noexcept {
  core::self(this).advance(result);
}

Status Editor::save(const Sink& sink) noexcept {
  return core::self(this).save(sink);
}

}  // namespace karst
