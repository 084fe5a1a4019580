// SPDX-License-Identifier: MIT
// All that is measured of patches once their heights are known: the errors of coarser levels, boxes, and the
// cones of normals that are drawn and that shade. Of a whole world when it is baked, or of the patches that
// an edit touched; the numbers are the same.
//
//   touched = find_touched(surface, changed, room)          // after an edit; a bake leaves `list` empty
//   MeasurePatches measure{surface, heights, touched, borders, out};
//   measure.measure(0, measure.count(), room);  measure.join(0, measure.count());
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/measure/level_error.h"
#include "terrain/measure/normal_cone.h"
#include "terrain/patch/bounds.h"
#include "terrain/patch/generate_vertices.h"
#include "terrain/patch/gpu_vertex.h"
#include "terrain/patch/heights.h"
#include "terrain/surface/patch.h"

namespace karst::core {

// By patch; borrowed.
struct PatchMeasures {
  std::span<std::uint16_t> level_errors;  // as LevelErrors::values
  std::span<PatchBounds> bounds;
  std::span<NormalCone> cones;
  std::span<NormalCone> shading_cones;
};

struct MeasurePatches {
  // Inputs, borrowed.
  Surface surface;
  Heights heights;  // its level is the full one

  // Which patches: ascending, each once, none of them free. Empty: all of the surface; then free slots are
  // left alone. Others need to be measured as well where something changed: find_touched().
  std::span<const PatchId> list;

  // Working memory, borrowed: count().
  std::span<BorderErrors> borders;

  // Output: entries of patches that are not measured stay as they are.
  PatchMeasures out;

  // Working memory of a thread.
  struct Room {
    PatchScratch* scratch = nullptr;  // make_patch_scratch()
    std::span<GpuVertex> vertices;    // patch_vertices(heights.level)
  };

  // Patches that are measured.
  std::size_t count() const { return list.empty() ? surface.patches.size() : list.size(); }

  // invalid_argument naming the first field of another size than the surface or the list, heights.level out
  // of range, or a list that does not ascend or names a free slot.
  Status validate() const;

  // The first..last - 1 of those that are measured: measure() all of them, then join() all; ranges of each
  // may run on several threads. Precondition: validate() is ok.
  void measure(std::size_t first, std::size_t last, const Room& room) const;
  void join(std::size_t first, std::size_t last) const;

 private:
  PatchId patch_at(std::size_t index) const {
    return list.empty() ? static_cast<PatchId>(index) : list[index];
  }
  bool is_free(PatchId patch) const { return surface.patches[patch].volume == kNoVolume; }
  std::span<std::uint16_t> errors_of(PatchId patch) const;
  const BorderErrors* borders_of(PatchId patch) const;
};

// The patches whose measures depend on the heights, the volumes or the edges of the changed ones: these and
// all that share a corner with them, ascending, each once. changed: in any order, none of them free. Returns
// the part of room that holds them. limit_reached ("room") where it is too short; it may take a few entries
// more than there are patches.
Status find_touched(const Surface& surface, std::span<const PatchId> changed, std::span<PatchId> room,
                    std::span<const PatchId>& touched);

}  // namespace karst::core
