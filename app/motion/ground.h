// SPDX-License-Identifier: MIT
// Where the ground is below a place: on triangles of a stated level.
#pragma once

#include <optional>
#include <vector>

#include "terrain/world/residency.h"

namespace karst::app {
using namespace core;

class Ground {
 public:
  // Fine enough for feet: a cell is an eighth of a patch, which is half a voxel or so wide.
  static constexpr int kFeetLevel = 3;
  static constexpr int kFullLevel = kMaxLevel;

  // residency: attached to the world; both must outlive this object.
  Ground(const World& world, Residency& residency);
  // Height of the highest ground that is no higher than step above the place; none where there is no ground
  // below it. All in voxels from the octree's minimum corner. level: cut to the world's.
  std::optional<double> below(const glm::dvec3& place, double step, int level);

  struct Surface {
    double height;  // voxels
    bool faces_up;  // rock below it and air above
  };
  // The lowest surface above the place, at the full level; none where there is only sky. In voxels, too.
  std::optional<Surface> above(const glm::dvec3& place);

 private:
  // Calls visit(Surface) for each triangle over or under (x, z).
  template <class Visit>
  void for_each_at(const glm::dvec3& place, int level, Visit visit);

  const World& world_;
  Residency& residency_;
  std::vector<GpuVertex> vertices_;
};

}  // namespace karst::app
