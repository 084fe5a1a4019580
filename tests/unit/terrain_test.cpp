// SPDX-License-Identifier: MIT
// The facade: memory is exactly the budget, frames take none, and a world that contradicts itself is refused.
#include "terrain/world/terrain.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstring>

#include "terrain/base/checksum.h"
#include "tests/support/heap_count.h"
#include "tests/support/test_world.h"

namespace karst {
namespace {

using test::AlignedBytes;

constexpr int kLevel = 3;

test::TestWorld hilly_world() {
  test::TestWorld world({20, 14, 18}, [](glm::ivec3 v) {
    return v.y + 0.5 < 7 + 4 * test::value_noise(3, glm::dvec3(v.x, 0, v.z) / 6.0) +
                           2 * test::value_noise(4, glm::dvec3(v) / 4.0);
  });
  world.roughen(kLevel, 9, 1500);
  return world;
}

TEST(Terrain, UsesExactlyItsBudget) {
  const test::TestWorld world = hilly_world();
  const Config config = Terrain::config_for(world.info(), kLevel);
  const Budget budget = Terrain::budget(config);
  const AlignedBytes memory(budget.cpu_bytes());
  Terrain terrain;
  ASSERT_TRUE(terrain.create(config, memory.bytes()).ok());
  EXPECT_EQ(terrain.arena().used(), budget.cpu_bytes());
  EXPECT_EQ(terrain.arena().capacity(), budget.cpu_bytes());
  EXPECT_TRUE(terrain.arena().frozen());
  for (std::size_t c = 0; c < kConsumerCount; ++c) {
    const Consumer consumer = static_cast<Consumer>(c);
    EXPECT_EQ(terrain.arena().used(consumer), budget.bytes(consumer)) << kConsumerNames[c];
  }
  ASSERT_TRUE(terrain.load(world.file()).ok());
  EXPECT_EQ(terrain.arena().used(), budget.cpu_bytes());
}

TEST(Terrain, OneByteLessIsTooLittle) {
  const test::TestWorld world = hilly_world();
  const Config config = Terrain::config_for(world.info(), kLevel);
  const std::size_t needed = Terrain::budget(config).cpu_bytes();
  const AlignedBytes memory(needed);
  Terrain terrain;
  const Status status = terrain.create(config, memory.bytes().first(needed - 1));
  EXPECT_EQ(status.code(), StatusCode::limit_reached);
  EXPECT_STREQ(status.field(), "memory");
  EXPECT_EQ(status.value(), needed);
  EXPECT_EQ(terrain.create(config, memory.bytes().subspan(1)).code(), StatusCode::limit_reached);
}

// Each limit, one below what the world needs.
TEST(Terrain, EachLimitIsNamed) {
  const test::TestWorld world = hilly_world();
  const std::vector<std::byte> file = world.file();
  const struct {
    std::uint32_t Config::*member;
    const char* name;
  } limits[] = {{&Config::max_depth, "max_depth"},     {&Config::max_level, "max_level"},
                {&Config::max_octets, "max_octets"},   {&Config::max_volumes, "max_volumes"},
                {&Config::max_patches, "max_patches"}, {&Config::max_height_blocks, "max_height_blocks"}};
  for (const auto& limit : limits) {
    Config config = Terrain::config_for(world.info(), kLevel);
    config.*limit.member -= 1;
    const AlignedBytes memory(Terrain::budget(config).cpu_bytes());
    Terrain terrain;
    ASSERT_TRUE(terrain.create(config, memory.bytes()).ok()) << limit.name;
    const Status status = terrain.load(file);
    EXPECT_EQ(status.code(), StatusCode::limit_reached) << limit.name;
    EXPECT_STREQ(status.field(), limit.name);
    EXPECT_EQ(terrain.patch_count(), 0u);
  }
}

class LoadedTerrain {
 public:
  explicit LoadedTerrain(const test::TestWorld& world)
      : config_(Terrain::config_for(world.info(), kLevel)), memory_(Terrain::budget(config_).cpu_bytes()) {
    EXPECT_TRUE(terrain.create(config_, memory_.bytes()).ok());
  }
  Terrain terrain;

