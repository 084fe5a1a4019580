// SPDX-License-Identifier: MIT
// Two halls in rock: from one the other is hidden, at a bounded cost a frame, with less memory by larger
// cells, and without any not at all.
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "terrain/cull/occlusion.h"
#include "terrain/draw/draw_list.h"
#include "tests/support/culled_view.h"
#include "tests/support/heap_count.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

class Halls : public testing::Test {
 protected:
  static constexpr glm::ivec3 kExtent{40, 24, 20};

  Halls()
      : world_(kExtent,
               [](glm::ivec3 v) {
                 const auto in = [&](int low, int high) {
                   return v.x >= low && v.x <= high && v.y >= 5 && v.y <= 12 && v.z >= 5 && v.z <= 12;
                 };
                 return !in(4, 12) && !in(24, 32) && v.y < 21;
               }),
        bounds_(world_.surface().patches.size()),
        nodes_(BoundsTree::node_count(patches())),
        entries_(Occlusion::entry_count(patches())),
        levels_(patches(), 1),
        scratch_(patches()),
        items_(patches()) {
    world_.set_heights(2, [](glm::dvec3) { return 0.0; });
    const test::TestScratch scratch;
    GenerateVertices generate;
    generate.surface = world_.surface();
    generate.heights = world_.heights();
    generate.level = 2;
    generate.scratch = scratch.get();
    std::vector<GpuVertex> vertices(static_cast<std::size_t>(patch_vertices(2)));
    for (PatchId p = 0; p < patches(); ++p) generate.run(p, vertices, &bounds_[p]);
    tree_.create(nodes_);
    EXPECT_TRUE(tree_.build(world_.surface(), bounds_).ok());
    occlusion_.create(entries_, patches());
    culled_.emplace(world_.surface(), bounds_);
    CameraSettings settings;
    settings.position = {8.5, 9.0, 9.0};
    settings.yaw_deg = -90.0;
    EXPECT_TRUE(make_camera(settings, camera_).ok());
  }

  std::uint32_t patches() const { return static_cast<std::uint32_t>(world_.surface().patches.size()); }

  void build(std::size_t words) {
    words_.assign(words, 0);
    occluders_.create(words_);
    occluders_.build(world_.octree(), kExtent, world_.surface(), bounds_);
    occlusion_.reset();
  }

  BuildDrawList::Result frame(std::uint32_t searches) {
    const Frustum frustum = make_frustum(camera_);
    occlusion_.begin(occluders_, world_.octree(), tree_, world_.surface(), bounds_, camera_, searches);
    BuildDrawList list;
    list.boxes = culled_->boxes();
    list.culled = culled_->find(&frustum, tree_, &occlusion_);
    list.camera = &camera_;
    list.surface = world_.surface();
    list.levels = levels_;
    list.scratch = scratch_;
    list.items = items_;
    EXPECT_TRUE(list.validate().ok());
    BuildDrawList::Result result;
    EXPECT_TRUE(list.run(result).ok());
    return result;
  }

  // Patches in view in each hall, and on the ground above.
  struct Seen {
    int own = 0, other = 0, above = 0;
  };
  Seen listed(const BuildDrawList::Result& result) const {
    Seen seen;
    for (std::uint32_t n = 0; n < result.drawn; ++n) {
      const Volume& v = world_.surface().volume_of(items_[n].patch);
      ++(v.corner[1] > 18 ? seen.above : v.corner[0] > 18 ? seen.other : seen.own);
    }
    return seen;
  }

  test::TestWorld world_;
  std::vector<PatchBounds> bounds_;
  std::vector<LatticeBox> nodes_;
  BoundsTree tree_;
  std::optional<test::CulledView> culled_;
  std::vector<std::uint64_t> words_;
  Occluders occluders_;
  std::vector<std::uint16_t> entries_;
  Occlusion occlusion_;
  Camera camera_;
  std::vector<std::uint8_t> levels_;
  std::vector<std::uint32_t> scratch_;
  std::vector<DrawItem> items_;
};

