// SPDX-License-Identifier: MIT
// What casts into a cascade's shadow map (cascades.h), and at which level.
//
// A patch casts no finer than the map can show: at the coarsest level that strays by no more than a share of
// a texel, if its place does not ask for a coarser one. Neighbours are at most one level apart: the coarser
// one is raised, so that no patch strays by more. That keeps what morph.h promises, because a patch is never
// raised above what its place asks for: places of neighbours ask for levels at most one apart. So levels
// depend on the world, the cascade and the picture's error alone.
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/cull/bounds_tree.h"
#include "terrain/draw/draw_list.h"
#include "terrain/lod/select_lod.h"
#include "terrain/measure/level_error.h"
#include "terrain/shadow/cascades.h"
#include "terrain/surface/patch.h"

namespace karst::core {

struct SelectCasters {
  LodSettings settings;  // of the picture
  // How far a caster may stray from the full surface, texels, where the picture's error does not allow more.
  double error_texels = 1;
  // What fits into as much memory as level 1 does: no patch that may be finer casts coarser.
  int base_level = 1;

  // Inputs, borrowed.
  const Cascade* cascade = nullptr;
  Surface surface;
  std::span<const PatchBounds> bounds;  // by patch
  const BoundsTree* tree = nullptr;     // over these patches and bounds
  std::span<const PatchLod> lods;       // mode error: by patch, as SetThresholds leaves them for the picture
  LevelErrors errors;                   // of all patches
  std::span<const std::uint8_t> resident;  // by patch: the level that its vertices are held at, 0 for none

  // Outputs, borrowed.
  std::span<std::uint8_t> wanted;    // by patch: the level that it should cast at; 0: not in the box
  std::span<std::uint8_t> levels;    // the same cut to what is held; finer ones are lowered to match
  std::span<std::uint32_t> lacking;  // one value a patch: those in the box that are held coarser than
                                     // wanted come first, those that are not held at all before the others
  std::span<DrawItem> items;         // what casts, by patch

  struct Result {
    std::uint32_t drawn = 0;    // items used
    std::uint32_t lacking = 0;  // patches held coarser than wanted, or not at all
    std::uint32_t triangles = 0;
  };

  // invalid_argument naming the first field that is missing or of another size than the surface.
  Status validate() const;
  // Precondition: validate() is ok. limit_reached naming max_draw_items where items is too small: the first
  // patches are listed. Work follows what the box holds, but for a byte or two a patch that are cleared.
  Status run(Result& result) const;
};

}  // namespace karst::core
