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
#include "tests/support/world_io.h"

namespace karst::core {
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
  } limits[] = {{&Config::max_depth, "max_depth"},
                {&Config::max_level, "max_level"},
                {&Config::max_octets, "max_octets"},
                {&Config::max_volumes, "max_volumes"},
                {&Config::max_patches, "max_patches"}};
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
  explicit LoadedTerrain(const test::TestWorld& world, std::uint32_t detail_pages = Terrain::kDetailPages)
      : config_(Terrain::config_for(world.info(), kLevel, detail_pages)),
        memory_(Terrain::budget(config_).cpu_bytes()) {
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
    ASSERT_TRUE(loaded.terrain.generate(p, kLevel, kLevel, vertices).ok());
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

// Makes what a view lacks until nothing is lacking that can be made. Returns how many patches that were.
int settle(Terrain& terrain, const TerrainView& view, Terrain::Selection& selection) {
  int made = 0;
  for (int round = 0; round < 100; ++round) {
    EXPECT_TRUE(terrain.select(view, selection).ok());
    const int before = made;
    PatchUpload upload;
    Status status;
    while (terrain.generate_next(false, upload, status)) ++made;
    EXPECT_TRUE(status.ok()) << status.what();
    if (made == before && !selection.pool_full) break;
    terrain.begin_frame();
  }
  return made;
}

Camera camera_at(glm::dvec3 position, double yaw_deg) {
  CameraSettings settings;
  settings.position = position;
  settings.yaw_deg = yaw_deg;
  Camera camera;
  EXPECT_TRUE(make_camera(settings, camera).ok());
  return camera;
}

TEST(Terrain, AThousandFramesTakeNoHeap) {
  const test::TestWorld world = hilly_world();
  LoadedTerrain loaded(world, 40);  // a small pool: patches come and go
  Terrain& terrain = loaded.terrain;
  const std::vector<std::byte> file = world.file();

  const std::uint64_t before = test::heap_calls();
  ASSERT_TRUE(terrain.load(file).ok());
  std::uint64_t drawn = 0;
  std::uint64_t made = 0;
  for (int frame = 0; frame < 1000; ++frame) {
    const Camera camera =
        camera_at({10 + 9 * std::cos(frame * 0.01), 9, 9 + 9 * std::sin(frame * 0.01)}, frame * 0.7);
    TerrainView view;
    view.camera = &camera;
    view.lod.error_px = 0.5;
    Terrain::Selection selection;
    terrain.begin_frame();
    ASSERT_TRUE(terrain.select(view, selection).ok());
    drawn += selection.list.drawn;
    PatchUpload upload;
    Status status;
    for (int i = 0; i < 10 && terrain.generate_next(true, upload, status); ++i) ++made;
    terrain.take_morph_rows();
  }
  EXPECT_EQ(test::heap_calls() - before, 0u);
  EXPECT_GT(drawn, 1000u);
  EXPECT_GT(made, terrain.patch_count() * 3 / 2);
  // The counter itself works.
  const std::uint64_t counted = test::heap_calls();
  std::vector<int> block(100);
  EXPECT_GT(test::heap_calls(), counted);
}

// With room for everything, what is drawn in the end is what the view wants.
TEST(Terrain, EverythingWantedBecomesResident) {
  const test::TestWorld world = hilly_world();
  LoadedTerrain loaded(world, 1u << 20);
  Terrain& terrain = loaded.terrain;
  const std::vector<std::byte> file = world.file();
  ASSERT_TRUE(terrain.load(file).ok());
  for (const double error_px : {0.2, 2.0, 20.0}) {
    terrain.begin_frame();
    const Camera camera = camera_at({10, 14, 18}, 0);
    TerrainView view;
    view.camera = &camera;
    view.lod.error_px = error_px;
    Terrain::Selection selection;
    settle(terrain, view, selection);
    EXPECT_EQ(selection.lod.capped, 0u);
    EXPECT_EQ(selection.lod.missing, 0u);
    EXPECT_FALSE(selection.pool_full);
    EXPECT_FLOAT_EQ(selection.lod.bound_px, static_cast<float>(error_px));
    EXPECT_GT(selection.list.drawn, 10u);
  }
}

// What a pool cannot hold makes the frame coarser, never wrong, and the bound says by how much.
TEST(Terrain, AFullPoolRaisesTheBound) {
  const test::TestWorld world = hilly_world();
  const std::vector<std::byte> file = world.file();
  for (const std::uint32_t detail : {0u, 10u, 60u}) {
    LoadedTerrain loaded(world, detail);
    Terrain& terrain = loaded.terrain;
    ASSERT_TRUE(terrain.load(file).ok());
    terrain.begin_frame();
    const Camera camera = camera_at({10, 10, 12}, 0);
    TerrainView view;
    view.camera = &camera;
    view.lod.error_px = 0.02;
    view.frustum_culling = false;  // all of the world is too much for the pool
    Terrain::Selection selection;
    settle(terrain, view, selection);
    EXPECT_TRUE(selection.pool_full) << detail;
    EXPECT_EQ(selection.lod.missing, 0u);
    EXPECT_GT(selection.lod.bound_px, 0.02f);
    for (const DrawItem& item : terrain.items()) EXPECT_LE(item.level, terrain.pool().level(item.patch));
    // And it falls again where less is wanted.
    const Camera far_away = camera_at({10, 10, 300}, 0);
    view.camera = &far_away;
    view.lod.error_px = 50;
    for (int frame = 0; frame < 4000; ++frame) {
      terrain.begin_frame();
      ASSERT_TRUE(terrain.select(view, selection).ok());
      PatchUpload upload;
      Status status;
      while (terrain.generate_next(false, upload, status)) {
      }
    }
    EXPECT_EQ(selection.error_scale, 1.0f);
    EXPECT_FALSE(selection.pool_full);
    EXPECT_FLOAT_EQ(selection.lod.bound_px, 50.0f);
  }
}

// Whatever way a patch became resident, by steps or at once, its vertices are those of the full level.
TEST(Terrain, UploadsAddUpToTheSlot) {
  const test::TestWorld world = hilly_world();
  LoadedTerrain loaded(world, 60);
  Terrain& terrain = loaded.terrain;
  const std::vector<std::byte> file = world.file();
  ASSERT_TRUE(terrain.load(file).ok());
  std::vector<std::vector<GpuVertex>> gpu(terrain.patch_count());
  std::vector<std::vector<std::uint16_t>> rows(terrain.config().max_resident_patches);
  int raised = 0;
  for (int frame = 0; frame < 300; ++frame) {
    terrain.begin_frame();
    const Camera camera =
        camera_at({10 + 8 * std::cos(frame * 0.1), 10, 9 + 8 * std::sin(frame * 0.1)}, frame * 3);
    TerrainView view;
    view.camera = &camera;
    view.lod.error_px = frame % 50 < 25 ? 0.3 : 3.0;
    Terrain::Selection selection;
    ASSERT_TRUE(terrain.select(view, selection).ok());
    PatchUpload upload;
    Status status;
    for (int i = 0; i < 5 && terrain.generate_next(true, upload, status); ++i) {
      std::vector<GpuVertex>& slot = gpu[upload.patch];
      ASSERT_LE(static_cast<std::size_t>(upload.first_vertex), slot.size());
      raised += upload.first_vertex > 0 ? 1 : 0;
      slot.resize(static_cast<std::size_t>(upload.first_vertex));
      slot.insert(slot.end(), upload.vertices.begin(), upload.vertices.end());
      EXPECT_EQ(upload.row, terrain.pool().row(upload.patch));
    }
    const MorphRows changed = terrain.take_morph_rows();
    for (std::size_t at = 0; at < changed.halves.size(); at += kMorphRow) {
      const auto row = changed.halves.subspan(at, kMorphRow);
      rows[changed.first_row + at / kMorphRow].assign(row.begin(), row.end());
    }
  }
  EXPECT_GT(raised, 10);
  for (PatchId p = 0; p < terrain.patch_count(); ++p) {
    const int level = terrain.pool().level(p);
    if (level == 0) continue;
    std::vector<GpuVertex> expected = world.vertices(p, kLevel);
    expected.resize(static_cast<std::size_t>(patch_vertices(level)));
    gpu[p].resize(expected.size());
    ASSERT_EQ(gpu[p], expected) << p;
    std::uint16_t row[kMorphRow];
    make_morph_row(terrain.surface(), terrain.lods(), p, row);
    ASSERT_TRUE(std::equal(rows[terrain.pool().row(p)].begin(), rows[terrain.pool().row(p)].end(), row)) << p;
  }
}

// Heights that do not fit memory are read from the file when vertices are made, and change nothing.
TEST(Terrain, HeightsComeThroughABoundedCache) {
  const test::TestWorld world = hilly_world();
  const std::vector<std::byte> file = world.file();
  Config config = Terrain::config_for(world.info(), kLevel);
  config.max_height_blocks = HeightCache::kLeastGroups * kHeightGroup;
  ASSERT_GT(world.info().height_blocks, config.max_height_blocks);
  const AlignedBytes memory(Terrain::budget(config).cpu_bytes());
  Terrain terrain;
  ASSERT_TRUE(terrain.create(config, memory.bytes()).ok());
  ASSERT_TRUE(terrain.load(file).ok());
  EXPECT_FALSE(terrain.holds_all_heights());
  std::vector<GpuVertex> vertices(static_cast<std::size_t>(patch_vertices(kLevel)));
  for (PatchId p = 0; p < terrain.patch_count(); ++p) {
    ASSERT_TRUE(terrain.generate(p, kLevel, kLevel, vertices).ok());
    ASSERT_EQ(vertices, world.vertices(p, kLevel));
  }
  const std::uint64_t in_order = terrain.height_groups_read();
  EXPECT_GT(in_order, height_groups(world.info().height_blocks));
  test::Random random{7};
  for (int i = 0; i < 500; ++i) {
    const auto p = static_cast<PatchId>(random.below(static_cast<int>(terrain.patch_count())));
    ASSERT_TRUE(terrain.generate(p, kLevel, kLevel, vertices).ok());
    ASSERT_EQ(vertices, world.vertices(p, kLevel));
  }
  EXPECT_GT(terrain.height_groups_read(), in_order);
}

TEST(Terrain, AFileThatCannotBeReadAnyMoreIsReported) {
  const test::TestWorld world = hilly_world();
  std::vector<std::byte> file = world.file();
  Config config = Terrain::config_for(world.info(), kLevel);
  config.max_height_blocks = HeightCache::kLeastGroups * kHeightGroup;
  const AlignedBytes memory(Terrain::budget(config).cpu_bytes());
  Terrain terrain;
  ASSERT_TRUE(terrain.create(config, memory.bytes()).ok());
  ASSERT_TRUE(terrain.load(file).ok());
  // Heights are the largest section: all of it is damaged now.
  for (std::size_t at = file.size() / 4; at < file.size() * 3 / 4; ++at) file[at] ^= std::byte{0x55};
  terrain.begin_frame();
  const Camera camera = camera_at({10, 14, 18}, 0);
  TerrainView view;
  view.camera = &camera;
  Terrain::Selection selection;
  ASSERT_TRUE(terrain.select(view, selection).ok());
  PatchUpload upload;
  Status status;
  const std::uint32_t pages = terrain.pool().free_pages();
  while (terrain.generate_next(false, upload, status)) {
  }
  EXPECT_EQ(status.code(), StatusCode::corrupt);
  EXPECT_STREQ(status.field(), "height samples");
  EXPECT_LE(terrain.pool().free_pages(), pages);
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

// A file whose sections fit one another, but whose patches are not those that its voxels make: the counts of
// the header tell, and where they are right, the keys do.
TEST(Terrain, RefusesPatchesThatContradictTheVoxels) {
  test::TestWorld world = test::TestWorld::noise(3, {14, 10, 14}, 0.5, 3.0, false);
  world.roughen(kLevel, 9, 500);
  LoadedTerrain loaded(world);
  const auto load = [&](std::vector<PatchKey> keys, std::uint32_t volumes) {
    WorldInfo info = world.info();
    info.patches = info.height_blocks = static_cast<std::uint32_t>(keys.size());
    info.volumes = volumes;
    std::vector<std::int16_t> samples(keys.size() * static_cast<std::size_t>(patch_vertices(kLevel)));
    std::vector<std::byte> mask((keys.size() + 7) / 8, std::byte{0});
    for (std::size_t p = 0; p < keys.size(); ++p) mask[p / 8] |= static_cast<std::byte>(1u << (p % 8));
    std::vector<std::uint16_t> errors(keys.size() * level_error_values(kLevel));
    std::vector<PatchBounds> bounds(keys.size());
    std::vector<NormalCone> cones(keys.size());
    const WorldWriter writer{info, &world.octree(), {keys, mask, samples, errors, bounds, cones}};
    std::vector<std::byte> file;
    EXPECT_TRUE(write_world(writer, file).ok());
    const Status status = loaded.terrain.load(file);
    EXPECT_EQ(loaded.terrain.patch_count(), status.ok() ? info.patches : 0u);
    return status;
  };
  const std::vector<PatchKey> keys = world.keys();
  const std::uint32_t volumes = world.info().volumes;
  EXPECT_TRUE(load(keys, volumes).ok());

  // The last patch of a volume with several is missing; then all of a volume with one.
  const auto following = [&](bool several) {
    for (std::size_t k = keys.size() / 2; k + 1 < keys.size(); ++k) {
      if (keys[k + 1].case_patch() == 0 && (keys[k].case_patch() > 0) == several) return k;
    }
    return keys.size();
  };
  std::vector<PatchKey> fewer = keys;
  fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(following(true)));
  EXPECT_STREQ(load(fewer, volumes).field(), "patches");
  fewer = keys;
  const std::size_t single = following(false);
  fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(single));
  EXPECT_STREQ(load(fewer, volumes - 1).field(), "volumes");

  // As many of each, but one lies elsewhere: in a corner that holds no surface.
  const glm::ivec3 extent = world.extent();
  std::vector<PatchKey> others = keys;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(single));
  for (std::uint32_t y = 1; others.size() < keys.size() && y <= static_cast<std::uint32_t>(extent.y); ++y) {
    const PatchKey key = PatchKey::make(kOnlyRegion, 1, y, 1, 0);
    const auto at = std::lower_bound(others.begin(), others.end(), key);
    if (!std::binary_search(keys.begin(), keys.end(), key)) others.insert(at, key);
  }
  ASSERT_EQ(others.size(), keys.size());
  const Status status = load(others, volumes);
  EXPECT_EQ(status.code(), StatusCode::corrupt);
  EXPECT_STREQ(status.field(), "patch keys");
}

TEST(Terrain, SelectNeedsACamera) {
  const test::TestWorld world = hilly_world();
  LoadedTerrain loaded(world);
  Terrain::Selection selection;
  EXPECT_STREQ(loaded.terrain.select({}, selection).field(), "camera");
}

}  // namespace
}  // namespace karst::core