TEST_F(Halls, OneIsHiddenFromTheOther) {
  occlusion_.end();
  build(0);
  const Seen all = listed(frame(1000));
  EXPECT_FALSE(occlusion_.active());
  EXPECT_GT(all.own, 50);
  EXPECT_GT(all.other, 100);
  EXPECT_GT(all.above, 10);

  build(Occluders::word_count(kExtent, -1));
  EXPECT_EQ(occluders_.cell_log2(), -1);
  EXPECT_EQ(occluders_.size(), kExtent * 2);
  BuildDrawList::Result result = frame(1000);
  EXPECT_TRUE(occlusion_.active());
  Seen seen = listed(result);
  EXPECT_EQ(seen.own, all.own);
  EXPECT_EQ(seen.other, 0);
  EXPECT_EQ(seen.above, 0);
  EXPECT_EQ(result.drawn + result.culled_frustum + result.culled_occluded, patches());

  build(Occluders::word_count(kExtent, 1));
  EXPECT_EQ(occluders_.cell_log2(), 1);
  EXPECT_EQ(occluders_.size(), kExtent / 2);
  seen = listed(frame(1000));
  EXPECT_EQ(seen.own, all.own);
  EXPECT_EQ(seen.other, 0);
}

// Its rays do not come from the eye, however small its picture and near its near plane.
TEST_F(Halls, NothingIsHiddenInAParallelView) {
  build(Occluders::word_count(kExtent, -1));
  EXPECT_GT(frame(1000).culled_occluded, 0u);
  CameraMatrices matrices;
  matrices.position = {8.5, 9.0, 9.0};
  matrices.view_from_world = camera_.view_from_world;
  matrices.clip_from_view = glm::dmat4(2, 0, 0, 0, 0, 2, 0, 0, 0, 0, -0.02, 0, 0, 0, -1.0002, 1);
  ASSERT_TRUE(make_camera(matrices, camera_).ok());
  ASSERT_TRUE(camera_.parallel);
  const BuildDrawList::Result result = frame(1000);
  EXPECT_FALSE(occlusion_.active());
  EXPECT_EQ(result.culled_occluded, 0u);
  EXPECT_GT(listed(result).other, 0);
}

TEST_F(Halls, AFrameIsBoundedAndTheNextOnesGoOn) {
  build(Occluders::word_count(kExtent, 0));
  const std::uint64_t heap = test::heap_calls();
  std::uint32_t searched = 0;
  int frames = 0;
  for (; frames < 400; ++frames) {
    const BuildDrawList::Result result = frame(7);
    searched += occlusion_.searched();
    EXPECT_LE(occlusion_.searched(), 7u);
    const Seen seen = listed(result);
    if (seen.other + seen.above == 0) break;
  }
  EXPECT_LT(frames, 400);
  EXPECT_GT(searched, 7u);
  // What is known is not searched for again, and what is not hidden ever more rarely.
  for (int n = 0; n < 2000; ++n) frame(1000);
  searched = 0;
  for (int n = 0; n < 100; ++n) {
    const Seen seen = listed(frame(1000));
    EXPECT_EQ(seen.other + seen.above, 0);
    searched += occlusion_.searched();
  }
  EXPECT_LE(searched, 100u * 16u);
  EXPECT_EQ(test::heap_calls(), heap);

  // The eye moves through the wall: what was hidden is seen at once.
  CameraSettings settings;
  settings.position = {28.5, 9.0, 9.0};
  settings.yaw_deg = -90.0;
  ASSERT_TRUE(make_camera(settings, camera_).ok());
  EXPECT_GT(listed(frame(0)).other, 50);
  // Deep in the rock no ray comes from air.
  settings.position = {18.5, 9.0, 9.0};
  ASSERT_TRUE(make_camera(settings, camera_).ok());
  EXPECT_EQ(frame(1000).culled_occluded, 0u);
  // At the hall's wall, too near to it to be clearly outside, rays across the hall do.
  settings.position = {4.1, 9.0, 9.0};
  ASSERT_TRUE(make_camera(settings, camera_).ok());
  occlusion_.reset();
  const BuildDrawList::Result at_wall = frame(1000);
  EXPECT_FALSE(
      occluders_.is_outside(world_.octree(), tree_, world_.surface(), bounds_, eye_lattice(camera_), 1000.0));
  EXPECT_EQ(listed(at_wall).other, 0);
  EXPECT_GT(listed(at_wall).own, 50);
}

}  // namespace
}  // namespace karst::core