 private:
  Config config_;
  AlignedBytes memory_;
};

TEST(Terrain, GeneratesWhatTheStagesGenerate) {
  const test::TestWorld world = hilly_world();
  LoadedTerrain loaded(world);
  ASSERT_TRUE(loaded.terrain.load(world.file()).ok());
  ASSERT_EQ(loaded.terrain.patch_count(), world.surface().patches.size());
  std::vector<GpuVertex> vertices(static_cast<std::size_t>(patch_vertices(kLevel)));
  for (PatchId p = 0; p < loaded.terrain.patch_count(); ++p) {
    loaded.terrain.generate(p, kLevel, vertices);
    ASSERT_EQ(vertices, world.vertices(p, kLevel));
    const PatchBounds& b = loaded.terrain.bounds()[p];
    for (int axis = 0; axis < 3; ++axis) {
      std::int16_t low = INT16_MAX;
      std::int16_t high = INT16_MIN;
      for (const GpuVertex& v : vertices) {
        low = std::min(low, v.position[axis]);
        high = std::max(high, v.position[axis]);
      }
      EXPECT_EQ(b.min[axis], low);
      EXPECT_EQ(b.max[axis], high);
    }
  }
}

TEST(Terrain, AThousandFramesTakeNoHeap) {
  const test::TestWorld world = hilly_world();
  LoadedTerrain loaded(world);
  Terrain& terrain = loaded.terrain;
  const std::vector<std::byte> file = world.file();
  std::vector<GpuVertex> vertices(static_cast<std::size_t>(patch_vertices(kLevel)));

  const std::uint64_t before = test::heap_calls();
  ASSERT_TRUE(terrain.load(file).ok());
  for (PatchId p = 0; p < terrain.patch_count(); ++p) terrain.generate(p, kLevel, vertices);
  ASSERT_TRUE(terrain.finish_bounds().ok());
  std::uint64_t drawn = 0;
  for (int frame = 0; frame < 1000; ++frame) {
    CameraSettings settings;
    settings.position = {10 + 9 * std::cos(frame * 0.01), 9, 9 + 9 * std::sin(frame * 0.01)};
    settings.yaw_deg = frame * 0.7;
    Camera camera;
    TerrainView view;
    view.camera = &camera;
    view.lod.distance_voxels = 16;
    Terrain::Selection selection;
    ASSERT_TRUE(make_camera(settings, camera).ok());
    ASSERT_TRUE(terrain.select(view, selection).ok());
    drawn += selection.list.drawn;
  }
  EXPECT_EQ(test::heap_calls() - before, 0u);
  EXPECT_GT(drawn, 1000u);
  // The counter itself works.
  const std::uint64_t counted = test::heap_calls();
  std::vector<int> block(100);
  EXPECT_GT(test::heap_calls(), counted);
}

TEST(Terrain, LoadsAgainAfterAFailure) {
  const test::TestWorld world = hilly_world();
  LoadedTerrain loaded(world);
  std::vector<std::byte> file = world.file();
  std::vector<std::byte> broken = file;
  broken[broken.size() / 2] ^= std::byte{1};
  EXPECT_EQ(loaded.terrain.load(broken).code(), StatusCode::corrupt);
  EXPECT_EQ(loaded.terrain.patch_count(), 0u);
  EXPECT_TRUE(loaded.terrain.load(file).ok());
}

// A valid file whose patches disagree about a vertex they share would draw a crack.
TEST(Terrain, RefusesHeightsThatDisagree) {
  test::TestWorld world = hilly_world();
  const int side = patch_side(kLevel);
  // Vertex (1, 0) of the first patch that has a neighbour across edge 0.
  for (PatchId p = 0; p < world.patches().size(); ++p) {
    if (!world.patches()[p].neighbour[0].exists()) continue;
    world.height_samples()[static_cast<std::size_t>(p) * static_cast<std::size_t>(side * side) + 1] ^= 1;
    break;
  }
  LoadedTerrain loaded(world);
  const Status status = loaded.terrain.load(world.file());
  EXPECT_EQ(status.code(), StatusCode::corrupt);
  EXPECT_STREQ(status.field(), "heights");
}

TEST(Terrain, RefusesCountsThatContradictTheVoxels) {
  const test::TestWorld world = hilly_world();
  test::TestWorld other = hilly_world();
  // One patch less than its voxels make.
  WorldInfo info = world.info();
  info.patches -= 1;
  info.height_blocks -= 1;
  std::vector<std::int16_t> samples = other.height_samples();
  samples.resize(samples.size() - static_cast<std::size_t>(patch_vertices(kLevel)));
  std::vector<std::byte> mask((info.patches + 7) / 8, std::byte{0});
  for (std::uint32_t p = 0; p < info.patches; ++p) mask[p / 8] |= static_cast<std::byte>(1u << (p % 8));
  std::vector<std::byte> file(world_file_bytes(info));
  std::size_t written = 0;
  std::vector<std::uint16_t> errors = world.level_errors();
  errors.resize(info.patches * level_error_values(info.level));
  ASSERT_TRUE(write_world(info, world.octree(), {mask, samples, errors}, file, written).ok());
  LoadedTerrain loaded(world);
  const Status status = loaded.terrain.load(file);
  EXPECT_EQ(status.code(), StatusCode::corrupt);
  EXPECT_STREQ(status.field(), "patches");
}

TEST(Terrain, SelectNeedsACamera) {
  const test::TestWorld world = hilly_world();
  LoadedTerrain loaded(world);
  Terrain::Selection selection;
  EXPECT_STREQ(loaded.terrain.select({}, selection).field(), "camera");
}

}  // namespace
}  // namespace karst
