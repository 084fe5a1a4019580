// SPDX-License-Identifier: MIT
// Strokes, undo and redo of karst::Editor.
#include "scene/edit/ground_edits.h"
#include "scene/world/world_object.h"
#include "terrain/edit/undo/take_part.h"

namespace karst {
namespace core {
namespace {

EditorObject& self(karst::Editor* editor) {
  return *static_cast<EditorObject*>(editor);
}

}  // namespace

void EditorObject::begin_stroke() {
  finish();
  end_stroke();
  if (log.exists()) log.begin();
}

void EditorObject::end_stroke() {
  if (dig.stage != PendingDig::Stage::none && !dig.alone) {
    dig.ends_stroke = true;
  } else if (log.is_open()) {
    log.end();
  }
}

// A part of a step that is taken back or done again, and what follows from it for frames and queries.
Status EditorObject::take_part(UndoPart part, bool back, std::uint32_t& regions, EditResult& result) {
  if (part.kind() == CellKind::region_growth) {
    regions |= 1u << world.ground_edits->exchange_growth(part);
    return {};
  }
  if (part.kind() == CellKind::ground_samples) {
    GroundChange change;
    world.ground_edits->exchange(part, change);
    if (change.changed) regions |= world.ground_edits->regions_with(change.samples);
    follow_ground(change, show_ground_change(world, change), result);
    return {};
  }
  if (part.kind() == CellKind::paint) {
    PaintChange change;
    exchange_paint(world.terrain.world, world.span(), part, change);
    follow_paint(change, result);
    return {};
  }
  Status first;
  core::take_part(world.terrain.world, part, back, [&](const EditChange& change) {
    const Status status = follow(change, result);
    if (first.ok()) first = status;
    regions |= 1u << change.part;
  });
  return first;
}

Status EditorObject::take_step(bool back, EditResult& result) {
  finish();
  end_stroke();
  result = {};
  Status first;
  std::uint32_t regions = 0;
  const auto take = [&](UndoPart part) {
    const Status status = take_part(part, back, regions, result);
    if (first.ok()) first = status;
  };
  static_cast<void>(back ? log.undo(take) : log.redo(take));
  const core::World& terrain = world.terrain.world;
  for (std::size_t n = 0; n < terrain.parts().size() && terrain.ground().exists(); ++n) {
    if ((regions >> n & 1u) == 0) continue;
    show_belt(world, n);
    if (measure_region(world, n)) ground_changed = true;
  }
  result.version = result.changed ? ++version : version;
  return first;
}

UndoState EditorObject::undo_state() const {
  return {log.undo_steps(), log.redo_steps(), log.lost_steps()};
}

}  // namespace core

void Editor::begin_stroke() noexcept {
  core::self(this).begin_stroke();
}

void Editor::end_stroke() noexcept {
  core::self(this).end_stroke();
}

Status Editor::undo(EditResult& result) noexcept {
  return core::self(this).take_step(true, result);
}

Status Editor::redo(EditResult& result) noexcept {
  return core::self(this).take_step(false, result);
}

UndoState Editor::undo_state() const noexcept {
  return static_cast<const core::EditorObject*>(this)->undo_state();
}

}  // namespace karst
