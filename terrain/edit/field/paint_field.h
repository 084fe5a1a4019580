// SPDX-License-Identifier: MIT
// Painting of a field's voxels (L A.2): a brush mixes a material into what they are made of. Blocks that
// change are kept as they were, each once a part of a step, and exchanged with what is there to take a step
// back or do it again, to the bit.
//
//   FieldChange changed;
//   PaintField{&field, world_materials, kept_in, &log}.run(edit, changed);  // these are to be meshed anew
//   log.undo([&](UndoPart part) { exchange_paint(field, part, changed); });
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/edit/edit.h"
#include "terrain/edit/field/field_brush.h"
#include "terrain/edit/undo_log.h"
#include "terrain/isosurface/field_blocks.h"

namespace karst::core {

// A code with so much of a material: its number plus 1, or 0; share: 0..1. Of three the least is left out,
// and shares are sevenths: less than half of one changes nothing.
std::uint8_t mix_in(std::uint8_t code, unsigned material, double share);

struct PaintField {
  FieldBlocks* field = nullptr;
  std::uint32_t materials = 0;  // that the world has
  // By block: the part of the log's steps that keeps it; empty: each edit is a part of its own.
  std::span<std::uint32_t> kept_in = {};
  UndoLog* log = nullptr;  // null keeps nothing

  // edit: a paint, its place and sizes voxels from the world's corner; by the share amount and the brush's
  // weight (brush.h). Of what is solid and of the air by the surface; not of blocks that are all air.
  // invalid_argument naming the edit's field; limit_reached ("field_material_blocks", value: Config's that
  // are missing). Nothing has changed then. Precondition: there is a field.
  Status run(const Edit& edit, FieldChange& changed) const;
};

// Exchanges what a part keeps with what is there. Precondition: the part's first cell is one of
// field_materials, and the field is as it was after the part, or before it; then it does not fail.
void exchange_paint(FieldBlocks& field, UndoPart part, FieldChange& changed);

// The code of the solid sample nearest to a place, of the eight around it; samples from (0, 0, 0). None is
// solid: that of the nearest.
std::uint8_t material_at(const FieldBlocks& field, const glm::dvec3& place);

}  // namespace karst::core
