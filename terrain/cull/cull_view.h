// SPDX-License-Identifier: MIT
// What is in a view, found once a frame for all that ask: levels, list, what is lacking.
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/cull/bounds_tree.h"
#include "terrain/cull/occlusion.h"
#include "terrain/cull/patch_boxes.h"
#include "terrain/view/frustum.h"

namespace karst::core {

// Eight patches in a row, of which some are in view or have a neighbour that is.
struct CulledEight {
  std::uint32_t n = 0;       // patches 8 n .. 8 n + 7
  std::uint8_t in_view = 0;  // bit p: the box of patch 8 n + p is within all planes
  std::uint8_t hidden = 0;   // of those, bit p: rock hides it
  std::uint16_t reserved = 0;
};
static_assert(sizeof(CulledEight) == 8);

struct CullView {
  // Inputs, borrowed.
  const Frustum* frustum = nullptr;   // null: all patches are in view
  const BoundsTree* tree = nullptr;   // over the patches
  std::span<const PatchBoxes> boxes;  // of the same patches
  Occlusion* occlusion = nullptr;     // begun for the camera, or null: hides nothing
  // By patch, what it was drawn at last, to ask rock only about those that are worth it; may be empty.
  std::span<const std::uint8_t> levels;

  // Output, borrowed: PatchBoxes::count_for(tree->patches()) at least.
  std::span<CulledEight> out;

  // invalid_argument naming the first field that is missing or of another size than the tree.
  Status validate() const;

  // Fills out from the front, n rising, and returns how many. A patch whose box touches that of one in view
  // is among them. Precondition: validate() is ok. Neither fails nor allocates.
  std::uint32_t run() const;
};

}  // namespace karst::core
