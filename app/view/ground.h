// SPDX-License-Identifier: MIT
// Where the ground is below a place: on the very triangles that are drawn near the eye.
#pragma once

#include <optional>
#include <vector>

#include "terrain/world/terrain.h"

namespace karst::app {
using namespace core;

class Ground {
 public:
  // terrain: loaded, with bounds (Terrain::finish_bounds()); must outlive this object.
  explicit Ground(Terrain& terrain);
  // Height of the highest ground that is no higher than step above the place; none where there is no ground
  // below it. All in voxels from the octree's minimum corner.
  std::optional<double> below(const glm::dvec3& place, double step);

 private:
  std::optional<double> on_patch(PatchId patch, const glm::dvec3& place, double highest);

  Terrain& terrain_;
  int level_;
  std::vector<GpuVertex> vertices_;
};

}  // namespace karst::app
