// SPDX-License-Identifier: MIT
// Heights that put a patch's vertices on a given solid's boundary: for each vertex, the nearest crossing of
// the field along +-W (design 4.4). Used when a world is baked and when brushes fit to a shape.
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/patch/heights.h"
#include "terrain/surface/patch.h"

namespace karst::core {

// A solid given by a continuous function of position: positive inside, negative outside. Position in voxels
// from the octree's minimum corner. Called many millions of times: keep it cheap and pure.
struct SolidField {
  double (*value)(const void* context, glm::dvec3 position) = nullptr;
  const void* context = nullptr;
};

struct FitHeights {
  // Inputs.
  Surface surface;
  SolidField field;
  int level = 0;                  // of the heights, 1..kMaxLevel
  double search_voxels = 1.5;     // how far along +-W a crossing is looked for, (0, 3]
  double step_voxels = 1.0 / 16;  // first step of the search, (0, 0.5]; thinner features can be missed

  // Output, borrowed: patch_vertices(level) heights for patch 0, then patch 1, ... (as Heights with
  // height_block = patch).
  std::span<std::int16_t> heights;

  struct Result {
    std::uint64_t vertices = 0;
    std::uint64_t misses = 0;  // vertices with no crossing in reach: they go where |field| is least
  };

  Status validate() const;
  // Fits patches [first, last): ranges may run on several threads, each with its own Result.
  void run(PatchId first, PatchId last, Result& result) const;
};

}  // namespace karst::core
