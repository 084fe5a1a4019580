// SPDX-License-Identifier: MIT
// A small landscape with overhangs, 20 x 14 x 18 voxels.
#pragma once

#include "tests/support/test_world.h"

namespace karst::test {

inline TestWorld hilly_world(int level = 3) {
  TestWorld world({20, 14, 18}, [](glm::ivec3 v) {
    return v.y + 0.5 <
           7 + 4 * value_noise(3, glm::dvec3(v.x, 0, v.z) / 6.0) + 2 * value_noise(4, glm::dvec3(v) / 4.0);
  });
  world.roughen(level, 9, 1500);
  return world;
}

inline Camera camera_at(glm::dvec3 position, double yaw_deg, double fov_y_deg = 60, double pitch_deg = 0) {
  CameraSettings settings;
  settings.position = position;
  settings.yaw_deg = yaw_deg;
  settings.pitch_deg = pitch_deg;
  settings.fov_y_deg = fov_y_deg;
  Camera camera;
  if (!make_camera(settings, camera).ok()) std::abort();
  return camera;
}

}  // namespace karst::test
