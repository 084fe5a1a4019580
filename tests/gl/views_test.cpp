// SPDX-License-Identifier: MIT
// Two views of a frame, each with thresholds of its own: pictures are those of each view alone.
#include <gtest/gtest.h>

#include <array>

#include "tests/gl/gl_fixture.h"

namespace karst::core {
namespace {

using test::DrawnSettings;
using test::DrawnWorld;
using test::GlContext;
using test::Picture;

std::array<Camera, 2> two_cameras() {
  std::array<Camera, 2> cameras;
  CameraSettings settings;
  settings.position = {11, 15, 26};
  settings.pitch_deg = -25;
  EXPECT_TRUE(make_camera(settings, cameras[0]).ok());
  settings.position = {3, 14, 2};
  settings.yaw_deg = -140;
  settings.fov_y_deg = 25;  // other optics, so other thresholds
  EXPECT_TRUE(make_camera(settings, cameras[1]).ok());
  return cameras;
}

DrawnSettings settings_for(std::uint32_t views) {
  DrawnSettings settings;
  settings.picture.width = 160;
  settings.picture.height = 90;
  settings.max_views = views;
  settings.debug = true;
  return settings;
}

// Morphs a lot at this size.
void by_error(DrawnWorld& drawn) {
  drawn.lod.mode = LodMode::error;
  drawn.lod.error_px = 6;
}

TEST(Views, PicturesAreThoseOfEachViewAlone) {
  const test::TestWorld world = test::hills_with_cave(4);
  const std::array<Camera, 2> cameras = two_cameras();
  DrawnWorld together(world, GlContext::get().gl(), settings_for(2));
  by_error(together);
  std::array<ViewInput, 2> inputs;
  ASSERT_TRUE(together.prepare(cameras, inputs).ok());
  EXPECT_EQ(inputs[0].first_morph_row, 0u);
  EXPECT_EQ(inputs[1].first_morph_row, together.world().config().max_resident_patches);
  for (std::size_t v = 0; v < 2; ++v) {
    ASSERT_TRUE(together.draw(inputs[v]).ok());
    const Picture seen = together.picture();
    DrawnWorld alone(world, GlContext::get().gl(), settings_for(1));
    by_error(alone);
    ViewInput input;
    ASSERT_TRUE(alone.prepare(cameras[v], input).ok());
    EXPECT_EQ(input.first_morph_row, 0u);
    ASSERT_TRUE(alone.draw(input).ok());
    EXPECT_EQ(seen, alone.picture()) << v;
    EXPECT_GT(alone.selection.list.drawn, 30u);
    EXPECT_STREQ(together.renderer().message(), "");
  }
  // With the other view's thresholds it would be another picture.
  ASSERT_TRUE(together.draw(inputs[1]).ok());
  const Picture right = together.picture();
  inputs[1].first_morph_row = 0;
  ASSERT_TRUE(together.draw(inputs[1]).ok());
  EXPECT_NE(together.picture(), right);
}

}  // namespace
}  // namespace karst::core
