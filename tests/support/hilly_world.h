// SPDX-License-Identifier: MIT
// A small landscape with overhangs, 20 x 14 x 18 voxels.
#pragma once

#include <cstdlib>

#include "terrain/view/camera.h"
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

// Wide and smooth, 56 x 10 x 56 voxels: what is far needs little.
inline TestWorld wide_world(int level = 4) {
  TestWorld world({56, 10, 56}, [](glm::ivec3 v) {
    return v.y + 0.5 < 5 + 3 * value_noise(5, glm::dvec3(v.x, 0, v.z) / 14.0);
  });
  world.set_heights(
      level, [](glm::dvec3 p) { return 900 * value_noise(6, p / 0.9) + 80 * value_noise(7, p * 4.0); });
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
