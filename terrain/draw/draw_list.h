// SPDX-License-Identifier: MIT
// What a pass draws: one item a visible patch, nearest first, so that hidden pixels fail the depth test
// early.
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/cull/cull_view.h"
#include "terrain/measure/normal_cone.h"
#include "terrain/surface/patch.h"
#include "terrain/view/camera.h"

namespace karst::core {

struct DrawItem {
  PatchId patch;
  std::uint8_t level;        // level of detail it is drawn at, 1..kMaxLevel
  std::uint8_t lower_edges;  // bit e: the neighbour across edge e has a level one lower, as SelectLod leaves
                             // it whether or not it is in view
  std::uint8_t skipped_edges;  // bit e: edge e is a point; the triangles that stand on it have no area and
                               // are left out
  std::uint8_t walls = 0;      // of nodes of the ground, bit e: it ends at edge e, in a wall down from there

  friend bool operator==(const DrawItem&, const DrawItem&) = default;
};
static_assert(sizeof(DrawItem) == 8);

// levels: by patch, as SelectLod leaves them.
DrawItem make_draw_item(const Surface& surface, std::span<const std::uint8_t> levels, PatchId id);

struct BuildDrawList {
  // Most patches that a surface may have.
  static constexpr std::uint32_t kMaxPatches = BoundsTree::kMaxPatches;

  // Inputs, borrowed.
  const Camera* camera = nullptr;        // whose eye "nearest" is measured from
  Surface surface;                       // at most kMaxPatches patches
  std::span<const PatchBoxes> boxes;     // of its patches
  std::span<const CulledEight> culled;   // CullView's, of the camera; without data: every patch is in view
  bool shows_hidden = false;             // patches that rock hides are listed: something in view is missing
  std::span<const std::uint8_t> levels;  // by patch, as SelectLod leaves them; 0 is not drawn
  std::span<const NormalCone> cones;     // by patch; empty: back-facing patches are listed
  float least_pixels = 0;                // ErrorScale's, for cones; 0: of exact geometry, without pixels

  // Working memory, borrowed: one value a patch; contents do not matter.
  std::span<std::uint32_t> scratch;

  // Output, borrowed.
  std::span<DrawItem> items;

  struct Result {
    std::uint32_t drawn = 0;                     // items used, from the front
    std::uint32_t culled_frustum = 0;            // patches outside the view
    std::uint32_t culled_backface = 0;           // patches in view that face away with all that they have
    std::uint32_t culled_occluded = 0;           // patches in view that rock hides
    std::uint32_t missing = 0;                   // patches in view at level 0
    std::uint32_t dropped = 0;                   // patches in view that items had no room for
    std::uint32_t triangles = 0;                 // of the items, all edges' batches counted as they are drawn
    std::uint32_t at_level[kMaxLevel + 1] = {};  // items at each level; [0] is 0
  };

  // invalid_argument naming the first field that is missing, not finite, or of another size than the surface.
  Status validate() const;

  // Precondition: validate() is ok. Items come in bands of distance (3 to 6 % wide) from the eye to the
  // patch's origin, nearest first, and by patch in a band. limit_reached, naming max_draw_items and how many
  // there are to draw, where items is too small: the nearest bands are listed, the list is valid.
  Status run(Result& result) const;
};

}  // namespace karst::core
