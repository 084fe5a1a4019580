// SPDX-License-Identifier: MIT
// Picks the level of detail of every patch for a camera (K 4.4.2), with neighbours at most one level apart
// (K 4.4.3).
#pragma once

#include <cstdint>
#include <span>

#include "terrain/base/status.h"
#include "terrain/patch/bounds.h"
#include "terrain/surface/surface.h"
#include "terrain/view/bounds_tree.h"
#include "terrain/view/camera.h"

namespace karst {

enum class LodMode : std::uint8_t {
  distance,  // K's formula
  full,      // every patch at its finest level: the reference that levels of detail are compared with
};

struct LodSettings {
  LodMode mode = LodMode::distance;
  int max_level = 5;  // 1..kMaxLevel; no patch is drawn finer
  int resident_level =
      5;  // 1..kMaxLevel; finest level that vertices are held at. The lesser of the two counts
  // K's d_max: patches from here on are drawn at level 1, at half of it at level 2, at a quarter at level 3,
  // and so on. 0..kCameraReach voxels. At 64 a triangle's edge covers 5 to 10 of 720 pixels at 60 degrees.
  double distance_voxels = 64.0;
};

struct SelectLod {
  LodSettings settings;

  // Inputs, borrowed.
  const Camera* camera = nullptr;
  Surface surface;
  std::span<const PatchBounds> bounds;  // by patch
  const BoundsTree* tree = nullptr;     // over these patches and bounds

  // Output, borrowed: by patch, 1..min(max_level, resident_level). Two neighbours differ by at most one.
  std::span<std::uint8_t> levels;

  struct Result {
    std::uint32_t raised = 0;  // patches drawn finer than their distance asks for, because of a neighbour
  };

  // invalid_argument naming the first field that is missing, outside its range, or of another size than the
  // surface.
  Status validate() const;

  // Precondition: validate() is ok. Neither fails nor allocates.
  Result run() const;
};

}  // namespace karst
