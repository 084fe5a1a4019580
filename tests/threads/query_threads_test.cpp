// SPDX-License-Identifier: MIT
// What may run beside what, to be run under ThreadSanitizer (docs/architecture.md, "Threads").
#include <cstdint>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "terrain/world/terrain.h"
#include "tests/support/query_world.h"

namespace karst::core {
namespace {

using test::TestQuery;
using test::TestWorld;

// One reader of a file that all queries share.
struct FileHeights {
  WorldReader reader;
  std::vector<std::uint32_t> crcs;
};

// Two threads ask a world whose heights are read, beside one that chooses and makes what is drawn of it.
TEST(QueryThreads, AnswerTheSameBitsBesideAThreadThatDraws) {
  const TestWorld world = test::rolling_world();
  const std::vector<std::byte> file = world.file();
  Config config = Terrain::config_for(world.info(), world.info().level);
  config.max_height_blocks = HeightCache::kLeastGroups * kHeightGroup;
  ASSERT_LT(config.max_height_blocks, world.info().height_blocks);
  test::AlignedBytes memory(Terrain::budget(config).cpu_bytes());
  Terrain terrain;
  ASSERT_TRUE(terrain.create(config, memory.bytes()).ok());
  ASSERT_TRUE(terrain.load(file).ok());
  ASSERT_FALSE(terrain.holds_all_heights());

  FileHeights heights;
  ASSERT_TRUE(heights.reader.open(ByteSource::of(file)).ok());
  heights.crcs.resize(height_groups(world.info().height_blocks));
  ASSERT_TRUE(heights.reader.read_height_crcs(heights.crcs).ok());
  QueryWorld asked;
  asked.surface = terrain.surface();
  asked.bounds = terrain.bounds();
  asked.tree = &terrain.tree();
  asked.heights.level = terrain.info().level;
  asked.height_blocks = terrain.info().height_blocks;
  asked.source = {&heights, [](const void* context, std::uint32_t group, std::span<std::int16_t> out) {
                    const auto* from = static_cast<const FileHeights*>(context);
                    return from->reader.read_heights(group, from->crcs[group], out);
                  }};
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
    TerrainView view;
    view.camera = &camera;
    view.lod.max_level = world.info().level;
    Terrain::Selection selection;
    terrain.begin_frame();
    ASSERT_TRUE(terrain.select(view, selection).ok());
    PatchUpload upload;
    Status status;
    for (int n = 0; n < 20 && terrain.generate_next(true, upload, status); ++n) {
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
