// SPDX-License-Identifier: MIT
// Sculpting of a field in memory (L A.2): balls, boxes and capsules are added and taken away, the surface is
// smoothed and drawn to a plane. Samples stay distances in cells, cut off at FieldInfo::reach_cells. Blocks
// that change are kept as they were, each once a part of a step, and exchanged with what is there to take a
// step back or do it again, to the bit.
//
//   FieldChange change;
//   edit_field({&field, kept_in}, edit, &log, change);   // samples change.first..change.last
//   log.undo([&](UndoPart part) { exchange_field(field, part, change); });
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/edit/edit.h"
#include "terrain/edit/field/field_brush.h"
#include "terrain/edit/undo_log.h"
#include "terrain/isosurface/field_blocks.h"

namespace karst::core {

struct EditedField {
  FieldBlocks* field = nullptr;
  // By block: the part of the log's steps that kept it last; may be empty without a log.
  std::span<std::uint32_t> kept_in;
};

// Whether a tool is one of fields'.
constexpr bool edits_fields(EditTool tool) {
  return edits_voxels(tool) || tool == EditTool::smooth || tool == EditTool::flatten ||
         tool == EditTool::level;
}
// Whether what an edit may change reaches into the box of a field's samples; of a wrong one false.
bool reaches_field(const Edit& edit, const FieldInfo& info);

// clear, fill; smooth: towards the mean of the six samples around, by the share amount and the brush's weight
// (brush.h); flatten, level: towards the plane through place likewise. log: null keeps nothing.
// invalid_argument naming the edit's field; limit_reached ("field_sample_blocks", value: Config's that are
// missing). Nothing has changed then. Precondition: there is a field.
Status edit_field(const EditedField& edited, const Edit& edit, UndoLog* log, FieldChange& change);

// Exchanges what a part keeps with what is there. Precondition: the part's first cell is a field_block, and
// the field is as it was after the part, or before it; then it does not fail.
void exchange_field(FieldBlocks& field, UndoPart part, FieldChange& change);

}  // namespace karst::core
