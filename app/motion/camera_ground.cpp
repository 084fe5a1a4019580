// SPDX-License-Identifier: MIT
#include "app/motion/camera_ground.h"

#include <cstdio>
#include <limits>

namespace karst::app {

std::string CameraGround::stand(CameraPlace& place) {
  if (!place.above_ground) return {};
  const std::optional<double> height =
      below_m(place.position_m, std::numeric_limits<double>::infinity(), Ground::kFullLevel);
  if (!height) {
    char text[96];
    std::snprintf(text, sizeof text, "there is no ground at %.10g,%.10g to stand on", place.position_m.x,
                  place.position_m.z);
    return text;
  }
  place.position_m.y += *height;
  place.above_ground = false;
  return {};
}

std::string CameraGround::in_rock(const CameraPlace& place) {
  const glm::dvec3 at = voxels(place.position_m);
  const std::optional<Ground::Surface> above = ground_.above(at);
  if (!above || !above->faces_up) return {};
  char text[160];
  std::snprintf(text, sizeof text,
                "the camera is inside rock, %.4g m below the ground; --camera X,~2,Z,... stands 2 m above it",
                (above->height - at.y) * frame_.voxel_size_m);
  return text;
}

std::optional<double> CameraGround::below_m(const glm::dvec3& place_m, double step_m, int level) {
  const std::optional<double> height = ground_.below(voxels(place_m), step_m / frame_.voxel_size_m, level);
  if (!height) return std::nullopt;
  return frame_.origin_m.y + *height * frame_.voxel_size_m;
}

}  // namespace karst::app
