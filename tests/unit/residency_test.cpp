// SPDX-License-Identifier: MIT
// One view: what is made resident is what it wants and what the stages make, a full pool makes it coarser,
// and frames take no memory.
#include "terrain/world/residency.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstring>

#include "tests/support/heap_count.h"
#include "tests/support/hilly_world.h"
#include "tests/support/loaded_parts.h"

namespace karst::core {
namespace {

using test::camera_at;
using test::hilly_world;
using test::LoadedParts;

constexpr int kLevel = 3;

TEST(Residency, GeneratesWhatTheStagesGenerate) {
  const test::TestWorld world = hilly_world();
  LoadedParts parts(world);
  ASSERT_EQ(parts.world.patch_count(), world.surface().patches.size());
  std::vector<GpuVertex> vertices(static_cast<std::size_t>(patch_vertices(kLevel)));
  for (PatchId p = 0; p < parts.world.patch_count(); ++p) {
    ASSERT_TRUE(parts.residency.generate(p, kLevel, kLevel, vertices).ok());
    ASSERT_EQ(vertices, world.vertices(p, kLevel));
    const PatchBounds& b = parts.world.bounds()[p];
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
int settle(LoadedParts& parts, const ViewRequest& view) {
  int made = 0;
  for (int round = 0; round < 100; ++round) {
    EXPECT_TRUE(parts.select(view).ok());
    const int now = parts.generate();
    made += now;
    if (now == 0 && !parts.residency.governor().pool_full) break;
    parts.residency.begin_frame();
  }
  return made;
}

TEST(Residency, AThousandFramesTakeNoHeap) {
  const test::TestWorld world = hilly_world();
  LoadedParts parts(world, 40);  // a small pool: patches come and go
  const std::vector<std::byte> file = world.file();

  const std::uint64_t before = test::heap_calls();
  ASSERT_TRUE(parts.load(file).ok());
  std::uint64_t drawn = 0;
  std::uint64_t made = 0;
  for (int frame = 0; frame < 1000; ++frame) {
    const Camera camera =
        camera_at({10 + 9 * std::cos(frame * 0.01), 9, 9 + 9 * std::sin(frame * 0.01)}, frame * 0.7);
    ViewRequest view;
    view.camera = &camera;
    view.lod.error_px = 0.5;
    parts.residency.begin_frame();
    ASSERT_TRUE(parts.select(view).ok());
    drawn += parts.view().selection().list.drawn;
    PatchUpload upload;
    Status status;
    for (int i = 0; i < 10 && parts.residency.generate_next(true, upload, status); ++i) ++made;
    parts.residency.take_morph_rows();
  }
  EXPECT_EQ(test::heap_calls() - before, 0u);
  EXPECT_GT(drawn, 1000u);
  EXPECT_GT(made, parts.world.patch_count() * 3 / 2);
  // The counter itself works.
  const std::uint64_t counted = test::heap_calls();
  std::vector<int> block(100);
  EXPECT_GT(test::heap_calls(), counted);
}

// With room for everything, what is drawn in the end is what the view wants.
TEST(Residency, EverythingWantedBecomesResident) {
  const test::TestWorld world = hilly_world();
  LoadedParts parts(world, 1u << 20);
  const std::vector<std::byte> file = world.file();
  ASSERT_TRUE(parts.load(file).ok());
  for (const double error_px : {0.2, 2.0, 20.0}) {
    parts.residency.begin_frame();
    const Camera camera = camera_at({10, 14, 18}, 0);
    ViewRequest view;
    view.camera = &camera;
    view.lod.error_px = error_px;
    settle(parts, view);
    EXPECT_EQ(parts.view().selection().lod.capped, 0u);
    EXPECT_EQ(parts.view().selection().lod.missing, 0u);
    EXPECT_FALSE(parts.residency.governor().pool_full);
    EXPECT_FLOAT_EQ(parts.view().selection().lod.bound_px, static_cast<float>(error_px));
    EXPECT_GT(parts.view().selection().list.drawn, 10u);
  }
}

// What a pool cannot hold makes the frame coarser, never wrong, and the bound says by how much.
TEST(Residency, AFullPoolRaisesTheBound) {
  const test::TestWorld world = hilly_world();
  const std::vector<std::byte> file = world.file();
  for (const std::uint32_t detail : {0u, 10u, 60u}) {
    LoadedParts parts(world, detail);
    parts.residency.begin_frame();
    const Camera camera = camera_at({10, 10, 12}, 0);
    ViewRequest view;
    view.camera = &camera;
    view.lod.error_px = 0.02;
    view.frustum_culling = false;  // all of the world is too much for the pool
    settle(parts, view);
    EXPECT_TRUE(parts.residency.governor().pool_full) << detail;
    EXPECT_EQ(parts.view().selection().lod.missing, 0u);
    EXPECT_GT(parts.view().selection().lod.bound_px, 0.02f);
    for (const DrawItem& item : parts.view().items())
      EXPECT_LE(item.level, parts.residency.pool().level(item.patch));
    // And it falls again where less is wanted.
    const Camera far_away = camera_at({10, 10, 300}, 0);
    view.camera = &far_away;
    view.lod.error_px = 50;
    for (int frame = 0; frame < 4000; ++frame) {
      parts.residency.begin_frame();
      ASSERT_TRUE(parts.select(view).ok());
      PatchUpload upload;
      Status status;
      while (parts.residency.generate_next(false, upload, status)) {
      }
    }
    EXPECT_EQ(parts.residency.governor().error_scale, 1.0f);
    EXPECT_FALSE(parts.residency.governor().pool_full);
    EXPECT_FLOAT_EQ(parts.view().selection().lod.bound_px, 50.0f);
  }
}

// Whatever way a patch became resident, by steps or at once, its vertices are those of the full level.
TEST(Residency, UploadsAddUpToTheSlot) {
  const test::TestWorld world = hilly_world();
  LoadedParts parts(world, 60);
  const std::vector<std::byte> file = world.file();
  ASSERT_TRUE(parts.load(file).ok());
  std::vector<std::vector<GpuVertex>> gpu(parts.world.patch_count());
  std::vector<std::vector<std::uint16_t>> rows(parts.world.config().max_resident_patches);
  int raised = 0;
  for (int frame = 0; frame < 300; ++frame) {
    parts.residency.begin_frame();
    const Camera camera =
        camera_at({10 + 8 * std::cos(frame * 0.1), 10, 9 + 8 * std::sin(frame * 0.1)}, frame * 3);
    ViewRequest view;
    view.camera = &camera;
    view.lod.error_px = frame % 50 < 25 ? 0.3 : 3.0;
    ASSERT_TRUE(parts.select(view).ok());
    PatchUpload upload;
    Status status;
    for (int i = 0; i < 5 && parts.residency.generate_next(true, upload, status); ++i) {
      std::vector<GpuVertex>& slot = gpu[upload.patch];
      ASSERT_LE(static_cast<std::size_t>(upload.first_vertex), slot.size());
      raised += upload.first_vertex > 0 ? 1 : 0;
      slot.resize(static_cast<std::size_t>(upload.first_vertex));
      slot.insert(slot.end(), upload.vertices.begin(), upload.vertices.end());
      EXPECT_EQ(upload.row, parts.residency.pool().row(upload.patch));
    }
    const MorphRows changed = parts.residency.take_morph_rows();
    for (std::size_t at = 0; at < changed.halves.size(); at += kMorphRow) {
      const auto row = changed.halves.subspan(at, kMorphRow);
      rows[changed.first_row + at / kMorphRow].assign(row.begin(), row.end());
    }
  }
  EXPECT_GT(raised, 10);
  for (PatchId p = 0; p < parts.world.patch_count(); ++p) {
    const int level = parts.residency.pool().level(p);
    if (level == 0) continue;
    std::vector<GpuVertex> expected = world.vertices(p, kLevel);
    expected.resize(static_cast<std::size_t>(patch_vertices(level)));
    gpu[p].resize(expected.size());
    ASSERT_EQ(gpu[p], expected) << p;
    std::uint16_t row[kMorphRow];
    make_morph_row(parts.world.surface(), parts.residency.thresholds().lods(0), p, row);
    ASSERT_TRUE(std::equal(rows[parts.residency.pool().row(p)].begin(),
                           rows[parts.residency.pool().row(p)].end(), row))
        << p;
  }
}

// Heights that do not fit memory are read from the file when vertices are made, and change nothing.
TEST(Residency, HeightsComeThroughABoundedCache) {
  const test::TestWorld world = hilly_world();
  const std::vector<std::byte> file = world.file();
  Config config = World::config_for(world.info(), kLevel);
  config.max_height_blocks = HeightCache::kLeastGroups * kHeightGroup;
  ASSERT_GT(world.info().height_blocks, config.max_height_blocks);
  LoadedParts parts(config);
  ASSERT_TRUE(parts.load(file).ok());
  EXPECT_FALSE(parts.world.holds_all_heights());
  std::vector<GpuVertex> vertices(static_cast<std::size_t>(patch_vertices(kLevel)));
  for (PatchId p = 0; p < parts.world.patch_count(); ++p) {
    ASSERT_TRUE(parts.residency.generate(p, kLevel, kLevel, vertices).ok());
    ASSERT_EQ(vertices, world.vertices(p, kLevel));
  }
  const std::uint64_t in_order = parts.residency.height_groups_read();
  EXPECT_GT(in_order, height_groups(world.info().height_blocks));
  test::Random random{7};
  for (int i = 0; i < 500; ++i) {
    const auto p = static_cast<PatchId>(random.below(static_cast<int>(parts.world.patch_count())));
    ASSERT_TRUE(parts.residency.generate(p, kLevel, kLevel, vertices).ok());
    ASSERT_EQ(vertices, world.vertices(p, kLevel));
  }
  EXPECT_GT(parts.residency.height_groups_read(), in_order);
}

TEST(Residency, AFileThatCannotBeReadAnyMoreIsReported) {
  const test::TestWorld world = hilly_world();
  std::vector<std::byte> file = world.file();
  Config config = World::config_for(world.info(), kLevel);
  config.max_height_blocks = HeightCache::kLeastGroups * kHeightGroup;
  LoadedParts parts(config);
  ASSERT_TRUE(parts.load(file).ok());
  // Heights are the largest section: all of it is damaged now.
  for (std::size_t at = file.size() / 4; at < file.size() * 3 / 4; ++at) file[at] ^= std::byte{0x55};
  parts.residency.begin_frame();
  const Camera camera = camera_at({10, 14, 18}, 0);
  ViewRequest view;
  view.camera = &camera;
  ASSERT_TRUE(parts.select(view).ok());
  PatchUpload upload;
  Status status;
  const std::uint32_t pages = parts.residency.pool().free_pages();
  while (parts.residency.generate_next(false, upload, status)) {
  }
  EXPECT_EQ(status.code(), StatusCode::corrupt);
  EXPECT_STREQ(status.field(), "height samples");
  EXPECT_LE(parts.residency.pool().free_pages(), pages);
}

TEST(Residency, RequestsAreChecked) {
  const test::TestWorld world = hilly_world();
  LoadedParts parts(world);
  const Camera camera = camera_at({10, 10, 12}, 0);
  const struct {
    const char* field;
    void (*spoil)(ViewRequest&);
  } cases[] = {{"camera", [](ViewRequest& r) { r.camera = nullptr; }},
               {"height_px", [](ViewRequest& r) { r.height_px = 0; }},
               {"height_px", [](ViewRequest& r) { r.height_px = 65'537; }},
               {"weight", [](ViewRequest& r) { r.weight = 0; }},
               {"weight", [](ViewRequest& r) { r.weight = 1025; }},
               {"weight", [](ViewRequest& r) { r.weight = NAN; }},
               {"error_px", [](ViewRequest& r) { r.lod.error_px = 0; }},
               {"error_px", [](ViewRequest& r) { r.lod.error_px = NAN; }},
               {"max_level", [](ViewRequest& r) { r.lod.max_level = 0; }}};
  ViewRequest good;
  good.camera = &camera;
  parts.residency.begin_frame();
  ASSERT_TRUE(parts.select(good).ok());
  for (const auto& c : cases) {
    ViewRequest request = good;
    c.spoil(request);
    EXPECT_STREQ(parts.select(request).field(), c.field);
    EXPECT_TRUE(parts.view().items().empty());
  }
  const ViewRequest two[] = {good, good};
  EXPECT_STREQ(parts.residency.select(std::span(parts.views).first(2), two).field(), "views");
  EXPECT_STREQ(parts.residency.select(parts.views_of(1), two).field(), "views");
}

}  // namespace
}  // namespace karst::core
