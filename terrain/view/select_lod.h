// SPDX-License-Identifier: MIT
// Picks the level of detail of every patch for a camera: by error (design 4.7), by distance (K 4.4.2), or the
// finest. Neighbours are at most one level apart (K 4.4.3).
#pragma once

#include <cstdint>
#include <span>

#include "terrain/base/status.h"
#include "terrain/patch/bounds.h"
#include "terrain/patch/level_error.h"
#include "terrain/surface/surface.h"
#include "terrain/view/bounds_tree.h"
#include "terrain/view/camera.h"
#include "terrain/view/frustum.h"
#include "terrain/view/morph.h"

namespace karst {

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
  // Mode error: no drawn point is further than this from the full-level surface. 0.01..1000 pixels. At 1 the
  // largest deviation is about as wide as a triangle's edge line; means are some ten times smaller.
  double error_px = 1.0;
  // Mode distance, K's d_max: patches from here on are drawn at level 1, at half of it at level 2, at a
  // quarter at level 3, and so on. 0..kCameraReach voxels. At 64 a triangle's edge covers 5 to 10 of 720
  // pixels at 60 degrees.
  double distance_voxels = 64.0;

  int top_level() const { return max_level < resident_level ? max_level : resident_level; }
};
inline constexpr double kLeastErrorPx = 0.01;
inline constexpr double kMostErrorPx = 1000.0;

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
  // Where not null, bound_px is that of what it shows; and by error, patches that it culls and that no patch
  // in view has for a neighbour may keep whatever level they have.
  const Frustum* frustum = nullptr;
  LevelErrors errors;  // for bound_px; without values it is infinite where it depends on them

  // Output, borrowed: by patch, 1..settings.top_level(). Two neighbours differ by at most one.
  std::span<std::uint8_t> levels;

  struct Result {
    // Mode distance: patches drawn finer than their distance asks for, because of a neighbour. By error
    // nothing has to be raised (morph.h).
    std::uint32_t raised = 0;
    // No point that is drawn in front of the near plane is further from the full-level surface. Mode error:
    // error_px, and more only where top_level() is below the level of the errors and a patch would need more.
    float bound_px = 0;
  };

  // invalid_argument naming the first field that is missing, outside its range, or of another size than the
  // surface.
  Status validate() const;

  // Precondition: validate() is ok. Neither fails nor allocates.
  Result run() const;
};

}  // namespace karst
