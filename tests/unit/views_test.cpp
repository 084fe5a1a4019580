// SPDX-License-Identifier: MIT
// Several views a frame: one pool, one governor, thresholds for each that differs.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "terrain/world/residency.h"
#include "tests/support/heap_count.h"
#include "tests/support/hilly_world.h"
#include "tests/support/loaded_parts.h"

namespace karst::core {
namespace {

using test::camera_at;
using test::hilly_world;
using test::LoadedParts;
using test::wide_world;

// Two cameras that look at different sides of the world, and what they ask for.
class TwoViews {
 public:
  TwoViews(LoadedParts& parts, double fov_a, double fov_b) : parts_(parts) {
    const glm::dvec3 extent = parts.world.info().extent;
    cameras_[0] = camera_at({extent.x / 2, extent.y - 1, extent.z + 2}, 0, fov_a, -25);
    cameras_[1] = camera_at({extent.x / 2, extent.y - 1, -2}, 180, fov_b, -25);
    for (std::size_t v = 0; v < 2; ++v) requests[v].camera = &cameras_[v];
    set_error(0.5);
  }
  void set_error(double px) {
    for (ViewRequest& request : requests) request.lod.error_px = px;
  }
  Status select() { return parts_.residency.select(parts_.views_of(2), requests); }
  // A frame as programs draw it; how many patches were made.
  int frame(int most = 1 << 30) {
    parts_.residency.begin_frame();
    EXPECT_TRUE(select().ok());
    const int made = parts_.generate(true, most);
    rows = 0;
    for (MorphRows taken; !(taken = parts_.residency.take_morph_rows()).halves.empty();) {
      rows += taken.halves.size() / kMorphRow;
    }
    return made;
  }
  const Governor::State& governor() const { return parts_.residency.governor(); }
  const ViewState& view(std::size_t v) const { return parts_.views[v]; }

  std::array<ViewRequest, 2> requests;
  std::size_t rows = 0;  // of thresholds that the last frame uploaded

