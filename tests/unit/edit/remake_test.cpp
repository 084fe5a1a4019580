// SPDX-License-Identifier: MIT
// After edits the GPU has what making all vertices anew gives: a buffer of pages stands for it, uploads are
// copied there, and no page is written that the last frame drew.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "terrain/edit/patch/edit_heights.h"
#include "terrain/edit/undo/take_part.h"
#include "terrain/patch/displacement.h"
#include "tests/support/edited_world.h"
#include "tests/support/loaded_parts.h"

namespace karst::core {
namespace {

using test::LoadedWorld;
using test::TestWorld;

class Gpu {
 public:
  explicit Gpu(TerrainParts& live)
      : live_(live), buffer_(std::size_t{live.residency.pool().page_count()} * kPageVertices) {
    drawn_.resize(live.residency.pool().page_count());
  }

  // All patches, at a level or, with 0, at levels that differ from one to the next.
  void fill(int all = 0) {
    const int most = live_.world.info().level;
    live_.residency.begin_frame();
    for (PatchId patch = 0; patch < live_.world.patch_count(); ++patch) {
      if (live_.world.is_free(patch) || live_.residency.pool().level(patch) > 0) continue;
      PatchUpload upload;
      Status status;
      const int level = all > 0 ? all : 1 + static_cast<int>(random_.below(most));
      ASSERT_TRUE(live_.residency.make_resident(patch, level, upload, status));
      write(upload);
    }
  }

  // A frame that sees every other patch.
  void draw() {
    std::fill(drawn_.begin(), drawn_.end(), false);
    for (PatchId patch = 0; patch < live_.world.patch_count(); ++patch) {
      const int level = live_.residency.pool().level(patch);
      if (level == 0 || patch % 2 != 0) continue;
      live_.residency.pool().see(patch, level);
      for_each_page(patch, [&](std::uint32_t page) { drawn_[page] = true; });
    }
    live_.residency.begin_frame();
  }

  // What an edit asks for. Returns how many vertices.
  std::size_t follow(const EditChange& change) {
    live_.residency.follow_edit(change.touched, change.rows, change.vanished);
    std::uint32_t most = 0xffffffffu;
    return remake(most);
  }

  std::size_t remake(std::uint32_t& most) {
    PatchUpload upload;
    Status status;
    std::size_t vertices = 0;
    while (live_.residency.remake_next(upload, status, most)) {
      vertices += upload.vertices.size();
      write(upload);
    }
    EXPECT_TRUE(status.ok());
    return vertices;
  }

  // places: those of vertices and of what they become alone.
  void expect_current(bool places = false) {
    const int most = live_.world.info().level;
    std::vector<GpuVertex> all(static_cast<std::size_t>(patch_vertices(most)));
    std::uint32_t different = 0;
    for (PatchId patch = 0; patch < live_.world.patch_count(); ++patch) {
      const int level = live_.residency.pool().level(patch);
      if (level == 0) continue;
      ASSERT_TRUE(live_.residency.generate(patch, most, level, all).ok());
      const auto count = static_cast<std::size_t>(patch_vertices(level));
      std::size_t done = 0;
      for_each_page(patch, [&](std::uint32_t page) {
        const std::size_t here = std::min<std::size_t>(kPageVertices, count - done);
        for (std::size_t v = 0; v < here; ++v) {
          GpuVertex is = buffer_[std::size_t{page} * kPageVertices + v];
          GpuVertex shall = all[done + v];
          if (places) is.normal = shall.normal = is.morph_normal = shall.morph_normal = 0;
          different += !(is == shall);
        }
        done += here;
      });
      ASSERT_EQ(done, count);
    }
    ASSERT_EQ(different, 0u);
  }

 private:
  template <class Visit>
  void for_each_page(PatchId patch, const Visit& visit) {
    const PageTable pages = live_.residency.pages();
    std::uint32_t count = 0;
    for (std::uint32_t page = pages.first_page[patch]; page != kNoPage; page = pages.next_page[page], ++count)
      visit(page);
    ASSERT_EQ(count, slot_pages(live_.residency.pool().level(patch)));
  }

