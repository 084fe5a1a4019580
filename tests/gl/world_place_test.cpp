// SPDX-License-Identifier: MIT
// The same world at any place and with any voxel size is the same picture, bit for bit: metres end at the
// camera.
#include <gtest/gtest.h>

#include "tests/gl/gl_fixture.h"

namespace karst::core {
namespace {

using test::DrawnWorld;
using test::GlContext;
using test::Picture;

TEST(WorldPlace, PicturesDoNotDependOnOriginAndVoxelSize) {
  test::DrawnSettings settings;
  settings.picture.width = 160;
  settings.picture.height = 90;
  DrawnWorld world(test::hills_with_cave(3), GlContext::get().gl(), settings);
  const glm::dvec3 eyes[] = {{11.25, 14.5, 21.125}, {10.3, 4.6, 9.7}, {-3.7, 30.2, -8.9}};

  const WorldFrame frames[] = {{{0, 0, 0}, 1.0},           {{0, 0, 0}, 1e-3},     {{0, 0, 0}, 1e4},
                               {{1e7, 1e7, -1e7}, 1e-3},   {{1e7, -1e7, 1e7}, 1}, {{-1e7, 1e7, 1e7}, 1e4},
                               {{431999.5, 3.25, 4e6}, 30}};
  for (const glm::dvec3 eye : eyes) {
    Picture first;
    for (const WorldFrame& frame : frames) {
      CameraSettings camera;
      const glm::dvec3 eye_m = frame.origin_m + eye * frame.voxel_size_m;
      ASSERT_TRUE(voxels_from_metres(frame, eye_m, camera.position).ok());
      camera.yaw_deg = 17;
      camera.pitch_deg = -28;
      ASSERT_TRUE(world.draw(camera).ok());
      const Picture picture = world.picture();
      if (first.empty()) first = picture;
      EXPECT_TRUE(picture == first) << frame.origin_m.x << ' ' << frame.voxel_size_m;
    }
  }
}

}  // namespace
}  // namespace karst::core
