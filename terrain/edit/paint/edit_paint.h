// SPDX-License-Identifier: MIT
// Edits of the painted map (BlendMap): materials by brush, over patches and ground alike, in memory of the
// world. A texel lies over a whole column: of a brush, its place along x and z counts. Patches that paint
// reaches are drawn with the map (kPaintedByMap), as karst-bake marks them.
//
//   PaintChange change;
//   edit_paint(world, span, edit, nullptr, change);   // World::is_paintable()
//   // change.texels are to be uploaded, and materials where they changed
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/edit/edit.h"
#include "terrain/edit/undo_log.h"
#include "terrain/shading/painted_texels.h"
#include "terrain/world/world.h"

namespace karst::core {

// As an edit's material: no paint, so that the rules decide again.
inline constexpr std::uint8_t kNoPaint = 255;

struct PaintChange {
  bool changed = false;
  TexelRect texels;        // that may be others
  bool materials = false;  // of the map's channels
  bool patches = false;    // some are drawn with the map now, or no longer
};

// What the map of a world lies over.
BlendSpan blend_span(const WorldInfo& info, const GroundInfo& ground);

// Towards a texel's whole weight for the material by the edit's `amount` and the brush's weight; others give
// way by the same share. Weights are rounded to 255ths, 255 of them together at most. A material that has no
// channel takes one that is not used.
//
// unsupported ("ground"): a curved basis. invalid_argument names the field: "material" also where four others
// are painted. log: null, or with a step open. Nothing has changed after an error.
Status edit_paint(World& world, const BlendSpan& span, const Edit& edit, UndoLog* log, PaintChange& change);

// A part of a step of the log that edit_paint() made, taken back or done again.
void exchange_paint(World& world, const BlendSpan& span, UndoPart part, PaintChange& change);

// After patches changed: whether they are painted. True: some are drawn otherwise.
bool mark_painted(World& world, const BlendSpan& span, std::span<const PatchId> patches);

}  // namespace karst::core
