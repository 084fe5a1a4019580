// SPDX-License-Identifier: MIT
// Strokes, undo and redo of karst::Editor.
#include <chrono>
#include <limits>
#include <optional>

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
  if (dig.stage != PendingDig::Stage::none) {
    dig.ends_stroke = !dig.alone;
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
    if (change.changed) {
      regions |= world.ground_edits->regions_with(change.samples);
      regions |= world.ground_edits->regions_looking_at(change.samples);
    }
    follow_ground(change, show_ground_change(world, change), result);
    return {};
  }
  if (part.kind() == CellKind::field_block || part.kind() == CellKind::field_materials) {
    FieldChange change;
    FieldBlocks& field = world.terrain.world.field();
    const bool is_paint = part.kind() == CellKind::field_materials;
    is_paint ? exchange_paint(field, part, change) : exchange_field(field, part, change);
    follow_field(change, result);
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

Status EditorObject::take_step(bool back, double most_ms, EditResult& result) {
  if (!log.is_taking() || log.takes_back() != back) finish();
  end_stroke();
  result = {};
  const Status status = take_parts(back, most_ms, result);
  result.version = result.changed ? ++version : version;
  return status;
}

Status EditorObject::take_parts(bool back, double most_ms, EditResult& result) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  Status first;
  std::uint32_t regions = 0;
  do {
    const std::optional<UndoPart> part = log.next(back);
    if (!part) break;
    const Status status = take_part(*part, back, regions, result);
    if (first.ok()) first = status;
  } while (log.is_taking() &&
           std::chrono::duration<double, std::milli>(Clock::now() - start).count() < most_ms);
  const core::World& terrain = world.terrain.world;
  for (std::size_t n = 0; n < terrain.parts().size() && terrain.ground().exists(); ++n) {
    if ((regions >> n & 1u) == 0) continue;
    show_belt(world, n);
    if (measure_region(world, n)) ground_changed = true;
  }
  return first;
}

UndoState EditorObject::undo_state() const {
  return {log.undo_steps(), log.redo_steps(), log.lost_steps(), log.is_taking()};
}

}  // namespace core

void Editor::begin_stroke() noexcept {
  core::self(this).begin_stroke();
}

void Editor::end_stroke() noexcept {
  core::self(this).end_stroke();
}

Status Editor::undo(EditResult& result) noexcept {
  return core::self(this).take_step(true, std::numeric_limits<double>::infinity(), result);
}

Status Editor::undo(EditResult& result, double most_ms) noexcept {
  return core::self(this).take_step(true, most_ms, result);
}

Status Editor::redo(EditResult& result) noexcept {
  return core::self(this).take_step(false, std::numeric_limits<double>::infinity(), result);
}

Status Editor::redo(EditResult& result, double most_ms) noexcept {
  return core::self(this).take_step(false, most_ms, result);
}

UndoState Editor::undo_state() const noexcept {
  return static_cast<const core::EditorObject*>(this)->undo_state();
}

}  // namespace karst
