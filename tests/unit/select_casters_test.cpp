// SPDX-License-Identifier: MIT
// What casts into a shadow map: all of the box, as coarse as the map allows, neighbours at most a level
// apart.
#include "terrain/shadow/select_casters.h"

#include <functional>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/support/test_world.h"

namespace karst::core {
namespace {

constexpr int kLevel = 5;

class Casters : public testing::Test {
 protected:
  Casters()
      : world_({30, 16, 26}, [](glm::ivec3 v) {
          return v.y < 7 + 4 * test::value_noise(3, glm::dvec3(v.x, 0, v.z) / 6.0);
        }) {
    world_.roughen(kLevel, 9, 900);
    bounds_ = world_.bounds();
    errors_ = world_.level_errors();
    const auto patches = static_cast<std::uint32_t>(bounds_.size());
    boxes_.resize(BoundsTree::node_count(patches));
    tree_.create(boxes_);
    EXPECT_TRUE(tree_.build(world_.surface(), bounds_).ok());
    lods_.resize(patches);
    resident_.assign(patches, kLevel);
    wanted_.resize(patches);
    levels_.resize(patches);
    lacking_.resize(patches);
    items_.resize(patches);
    CameraSettings settings;
    settings.position = {14, 12, 12};
    EXPECT_TRUE(make_camera(settings, camera_).ok());
    FitCascades fit;
    fit.settings = {.count = 2, .size = 512, .reach_voxels = 40};
    fit.camera = &camera_;
    fit.to_sun = glm::normalize(glm::dvec3(0.5, 0.6, -0.3));
    fit.world = tree_.node(tree_.rows() - 1, 0);
    fit.light = &light_;
    fit.cascades = cascades_;
    EXPECT_TRUE(fit.validate().ok());
    fit.run();
    SetThresholds set;
    set.scale = make_error_scale(camera_, 1280, 720, 2);
    set.max_level = kLevel;
    set.surface = world_.surface();
    set.bounds = bounds_;
    set.errors = {kLevel, errors_};
    set.lods = lods_;
    EXPECT_TRUE(set.validate().ok());
    set.run();
  }

  SelectCasters stage(int cascade) {
    SelectCasters select;
    select.settings.max_level = select.settings.resident_level = kLevel;
    select.cascade = &cascades_[cascade];
    select.surface = world_.surface();
    select.bounds = bounds_;
    select.tree = &tree_;
    select.lods = lods_;
    select.errors = {kLevel, errors_};
    select.resident = resident_;
    select.wanted = wanted_;
    select.levels = levels_;
    select.lacking = lacking_;
    select.items = items_;
    return select;
  }

  // Of patches in the box.
  void expect_close(std::span<const std::uint8_t> levels) const {
    for (PatchId p = 0; p < levels.size(); ++p) {
      for (const PatchEdge edge : world_.surface().patches[p].neighbour) {
        if (!edge.exists() || levels[p] == 0 || levels[edge.patch()] == 0) continue;
        EXPECT_LE(levels[p], levels[edge.patch()] + 1) << p;
      }
    }
  }

  test::TestWorld world_;
  std::vector<PatchBounds> bounds_;
  std::vector<std::uint16_t> errors_;
  std::vector<LatticeBox> boxes_;
  BoundsTree tree_;
  std::vector<PatchLod> lods_;
  std::vector<std::uint8_t> resident_, wanted_, levels_;
  std::vector<std::uint32_t> lacking_;
  std::vector<DrawItem> items_;
  Camera camera_;
  LightSpace light_;
  Cascade cascades_[kMostCascades];
};

TEST_F(Casters, AreWhatTheBoxHoldsAtLevelsThatTheMapShows) {
  for (const int cascade : {0, 1}) {
    for (const double texels : {0.25, 1.0, 16.0}) {
      SelectCasters select = stage(cascade);
      select.error_texels = texels;
      ASSERT_TRUE(select.validate().ok());
      SelectCasters::Result result;
      ASSERT_TRUE(select.run(result).ok());
      EXPECT_EQ(result.lacking, 0u);
      EXPECT_EQ(levels_, wanted_);
      expect_close(levels_);
      const LodEye eye = make_lod_eye(cascades_[cascade].eye, 1.0f);
      std::uint32_t inside = 0;
      for (PatchId p = 0; p < bounds_.size(); ++p) {
        const LatticeBox box = patch_box(world_.surface(), bounds_, p);
        const bool casts = classify(cascades_[cascade].frustum, box, kAllPlanes) != kOutside;
        inside += casts ? 1u : 0u;
        ASSERT_EQ(levels_[p] != 0, casts) << p;
        if (!casts) continue;
        const int place = level_at(lods_[p], least_apparent_distance(lods_[p], eye));
        EXPECT_LE(levels_[p], place);
        EXPECT_TRUE(levels_[p] == place ||
                    select.errors.error(p, levels_[p]) <= texels * cascades_[cascade].texel * kStepsPerVoxel);
      }
      EXPECT_EQ(result.drawn, inside);
    }
  }
}

TEST_F(Casters, AreCutToWhatIsHeld) {
  test::Random random{4};
  for (std::uint8_t& level : resident_) level = static_cast<std::uint8_t>(random.below(kLevel + 1));
  SelectCasters select = stage(1);
  select.error_texels = 0.25;
  SelectCasters::Result result;
  ASSERT_TRUE(select.run(result).ok());
  expect_close(wanted_);
  expect_close(levels_);
  std::uint32_t lacking = 0;
  for (PatchId p = 0; p < levels_.size(); ++p) {
    EXPECT_LE(levels_[p], resident_[p]);
    lacking += wanted_[p] > resident_[p] ? 1u : 0u;
  }
  EXPECT_EQ(result.lacking, lacking);
  bool holes = true;
  for (const std::uint32_t p : std::span(lacking_).first(lacking)) {
    EXPECT_LT(resident_[p], wanted_[p]);
    EXPECT_TRUE(holes || resident_[p] != 0) << "holes come first";
    holes = resident_[p] == 0;
  }
  select.items = select.items.first(3);
  const Status status = select.run(result);
  EXPECT_STREQ(status.field(), "max_draw_items");
  EXPECT_EQ(result.drawn, 3u);
}

TEST_F(Casters, RefusesOneWrongFieldAtATime) {
  const std::pair<const char*, std::function<void(SelectCasters&)>> cases[] = {
      {"cascade", [](SelectCasters& s) { s.cascade = nullptr; }},
      {"error_texels", [](SelectCasters& s) { s.error_texels = 0; }},
      {"base_level", [](SelectCasters& s) { s.base_level = 0; }},
      {"bounds", [](SelectCasters& s) { s.bounds = {}; }},
      {"tree", [](SelectCasters& s) { s.tree = nullptr; }},
      {"lods", [](SelectCasters& s) { s.lods = {}; }},
      {"errors", [](SelectCasters& s) { s.errors = {}; }},
      {"resident", [](SelectCasters& s) { s.resident = {}; }},
      {"wanted", [](SelectCasters& s) { s.wanted = {}; }},
      {"levels", [](SelectCasters& s) { s.levels = {}; }},
      {"lacking", [](SelectCasters& s) { s.lacking = {}; }},
  };
  for (const auto& [field, spoil] : cases) {
    SelectCasters select = stage(0);
    spoil(select);
    EXPECT_STREQ(select.validate().field(), field);
  }
}

}  // namespace
}  // namespace karst::core