  void write(const PatchUpload& upload) {
    std::size_t place = 0;
    const auto first = static_cast<std::size_t>(upload.first_vertex);
    for_each_page(upload.patch, [&](std::uint32_t page) {
      const std::size_t begin = std::max(place * kPageVertices, first);
      const std::size_t end = std::min((place + 1) * kPageVertices, first + upload.vertices.size());
      if (begin < end) {
        EXPECT_FALSE(drawn_[page]) << "page " << page << " may be drawn still";
        std::copy_n(upload.vertices.begin() + static_cast<std::ptrdiff_t>(begin - first), end - begin,
                    buffer_.begin() + static_cast<std::ptrdiff_t>(std::size_t{page} * kPageVertices +
                                                                  begin % kPageVertices));
      }
      ++place;
    });
  }

  TerrainParts& live_;
  std::vector<GpuVertex> buffer_;
  std::vector<bool> drawn_;
  test::Random random_{77};
};

TestWorld rough_world(std::uint64_t seed, int level) {
  TestWorld world = TestWorld::noise(seed, {12, 9, 11}, 0.45, 5.0, false);
  world.roughen(level, seed + 7, 1200);
  return world;
}

// Taking steps back and doing them again follows as well.
TEST(Remake, StrokesThatAreTakenBackAndDoneAgain) {
  test::Random random{8};
  std::size_t steps = 0;
  for (std::uint64_t round = 0; round < 4; ++round) {
    LoadedWorld live(rough_world(20 + round, 4).file(), 2'000);
    std::vector<std::byte> room(8u << 20);
    UndoLog log;
    log.create(room);
    Gpu gpu(live);
    gpu.fill();
    for (int edit = 0; edit < 12; ++edit) {
      gpu.draw();
      EditChange change;
      log.begin();
      const Edit made = test::random_heights_edit(random, live.world.info().extent);
      ASSERT_TRUE(edit_heights(live.world, made, &log, change).ok());
      log.end();
      if (change.changed) gpu.follow(change);
      for (const bool back : {true, false}) {
        gpu.draw();
        const auto take = [&](UndoPart part) {
          take_part(live.world, part, back, [&](const EditChange& one) { gpu.follow(one); });
        };
        steps += back ? log.undo(take) : log.redo(take);
        gpu.expect_current();
        if (testing::Test::HasFatalFailure()) FAIL() << "round " << round << " edit " << edit;
        gpu.fill();
      }
    }
  }
  EXPECT_GT(steps, 60u);
}

TEST(Remake, RandomDabsAndHolesLeaveWhatAllAnewWouldBe) {
  test::Random random{31};
  std::size_t dabs = 0, holes = 0;
  for (std::uint64_t round = 0; round < 8; ++round) {
    const int level = 2 + static_cast<int>(round % 4);
    LoadedWorld live(rough_world(round, level).file(), 2'000);
    Gpu gpu(live);
    gpu.fill();
    for (int edit = 0; edit < 30; ++edit) {
      gpu.draw();
      EditChange change;
      const bool hole = random.below(4) == 0;
      Edit made = hole
                      ? test::random_voxel_edit(random, live.world.info().extent, live.world.octree().depth())
                      : test::random_heights_edit(random, live.world.info().extent);
      if (!hole && edit % 2 == 0) made.radius = 0.1 + 0.1 * random.below(6);
      const Status status =
          hole ? edit_shape(live.world, made, change) : edit_heights(live.world, made, nullptr, change);
      ASSERT_TRUE(status.ok()) << status.what() << " " << status.field();
      if (!change.changed) continue;
      ++(hole ? holes : dabs);
      gpu.follow(change);
      gpu.expect_current();
      if (testing::Test::HasFatalFailure()) FAIL() << "round " << round << " edit " << edit;
      gpu.fill();
    }
  }
  EXPECT_GT(dabs, 60u);
  EXPECT_GT(holes, 20u);
}

// What a frame has no turn for is closed at once, and finer and shaded right some frames later.
TEST(Remake, LargeHolesTakeTurns) {
  constexpr std::uint32_t kTurns = 7;
  int frames = 0, holes = 0;
  for (std::uint64_t round = 0; round < 4; ++round) {
    LoadedWorld live(rough_world(60 + round, 4).file(), 2'000);
    Gpu gpu(live);
    gpu.fill();
    for (int edit = 0; edit < 4; ++edit) {
      Edit hole;
      hole.tool = edit % 2 == 0 ? EditTool::clear : EditTool::fill;
      hole.place = glm::dvec3(live.world.info().extent) * 0.5;
      hole.radius = 2.5;
      // The second one comes while the first has its turns.
      for (int dab = 0; dab < 2; ++dab) {
        gpu.draw();
        hole.place.x += 0.7;
        EditChange change;
        ASSERT_TRUE(edit_shape(live.world, hole, change).ok());
        if (!change.changed) continue;
        ++holes;
        live.residency.follow_edit(change.touched, change.rows, change.vanished);
        std::uint32_t most = kTurns;
        gpu.remake(most);
        gpu.expect_current(true);
      }
      while (live.residency.has_plain()) {
        gpu.draw();
        std::uint32_t most = kTurns;
        gpu.remake(most);
        EXPECT_TRUE(most == 0 || !live.residency.has_plain());
        gpu.expect_current(true);
        if (testing::Test::HasFatalFailure()) FAIL() << "round " << round << " edit " << edit;
        ++frames;
      }
      gpu.expect_current();
      if (testing::Test::HasFatalFailure()) FAIL() << "round " << round << " edit " << edit;
      gpu.fill();
    }
  }
  EXPECT_GT(holes, 16);
  EXPECT_GT(frames, 100);
}

// A dab in the middle of a patch is made in it alone, and of its pages those that change.
TEST(Remake, ADabInsideAPatchWritesItsPagesAlone) {
  constexpr int kLevel = 5;
  TestWorld shape = TestWorld::hills();
  shape.roughen(kLevel, 3, 300);
  const std::vector<std::byte> file = shape.file();
  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
  Config config = World::config_for(reader.info(), kLevel, 40'000);
  World::add_edit_room(500, config);
  test::LoadedParts live(config);
  ASSERT_TRUE(live.load(file).ok());
  Gpu gpu(live);
  gpu.fill(kLevel);
  const World& world = live.world;
  int tried = 0;
  for (PatchId patch = 0; patch < world.surface().patches.size() && tried < 20; patch += 7) {
    if (world.is_free(patch) || world.surface().patches[patch].collapsed != 0) continue;
    gpu.draw();
    Edit dab;
    dab.tool = EditTool::extrude;
    dab.radius = 0.12;
    dab.strength = 0.02;
    const int middle = patch_cells(kLevel) / 2;
    const std::uint32_t block = world.surface().patches[patch].height_block;
    const int height = block == kNoHeights ? 0 : world.heights().block(block)[middle * 33 + middle];
    const BasePoint base = base_point(world.surface(), kLevel, patch, middle, middle);
    dab.place = glm::dvec3(patch_origin(world.surface().volume_of(patch))) / double{kStepsPerVoxel} +
                base.position + base.direction * (height / double{kStepsPerVoxel});
    EditChange change;
    ASSERT_TRUE(edit_heights(live.world, dab, nullptr, change).ok());
    ASSERT_TRUE(change.changed);
    const auto made = std::ranges::count_if(change.rows, [](GridRows rows) { return rows.any(); });
    if (made > 1) continue;  // its other side, or one beside it, lies as near
    ++tried;
    EXPECT_GT(change.touched.size(), 1u);
    const std::size_t vertices = gpu.follow(change);
    EXPECT_GT(vertices, 0u);
    EXPECT_LT(vertices, static_cast<std::size_t>(patch_vertices(kLevel)) * 3 / 4 + kPageVertices);
    gpu.expect_current();
  }
  EXPECT_GE(tried, 10);
}

}  // namespace
}  // namespace karst::core
