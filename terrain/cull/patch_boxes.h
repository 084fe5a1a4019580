// SPDX-License-Identifier: MIT
// What culling reads of patches, eight in a row at a time and value by value, so that four are tested at once
// and none of their 28 + 32 + 12 bytes elsewhere is touched. 19 bytes a patch.
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "terrain/base/simd.h"
#include "terrain/patch/bounds.h"
#include "terrain/surface/patch.h"
#include "terrain/view/frustum.h"

namespace karst::core {

// Patches 8 n .. 8 n + 7, those that a node of BoundsTree's row 0 covers. Lanes without a patch are 0.
struct PatchBoxes {
  static constexpr std::uint32_t kPatches = 8;
  static constexpr std::uint32_t count_for(std::uint32_t patches) {
    return (patches + kPatches - 1) / kPatches;
  }

  std::int16_t corner[3][kPatches];  // of the volume, voxels
  std::int16_t min[3][kPatches];     // PatchBounds
  std::int16_t max[3][kPatches];
  std::uint8_t collapsed;  // bit p: Patch::collapsed
  std::uint8_t free;       // bit p: there is none in the slot
  std::uint8_t reserved[6];

  glm::ivec3 origin(unsigned p) const {
    return glm::ivec3(corner[0][p], corner[1][p], corner[2][p]) * kStepsPerVoxel;
  }
  LatticeBox box(unsigned p) const {
    return {origin(p) + glm::ivec3(min[0][p], min[1][p], min[2][p]),
            origin(p) + glm::ivec3(max[0][p], max[1][p], max[2][p])};
  }
};
static_assert(sizeof(PatchBoxes) == 152);

// out: count_for(all of the surface's patches). Fills those that hold patches first .. last - 1.
// Precondition: one box a patch, last <= patches.
void fill_patch_boxes(const Surface& surface, std::span<const PatchBounds> bounds, PatchId first,
                      PatchId last, std::span<PatchBoxes> out);

// Four of the boxes: lanes 0..3 are patches 4 half .. 4 half + 3. The very values of the scalar functions.
struct FourBoxes {
  simd::Int4 origin[3];  // lattice steps
  simd::Float4 min[3];   // of the box
  simd::Float4 max[3];

  FourBoxes(const PatchBoxes& boxes, unsigned half) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto four = [&](const std::int16_t(&values)[8]) {
        return simd::to_int(simd::load<simd::Short4>(values + 4 * half));
      };
      origin[axis] = four(boxes.corner[axis]) << kLatticeBits;
      min[axis] = simd::to_float(origin[axis] + four(boxes.min[axis]));
      max[axis] = simd::to_float(origin[axis] + four(boxes.max[axis]));
    }
  }

  // Bit l: lane l is wholly outside the plane, as classify() has it.
  unsigned outside(const Plane& plane) const {
    simd::Float4 inmost = simd::splat(plane.offset);
    for (int axis = 0; axis < 3; ++axis) {
      const simd::Float4 normal = simd::splat(plane.normal[axis]);
      inmost += simd::max(normal * min[axis], normal * max[axis]);
    }
    return simd::lanes(inmost < simd::splat(0.0f));
  }
};

}  // namespace karst::core
