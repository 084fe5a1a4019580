// SPDX-License-Identifier: MIT
// What may run beside what, to be run under ThreadSanitizer (docs/architecture.md, "Threads").
#include <cstdint>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/loaded_parts.h"
#include "tests/support/query_world.h"

namespace karst::core {
namespace {

using test::TestQuery;
using test::TestWorld;

// Two threads ask a world whose heights are read, beside one that chooses and makes what is drawn of it.
TEST(QueryThreads, AnswerTheSameBitsBesideAThreadThatDraws) {
  const TestWorld world = test::rolling_world();
  const std::vector<std::byte> file = world.file();
  Config config = World::config_for(world.info(), world.info().level);
  config.max_height_blocks = HeightCache::kLeastGroups * kHeightGroup;
  ASSERT_LT(config.max_height_blocks, world.info().height_blocks);
  test::LoadedParts parts(config);
  ASSERT_TRUE(parts.load(file).ok());
  ASSERT_FALSE(parts.world.holds_all_heights());

  QueryWorld asked;
  asked.surface = parts.world.surface();
  asked.bounds = parts.world.bounds();
  asked.tree = &parts.world.tree();
  asked.heights.level = parts.world.info().level;
  asked.height_blocks = parts.world.info().height_blocks;
  asked.source = parts.world.height_source();
  TestQuery alone(asked, 3, 4096);
  const std::vector<QueryHit> expected = test::ask_all(*alone, Wait::for_file, 9, 150);

  TestQuery one(asked, 3, 30);
  TestQuery two(asked, 3, 30);
  std::vector<QueryHit> of_one, of_two;
  std::thread first([&] { of_one = test::ask_all(*one, Wait::for_file, 9, 150); });
  std::thread second([&] { of_two = test::ask_all(*two, Wait::for_file, 9, 150); });
  for (int frame = 0; frame < 30; ++frame) {
    CameraSettings settings;
    settings.position = {12.0, 8.0, 12.0};
    settings.yaw_deg = 12.0 * frame;
    Camera camera;
    ASSERT_TRUE(make_camera(settings, camera).ok());
    ViewRequest view;
    view.camera = &camera;
    view.lod.max_level = world.info().level;
    parts.residency.begin_frame();
    ASSERT_TRUE(parts.select(view).ok());
    PatchUpload upload;
    Status status;
    for (int n = 0; n < 20 && parts.residency.generate_next(true, upload, status); ++n) {
    }
    ASSERT_TRUE(status.ok());
  }
  first.join();
  second.join();
  EXPECT_EQ(expected.size(), of_one.size());
  EXPECT_EQ(test::first_difference(of_one, expected), expected.size());
  EXPECT_EQ(test::first_difference(of_two, expected), expected.size());
}

}  // namespace
}  // namespace karst::core
