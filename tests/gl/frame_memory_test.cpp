// SPDX-License-Identifier: MIT
// Memory is taken when the renderer is created, exactly what its budget says, and never again.
#include <cstdint>

#include <gtest/gtest.h>

#include "renderer/renderer.h"
#include "terrain/base/budget.h"
#include "tests/gl/gl_fixture.h"
#include "tests/gl/noop_gl.h"
#include "tests/support/heap_count.h"

namespace karst::core {
namespace {

using test::NoopGl;

constexpr int kFrames = 1000;

TEST(FrameMemory, NoHeapAndNoGlObjectsInAThousandFrames) {
  const Gl gl = NoopGl::reset();
  test::DrawnSettings settings;
  settings.picture.width = 320;
  settings.picture.height = 180;
  settings.debug = true;
  settings.loader = NoopGl::loader();
  test::DrawnWorld world(test::hills_with_cave(3), gl, settings, 100);  // patches come and go
  ASSERT_FALSE(testing::Test::HasFailure());

  world.lod.mode = LodMode::error;
  ViewInput input;
  CameraSettings first;
  first.position = {11, 14, 18};
  ASSERT_TRUE(world.prepare(first, input).ok());

  const std::uint64_t objects = NoopGl::get().objects_made;
  const std::uint64_t bytes = NoopGl::get().object_bytes;
  const std::uint64_t draws = NoopGl::get().draws;
  const std::uint64_t questions = NoopGl::get().questions;
  const std::uint64_t heap = test::heap_calls();
  Status status;
  std::uint64_t triangles = 0;
  std::uint64_t uploaded = 0;
  for (int frame = 0; frame < kFrames && status.ok(); ++frame) {
    CameraSettings camera;
    camera.position = {11 + 0.01 * frame, 14 - 0.01 * frame, 18 - 0.01 * frame};
    camera.yaw_deg = 0.7 * frame;
    camera.pitch_deg = -30 + 0.05 * frame;
    FrameCounts counts;
    // Thresholds change.
    world.lod.error_px = 1 + frame % 100 / 10;
    world.patches_a_frame = frame + 1 < kFrames ? 5 : 0;  // the last ones would wait for another frame
    status = world.draw(camera, &counts);
    uploaded += counts.uploaded_bytes;
    triangles += counts.triangles;
  }
  const std::uint64_t heap_after = test::heap_calls();
  EXPECT_TRUE(status.ok()) << status.what();
  EXPECT_EQ(heap_after - heap, 0u);
  EXPECT_EQ(NoopGl::get().objects_made - objects, 0u);
  EXPECT_EQ(NoopGl::get().object_bytes - bytes, 0u);
  EXPECT_EQ(NoopGl::get().mapped, 0u);
  EXPECT_EQ(NoopGl::get().questions - questions, 0u);
  EXPECT_EQ(NoopGl::get().most_fences, std::uint64_t{kFramesInFlight});
  EXPECT_EQ(NoopGl::get().waits, std::uint64_t{kFrames} - kFramesInFlight);
  EXPECT_GT(uploaded, 1'000'000u);
  EXPECT_GE(NoopGl::get().draws - draws, std::uint64_t{kFrames});
  EXPECT_GT(triangles, std::uint64_t{kFrames} * 100);
}

TEST(FrameMemory, CreatingTakesExactlyTheBudget) {
  const Gl gl = NoopGl::reset();
  RendererSettings settings;
  settings.vertex_pages = 3000;
  settings.morph_rows = 777;
  settings.stream_indices = 5000;
  settings.extent = {100, 20, 7};
  settings.cascades = 2;
  settings.drape_width = 100;
  settings.drape_height = 3;
  settings.air_blocks = 3;
  Budget budget;
  settings.add_to(budget);
  Renderer renderer;
  ASSERT_TRUE(renderer.create(gl, settings).ok());
  EXPECT_EQ(NoopGl::get().object_bytes, budget.gpu_bytes());
  EXPECT_EQ(renderer.gpu_bytes(), budget.gpu_bytes());
  EXPECT_EQ(budget.cpu_bytes(), 0u);
  renderer.destroy();
  EXPECT_EQ(renderer.gpu_bytes(), 0u);
}

TEST(FrameMemory, EveryObjectIsDeleted) {
  const Gl gl = NoopGl::reset();
  {
    Renderer renderer;
    RendererSettings settings;
    settings.timers = true;
    settings.vertex_pages = 10;
    settings.morph_rows = 10;
    settings.cascades = 3;
    settings.stream_indices = 1000;
    ASSERT_TRUE(renderer.create(gl, settings).ok());
    // Creating again deletes what was there.
    const std::uint64_t made = NoopGl::get().objects_made;
    ASSERT_TRUE(renderer.create(gl, settings).ok());
    EXPECT_EQ(NoopGl::get().objects_made, made * 2);
  }
  EXPECT_GT(NoopGl::get().objects_made, 10u);
  EXPECT_EQ(NoopGl::get().objects_deleted, NoopGl::get().objects_made);
}

// A lost context's objects are gone: nothing of them is deleted, and the renderer can be made anew.
TEST(FrameMemory, ForgettingCallsNothing) {
  const Gl gl = NoopGl::reset();
  RendererSettings settings;
  settings.timers = true;
  settings.vertex_pages = 10;
  settings.morph_rows = 10;
  settings.cascades = 3;
  settings.stream_indices = 1000;
  Renderer renderer;
  ASSERT_TRUE(renderer.create(gl, settings).ok());
  const std::uint64_t made = NoopGl::get().objects_made;
  const std::uint64_t deleted = NoopGl::get().objects_deleted;  // shaders
  static_cast<void>(renderer.end_frame());
  renderer.forget();
  EXPECT_EQ(NoopGl::get().objects_deleted, deleted);
  EXPECT_EQ(NoopGl::get().fences, 1u);
  EXPECT_EQ(renderer.gpu_bytes(), 0u);
  ASSERT_TRUE(renderer.create(gl, settings).ok());
  renderer.destroy();
  EXPECT_EQ(NoopGl::get().objects_deleted, NoopGl::get().objects_made - (made - deleted));
}

TEST(FrameMemory, FencesAreDeleted) {
  const Gl gl = NoopGl::reset();
  {
    test::DrawnSettings settings;
    settings.loader = NoopGl::loader();
    test::DrawnWorld world(test::hills_with_cave(1), gl, settings);
    ASSERT_TRUE(world.draw(CameraSettings()).ok());
    EXPECT_EQ(NoopGl::get().fences, 1u);
  }
  EXPECT_EQ(NoopGl::get().fences, 0u);
}

}  // namespace
}  // namespace karst::core
