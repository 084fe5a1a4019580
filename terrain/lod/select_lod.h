// SPDX-License-Identifier: MIT
// Picks the level of detail of every patch for a camera: by error (design 4.7), by distance (K 4.4.2), or the
// finest. Neighbours are at most one level apart (K 4.4.3).
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/cull/bounds_tree.h"
#include "terrain/cull/cull_view.h"
#include "terrain/lod/morph.h"
#include "terrain/measure/level_error.h"
#include "terrain/measure/normal_cone.h"
#include "terrain/patch/bounds.h"
#include "terrain/surface/patch.h"
#include "terrain/view/camera.h"

namespace karst::core {

enum class LodMode : std::uint8_t {
  error,     // the coarsest levels that keep a bound in pixels; needs vertices to morph
  distance,  // K's formula; nothing morphs
  full,      // every patch at its finest level: the reference that levels of detail are compared with
};

struct LodSettings {
  LodMode mode = LodMode::error;
  int max_level = 5;  // 1..kMaxLevel; no patch is drawn finer
  int resident_level =
      5;  // 1..kMaxLevel; finest level that vertices are held at. The lesser of the two counts
  // Mode error: no drawn point is further than this from the full-level surface. 0.01..1000 pixels. Means are
  // some ten times smaller (docs/run-time-against-error.md).
  double error_px = 4.0;
  // Mode distance, K's d_max: patches from here on are drawn at level 1, at half of it at level 2, at a
  // quarter at level 3, and so on. 0..kCameraReach voxels. At 64 a triangle's edge covers 5 to 10 of 720
  // pixels at 60 degrees.
  double distance_voxels = 64.0;

  int top_level() const { return max_level < resident_level ? max_level : resident_level; }
};
inline constexpr double kLeastErrorPx = 0.01;
inline constexpr double kMostErrorPx = 1000.0;

// A patch in view whose vertices are held at a coarser level than it is wanted at.
struct LackingPatch {
  PatchId patch;
  float px;             // what it can be off by, drawn at the level that is held (at level 1 where none is)
  std::uint8_t wanted;  // 1..settings.top_level()
};

struct SelectLod {
  LodSettings settings;

  // Inputs, borrowed.
  const Camera* camera = nullptr;
  Surface surface;
  std::span<const PatchBounds> bounds;  // by patch
  const BoundsTree* tree = nullptr;     // over these patches and bounds
  ErrorScale scale;                     // make_error_scale for the camera, the picture and error_px
  // Mode error: by patch, as SetThresholds leaves them for scale and settings.top_level().
  std::span<const PatchLod> lods;
  // CullView's, of the camera. bound_px is that of what is in view and not hidden; and by error, patches that
  // are not among them may keep whatever level they have. Without data: all patches are in view.
  std::span<const CulledEight> culled;
  // By patch; empty, or what is drawn leaves out back-facing patches: then they are not in view, either.
  std::span<const NormalCone> cones;
  LevelErrors errors;  // for bound_px; without values it is infinite where it depends on them
  // By patch: the level that its vertices are held at, 0 where there are none. Empty: all are held at
  // settings.resident_level. A patch is not drawn finer than it is held, and finer ones in view are lowered
  // until those that are drawn differ by at most one; where nothing is held nothing is drawn or imposed.
  // Where something is missing, patches that rock hides are in view, too: what hides them may be what is
  // missing.
  std::span<const std::uint8_t> resident;
  // False: what is not held is listed and counted, and levels are those that it will have once it is.
  bool cuts = true;

  // Output, borrowed: by patch, 1..settings.top_level(), and 0 where nothing is held of a patch in view. Two
  // neighbours that are drawn differ by at most one; with `resident` that holds for two in view, and patches
  // out of view have the level that they would have if they were held.
  std::span<std::uint8_t> levels;
  // Output, borrowed, may be empty: the first so many of the patches that `capped` counts, in their order.
  std::span<LackingPatch> lacking;
  // Output, borrowed: patches that are drawn coarser than they are wanted, Result::cut of them. One value a
  // patch; may be empty without `resident`.
  std::span<PatchId> cut;

  struct Result {
    // Mode distance: patches drawn finer than their distance asks for, because of a neighbour. By error
    // nothing has to be raised (morph.h).
    std::uint32_t raised = 0;
    std::uint32_t capped = 0;   // patches in view that are held coarser than wanted, or not at all
    std::uint32_t missing = 0;  // those that are not held at all, and so not drawn
    std::uint32_t lowered = 0;  // patches in view drawn coarser than they are held, because of a neighbour
    std::uint32_t cut = 0;      // patches that are listed in `cut`
    // No point that is drawn in front of the near plane is further from the full-level surface. Mode error:
    // error_px, and more only where top_level() is below the level of the errors and a patch would need more,
    // or where `resident` caps one. A missing patch counts as if it were drawn at level 1.
    float bound_px = 0;
  };

  // invalid_argument naming the first field that is missing, outside its range, or of another size than the
  // surface.
  Status validate() const;

  // Precondition: validate() is ok. Neither fails nor allocates.
  Result run() const;
};

}  // namespace karst::core
