// SPDX-License-Identifier: MIT
// Heights of patches that an edit made: what they share with others is what those have, and from there the
// surface goes on smoothly. Corners between new patches become the mean of those around them, edges between
// them run straight, and inside each patch its four borders are blended (Coons 1967). Integers alone, in the
// order of keys: slots don't matter.
#pragma once

#include <cstdint>
#include <span>

#include "terrain/resident/height_cache.h"
#include "terrain/surface/bezier/update_surface.h"
#include "terrain/surface/patch.h"

namespace karst::core {

struct NewHeights {
  // Inputs, borrowed.
  Surface surface;
  std::span<const PatchChange> changes;  // as UpdateSurface leaves them; those that appeared or are reshaped
  int level = 1;                         // of the heights, 1..kMaxLevel

  // Outputs, borrowed: block first_block + n of patch n; Patch::height_block, kNoHeights where all of them
  // are 0.
  std::uint32_t first_block = 0;
  std::span<Patch> patches;  // the surface's
  HeightCache* heights = nullptr;

  void run() const;

 private:
  bool is_new(const PatchChange& change) const {
    return change.kind == PatchChange::appeared || change.kind == PatchChange::reshaped;
  }
  template <class Visit>
  void for_each_new(const Visit& visit) const;
  std::span<std::int16_t> block(PatchId patch) const { return heights->block(first_block + patch); }
  std::int16_t at(PatchId patch, int i, int j) const;
  void set(PatchId patch, int i, int j, std::int32_t height) const;
  void find_corners() const;
  bool smooth_corner(PatchId patch, int corner) const;
  void fill_borders(PatchId patch) const;
  void fill_inside(PatchId patch) const;
};

}  // namespace karst::core
