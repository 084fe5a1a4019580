// SPDX-License-Identifier: MIT
// Cameras and the ground: heights above it, and cameras that are below it by mistake.
#pragma once

#include <string>

#include "app/common/camera_path.h"
#include "app/motion/ground.h"

namespace karst::app {

class CameraGround {
 public:
  // As Ground's.
  CameraGround(const World& world, Residency& residency, const WorldFrame& frame)
      : ground_(world, residency), frame_(frame) {}

  // Where place counts from the ground, makes it count from the world's zero. Empty, else one line without
  // its subject: there is no ground at x, z; place is then unchanged.
  [[nodiscard]] std::string stand(CameraPlace& place);
  // One line, where the camera is inside rock; empty where it is in the air. place does not count from the
  // ground.
  std::string in_rock(const CameraPlace& place);

  // Height of the ground, metres, that is no higher than step_m above the place; none where there is none.
  // level: of the triangles that are asked, Ground's.
  std::optional<double> below_m(const glm::dvec3& place_m, double step_m, int level);

 private:
  glm::dvec3 voxels(const glm::dvec3& place_m) const {
    return (place_m - frame_.origin_m) / frame_.voxel_size_m;
  }

  Ground ground_;
  WorldFrame frame_;
};

}  // namespace karst::app
