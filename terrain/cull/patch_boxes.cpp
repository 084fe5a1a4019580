// SPDX-License-Identifier: MIT
#include "terrain/cull/patch_boxes.h"

#include "terrain/base/check.h"

namespace karst::core {

void fill_patch_boxes(const Surface& surface, std::span<const PatchBounds> bounds, PatchId first,
                      PatchId last, std::span<PatchBoxes> out) {
  const auto patches = static_cast<std::uint32_t>(surface.patches.size());
  KARST_ASSERT(bounds.size() == patches && last <= patches);
  KARST_ASSERT(out.size() >= PatchBoxes::count_for(patches));
  for (std::uint32_t n = first / PatchBoxes::kPatches; n < PatchBoxes::count_for(last); ++n) {
    PatchBoxes& boxes = out[n];
    boxes = {};
    for (std::uint32_t p = 0; p < PatchBoxes::kPatches; ++p) {
      const PatchId id = n * PatchBoxes::kPatches + p;
      if (id >= patches) break;
      const Volume& volume = surface.volume_of(id);
      if (surface.is_free(id)) boxes.free |= static_cast<std::uint8_t>(1u << p);
      for (int axis = 0; axis < 3; ++axis) {
        boxes.corner[axis][p] = static_cast<std::int16_t>(volume.corner[axis]);
        boxes.min[axis][p] = bounds[id].min[axis];
        boxes.max[axis][p] = bounds[id].max[axis];
      }
      if (surface.patches[id].collapsed != 0) boxes.collapsed |= static_cast<std::uint8_t>(1u << p);
    }
  }
}

}  // namespace karst::core