 private:
  LoadedParts& parts_;
  std::array<Camera, 2> cameras_;
};

TEST(Views, TwoThatFitMakeNothingOnceTheyHaveSettled) {
  const test::TestWorld shape = hilly_world();
  LoadedParts parts(shape, 1u << 20, 2);
  TwoViews two(parts, 60, 60);
  int made = 0;
  for (int frame = 0; frame < 40; ++frame) made += two.frame();
  EXPECT_GT(made, 100);
  const std::uint64_t heap = test::heap_calls();
  for (int frame = 0; frame < 40; ++frame) {
    EXPECT_EQ(two.frame(), 0) << frame;
    EXPECT_EQ(two.rows, 0u);
  }
  EXPECT_EQ(test::heap_calls(), heap);
  EXPECT_FALSE(two.governor().pool_full);
  for (std::size_t v = 0; v < 2; ++v) {
    EXPECT_EQ(two.view(v).selection().lod.capped, 0u);
    EXPECT_EQ(two.view(v).selection().lod.bound_px, 0.5f);
    EXPECT_GT(two.view(v).items().size(), 20u);
  }
  // They see other patches: each list is its own.
  EXPECT_FALSE(std::equal(two.view(0).items().begin(), two.view(0).items().end(), two.view(1).items().begin(),
                          two.view(1).items().end()));
}

TEST(Views, TwoThatDoNotFitKeepAnEqualBoundAndSettle) {
  const test::TestWorld shape = wide_world();
  for (const std::uint32_t detail : {40u, 150u, 400u, 900u}) {
    LoadedParts parts(shape, detail, 2);
    TwoViews two(parts, 60, 60);
    two.set_error(0.05);
    int frames = 0;
    int quiet = 0;
    for (; frames < 200 && quiet < 30; ++frames) quiet = two.frame() == 0 ? quiet + 1 : 0;
    EXPECT_EQ(quiet, 30) << detail;
    EXPECT_LE(frames, 60) << detail;
    const Governor::State settled = two.governor();
    EXPECT_TRUE(settled.pool_full) << detail;
    EXPECT_GT(settled.error_scale, 1.0f) << detail;
    EXPECT_EQ(settled.error_scale, settled.next_error_scale);
    std::printf(
        "%u pages for detail: settled after %d frames, %u of %u pages, error scale %.2f, bound %.2f px\n",
        detail, frames - quiet, settled.wanted_pages, parts.residency.pool().page_count(),
        double{settled.error_scale}, double{two.view(0).selection().lod.bound_px});
    for (int frame = 0; frame < 100; ++frame) EXPECT_EQ(two.frame(), 0);
    EXPECT_EQ(two.governor().error_scale, settled.error_scale);
    for (std::size_t v = 0; v < 2; ++v) {
      const SelectLod::Result& lod = two.view(v).selection().lod;
      EXPECT_EQ(lod.missing, 0u);
      if (settled.wanted_pages > parts.residency.pool().page_count()) continue;
      // All that it aims at is there: the bound is what the scale says, for both.
      EXPECT_EQ(lod.capped, 0u) << detail;
      EXPECT_FLOAT_EQ(lod.bound_px, 0.05f * settled.error_scale) << detail;
    }
  }
}

// Where not even the coarsest fits, patches that have found room keep it: nothing goes back and forth.
TEST(Views, TwoThatFitAtNoErrorSettleToo) {
  const test::TestWorld shape = hilly_world(5);
  for (const std::uint32_t detail : {40u, 150u, 400u, 900u}) {
    LoadedParts parts(shape, detail, 2);
    TwoViews two(parts, 60, 60);
    two.set_error(0.05);
    for (int frame = 0; frame < 60; ++frame) two.frame();
    EXPECT_GT(two.governor().wanted_pages, parts.residency.pool().page_count());
    EXPECT_GT(two.view(0).selection().lod.lowered + two.view(1).selection().lod.lowered, 0u);
    const float scale = two.governor().error_scale;
    for (int frame = 0; frame < 50; ++frame) EXPECT_EQ(two.frame(), 0) << detail;
    EXPECT_EQ(two.governor().error_scale, scale);
  }
}

TEST(Views, HalfTheWeightHasTwiceTheError) {
  const test::TestWorld shape = wide_world();
  LoadedParts parts(shape, 400, 2);
  TwoViews two(parts, 60, 60);
  two.set_error(0.05);
  two.requests[1].weight = 0.5;
  for (int frame = 0; frame < 60; ++frame) two.frame();
  EXPECT_EQ(two.frame(), 0);
  ASSERT_GT(two.governor().error_scale, 2.0f);
  EXPECT_FLOAT_EQ(two.view(1).selection().error_scale, two.governor().error_scale);
  EXPECT_FLOAT_EQ(two.view(0).selection().error_scale, two.governor().error_scale / 2);
  EXPECT_FLOAT_EQ(two.view(1).selection().lod.bound_px, two.view(0).selection().lod.bound_px * 2);
}

// Different optics: each view has its own thresholds, which stay what they are and are uploaded once.
TEST(Views, DifferentOpticsUploadNoRowsOnceTheyHaveSettled) {
  const test::TestWorld shape = hilly_world();
  LoadedParts parts(shape, 1u << 20, 2);
  TwoViews two(parts, 60, 35);
  for (int frame = 0; frame < 40; ++frame) two.frame();
  const ThresholdSets& sets = parts.residency.thresholds();
  const int set_a = two.view(0).threshold_set();
  const int set_b = two.view(1).threshold_set();
  ASSERT_NE(set_a, set_b);
  EXPECT_NE(sets.version(set_a), sets.version(set_b));
  EXPECT_EQ(parts.residency.first_morph_row(two.view(1)),
            static_cast<std::uint32_t>(set_b) * parts.world.config().max_resident_patches);
  const std::uint32_t version_a = sets.version(set_a);
  const std::uint32_t version_b = sets.version(set_b);
  for (int frame = 0; frame < 40; ++frame) {
    two.frame();
    EXPECT_EQ(two.rows, 0u);
    EXPECT_EQ(two.view(0).threshold_set(), set_a);
    EXPECT_EQ(two.view(1).threshold_set(), set_b);
  }
  EXPECT_EQ(sets.version(set_a), version_a);
  EXPECT_EQ(sets.version(set_b), version_b);
  // Alike, they share one.
  two.requests[1].camera = two.requests[0].camera;
  two.frame();
  EXPECT_EQ(two.view(1).threshold_set(), two.view(0).threshold_set());
  EXPECT_EQ(two.rows, 0u);
}

// What was uploaded of each set, in whatever order patches came and went, is what its thresholds say.
TEST(Views, RowsOfEverySetAreThoseOfItsThresholds) {
  const test::TestWorld shape = hilly_world();
  LoadedParts parts(shape, 60, 2);
  const std::uint32_t a_set = parts.world.config().max_resident_patches;
  std::vector<std::array<std::uint16_t, kMorphRow>> gpu(2 * a_set);
  std::array<ViewRequest, 2> requests;
  for (int frame = 0; frame < 120; ++frame) {
    const double angle = frame * 0.1;
    const Camera cameras[2] = {camera_at({10 + 8 * std::cos(angle), 11, 9 + 8 * std::sin(angle)}, frame * 3),
                               camera_at({10, 11, 9}, -frame * 5, 40)};
    for (std::size_t v = 0; v < 2; ++v) {
      requests[v].camera = &cameras[v];
      requests[v].lod.error_px = frame % 40 < 20 ? 0.3 : 3.0;
    }
    parts.residency.begin_frame();
    ASSERT_TRUE(parts.residency.select(parts.views_of(2), requests).ok());
    parts.generate(true, 8);
    for (MorphRows taken; !(taken = parts.residency.take_morph_rows()).halves.empty();) {
      for (std::size_t at = 0; at < taken.halves.size(); at += kMorphRow) {
        const auto row = taken.halves.subspan(at, kMorphRow);
        std::copy(row.begin(), row.end(), gpu[taken.first_row + at / kMorphRow].begin());
      }
    }
    for (std::size_t v = 0; v < 2; ++v) {
      const int set = parts.views[v].threshold_set();
      const std::uint32_t first = parts.residency.first_morph_row(parts.views[v]);
      for (const DrawItem& item : parts.views[v].items()) {
        std::uint16_t row[kMorphRow];
        make_morph_row(parts.world.surface(), parts.residency.thresholds().lods(set), item.patch, row);
        ASSERT_TRUE(
            std::equal(row, row + kMorphRow, gpu[first + parts.residency.pool().row(item.patch)].begin()))
            << frame;
      }
    }
  }
}

// One heap: what is off by most is made first, whoever sees it, and once for all who lack it.
TEST(Views, TheMostUrgentPatchOfAnyViewIsMadeFirst) {
  const test::TestWorld shape = hilly_world();
  LoadedParts parts(shape, 1u << 20, 2);
  TwoViews two(parts, 60, 60);
  two.set_error(20);
  for (int frame = 0; frame < 40; ++frame) two.frame();
  two.set_error(0.2);
  parts.residency.begin_frame();
  ASSERT_TRUE(two.select().ok());
  float most[2] = {0, 0};
  std::vector<std::uint8_t> wanted(parts.world.patch_count(), 0);
  for (std::size_t v = 0; v < 2; ++v) {
    for (const LackingPatch& patch : two.view(v).lacking()) {
      most[v] = std::max(most[v], patch.px);
      wanted[patch.patch] = std::max(wanted[patch.patch], patch.wanted);
    }
    EXPECT_GT(most[v], 0.0f);
  }
  std::vector<float> px(parts.world.patch_count(), 0.0f);
  for (std::size_t v = 0; v < 2; ++v) {
    for (const LackingPatch& patch : two.view(v).lacking())
      px[patch.patch] = std::max(px[patch.patch], patch.px);
  }
  PatchUpload upload;
  Status status;
  float last = std::max(most[0], most[1]);
  std::size_t made = 0;
  std::vector<bool> seen(parts.world.patch_count(), false);
  while (parts.residency.generate_next(false, upload, status)) {
    EXPECT_LE(px[upload.patch], last);
    last = px[upload.patch];
    EXPECT_FALSE(seen[upload.patch]);
    seen[upload.patch] = true;
    EXPECT_EQ(parts.residency.pool().level(upload.patch), wanted[upload.patch]);
    ++made;
  }
  EXPECT_EQ(made, static_cast<std::size_t>(std::count_if(wanted.begin(), wanted.end(),
                                                         [](std::uint8_t level) { return level > 0; })));
}

// Of two views that lack a patch, the one that wants less of it may ask first: it is made as the other wants
// it.
TEST(Views, APatchIsMadeOnceForAllWhoLackIt) {
  const test::TestWorld shape = wide_world();
  LoadedParts parts(shape, 1u << 20, 2);
  TwoViews two(parts, 60, 60);
  two.requests[1].camera = two.requests[0].camera;
  two.set_error(200);
  for (int frame = 0; frame < 40; ++frame) two.frame();
  two.requests[0].lod.error_px = 3;
  two.requests[1].lod.error_px = 0.5;
  parts.residency.begin_frame();
  ASSERT_TRUE(two.select().ok());
  std::size_t differing = 0;
  for (const LackingPatch& a : two.view(0).lacking()) {
    for (const LackingPatch& b : two.view(1).lacking()) {
      differing += a.patch == b.patch && a.wanted < b.wanted ? 1 : 0;
    }
  }
  EXPECT_GT(differing, 5u);
  std::vector<bool> made(parts.world.patch_count(), false);
  PatchUpload upload;
  Status status;
  while (parts.residency.generate_next(false, upload, status)) {
    EXPECT_FALSE(made[upload.patch]);
    made[upload.patch] = true;
  }
}

// What one view sees is not taken to make room for another one.
TEST(Views, AViewTakesNothingFromAnother) {
  const test::TestWorld shape = wide_world();
  LoadedParts parts(shape, 300, 2);
  TwoViews two(parts, 60, 60);
  two.set_error(0.05);
  for (int frame = 0; frame < 60; ++frame) two.frame();
  for (std::size_t v = 0; v < 2; ++v) {
    for (const DrawItem& item : two.view(v).items()) {
      EXPECT_GE(parts.residency.pool().needed(item.patch), item.level);
      EXPECT_GE(parts.residency.pool().level(item.patch), item.level);
    }
  }
}

// One hard frame, and many: the scale stays where nothing more is saved, and is back as soon as it is easy.
TEST(Views, TheGovernorDoesNotWindUp) {
  const test::TestWorld shape = wide_world();
  for (const int hard_frames : {1, 3, 300}) {
    LoadedParts parts(shape, 200, 2);
    TwoViews two(parts, 60, 60);
    two.set_error(8);
    for (int frame = 0; frame < 20; ++frame) two.frame();
    ASSERT_EQ(two.governor().error_scale, 1.0f);
    two.set_error(0.01);
    float most = 1;
    for (int frame = 0; frame < hard_frames; ++frame) {
      two.frame();
      most = std::max(most, two.governor().next_error_scale);
    }
    EXPECT_GT(most, 1.0f);
    two.set_error(8);
    int frames = 0;
    while (frames < 100 && two.governor().next_error_scale > 1) {
      two.frame();
      ++frames;
    }
    std::printf("%d hard frames: error scale up to %.1f, back to 1 after %d easy ones\n", hard_frames,
                double{most}, frames);
    EXPECT_LE(frames, 10);
    EXPECT_LT(most, 2000.0f);
  }
}

TEST(Views, RoomForOnePageOfEachPatchThatViewsSeeIsChecked) {
  const test::TestWorld shape = hilly_world();
  Config config = World::config_for(shape.info(), 3, 0);
  config.max_draw_items /= 2;
  EXPECT_TRUE(config.validate().ok());
  config.gpu_vertex_pages = config.max_patches - 1;
  EXPECT_TRUE(config.validate().ok());
  config.max_views = 2;
  EXPECT_STREQ(config.validate().field(), "gpu_vertex_pages");
  config.gpu_vertex_pages = config.max_patches;
  config.max_resident_patches = config.max_patches - 1;
  EXPECT_STREQ(config.validate().field(), "max_resident_patches");
  config.max_resident_patches = config.max_patches;
  EXPECT_TRUE(config.validate().ok());
  config.max_views = kMostViews + 1;
  EXPECT_STREQ(config.validate().field(), "max_views");
}

}  // namespace
}  // namespace karst::core
