// SPDX-License-Identifier: MIT
// Isosurfaces in pictures: blocks of several levels, whose meshes are made from frame to frame, are closed;
// what is drawn is where the field says, casts shadows, and takes no more memory than it was given.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "tests/library/host.h"

// Behind it, which knows the public names alone.
#include "scene/world/world_object.h"
#include "tests/support/field_shapes.h"

namespace karst::test {
namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 120;
constexpr glm::ivec3 kBlocks(8);  // 128 voxels a side
constexpr glm::dvec3 kCentre(64.0);
constexpr double kRadius = 52;

class Isosurfaces : public HostTest {
 protected:
  Isosurfaces() : HostTest(kWidth, kHeight) {}

  // A world of a few voxels at its corner, and a field.
  void open_field(const FieldShape& shape, Needs needs = {}, GlOptions options = {}) {
    const auto blocks = static_cast<std::uint32_t>(kBlocks.x * kBlocks.y * kBlocks.z);
    needs.field_blocks = needs.field_sample_blocks = blocks;
    open(needs, {}, options, TestWorld::hills({4, 4, 4}).file());
    core::TerrainParts& parts = terrain();
    ASSERT_TRUE(parts.world.field().reset(field_info(kBlocks, blocks)).ok());
    fill_field(parts.world.field(), shape);
    parts.isosurface.attach(parts.world.field());
  }
  core::TerrainParts& terrain() { return static_cast<core::WorldObject&>(*host_->world).terrain; }

  karst::ViewState view(glm::dvec3 eye_voxels, glm::dvec3 target_voxels, double error_px, double fov = 75) {
    const Vec3 origin = host_->world->info().origin_m;
    const auto place = [&](glm::dvec3 v) { return Vec3{origin.x + v.x, origin.y + v.y, origin.z + v.z}; };
    karst::ViewState view = looking(*host_->world, place(eye_voxels), place(target_voxels), kWidth, kHeight);
    set_perspective(view, fov, 0.05, 1000);
    view.error_px = error_px;
    return view;
  }
  std::set<int> levels() {
    std::set<int> out;
    for (const core::ChosenBlock& block : terrain().isosurface.drawn()) out.insert(block.block.level);
    return out;
  }
};

struct Air {
  FieldShape shape;
  std::mt19937 random{7};

  // Well within it.
  glm::dvec3 any() {
    std::uniform_real_distribution<double> at(-kRadius, kRadius);
    for (;;) {
      const glm::dvec3 p = kCentre + glm::dvec3(at(random), at(random), at(random));
      if (shape(p) > 1.5) return p;
    }
  }
  glm::dvec3 way() {
    std::normal_distribution<double> any;
    return glm::normalize(glm::dvec3(any(random), any(random), any(random) + 1e-9));
  }
};

TEST_F(Isosurfaces, NoPixelLooksThroughACaveOfSeveralLevels) {
  Air air{gyroid_cave(kCentre, kRadius, 40)};
  open_field(air.shape);
  std::size_t mixed = 0, waited = 0;
  for (int n = 0; n < 40; ++n) {
    const glm::dvec3 eye = air.any();
    const double error = std::exp2(n % 5 + 2);
    FrameResult result;
    // By turns complete, and with little time: then what was there before is drawn on.
    const double work_ms = n % 3 == 0 ? 0 : 0.05;
    ASSERT_EQ(holes(view(eye, eye + air.way(), error), work_ms, result), 0u) << n;
    mixed += levels().size() > 1;
    waited += result.lacking > 0;
    if (work_ms == 0) {
      EXPECT_TRUE(result.complete) << n;
      EXPECT_LE(result.error_px[0], error * 1.0001) << n;
    }
  }
  EXPECT_GT(mixed, 15u);
  EXPECT_GT(waited, 5u);
}

TEST_F(Isosurfaces, ABallIsRoundAtAnyDistance) {
  open_field(ball(kCentre, 40));
  for (const double distance : {60.0, 200.0, 700.0}) {
    FrameResult result;
    const karst::ViewState shown = view(kCentre + glm::dvec3(0, 0, distance), kCentre, 1, 40);
    const std::size_t beyond = holes(shown, 0, result);
    // A ball seen at distance d covers the angle asin(r / d).
    const double angle = std::asin(40 / distance);
    const double pixels = kHeight / 2.0 / std::tan(20 * 3.14159265358979 / 180) * std::tan(angle);
    const double covered = distance < 70 ? kWidth * kHeight : 3.14159265358979 * pixels * pixels;
    const double seen = static_cast<double>(kWidth * kHeight) - static_cast<double>(beyond);
    EXPECT_NEAR(seen, covered, 0.01 * covered + 2 * 3.15 * pixels) << distance;
  }
}

TEST_F(Isosurfaces, WhereThereIsNoRoomBlocksAreCoarserAndClosed) {
  Air air{gyroid_cave(kCentre, kRadius, 40)};
  Needs needs;
  needs.mesh_bytes = 400 * 512;
  open_field(air.shape, needs);
  bool coarser = false;
  for (int n = 0; n < 20; ++n) {
    const glm::dvec3 eye = air.any();
    FrameResult result;
    ASSERT_EQ(holes(view(eye, eye + air.way(), 0.25), n % 2 == 0 ? 0 : 0.2, result), 0u) << n;
    coarser = coarser || result.error_px[0] > 0.25;
    EXPECT_NE(result.limits & kLimitVertexMemory, 0u) << n;
  }
  EXPECT_TRUE(coarser);
}

TEST_F(Isosurfaces, AChangeShowsInOneFrameAndIsClosed) {
  Air air{gyroid_cave(kCentre, kRadius, 40)};
  open_field(air.shape);
  const glm::dvec3 eye = air.any();
  FrameResult result;
  ASSERT_EQ(holes(view(eye, eye + glm::dvec3(1, 0, 0), 2), 0, result), 0u);
  const Pixels before = picture_.read();
  // Rock around the eye gives way.
  const FieldShape wider = [&](glm::dvec3 p) { return std::max(air.shape(p), 14 - glm::length(p - eye)); };
  core::TerrainParts& parts = terrain();
  const glm::ivec3 low(eye - 18.0), high(eye + 18.0);
  fill_field(parts.world.field(), wider);
  parts.isosurface.change(low, high);
  // Until all of it is there, what was there is drawn.
  int waited = 0;
  for (int n = 0; n < 200; ++n) {
    ASSERT_EQ(holes(view(eye, eye + glm::dvec3(1, 0, 0), 2), 0.05, result), 0u) << n;
    if (result.lacking == 0) break;
    ++waited;
    EXPECT_EQ(largest_difference(before, picture_.read()), 0) << n;
  }
  EXPECT_EQ(result.lacking, 0u);
  EXPECT_GT(waited, 0);
  ASSERT_EQ(holes(view(eye, eye + glm::dvec3(1, 0, 0), 2), 0, result), 0u);
  EXPECT_GT(share_beyond(before, picture_.read(), 8), 0.05);
}

TEST_F(Isosurfaces, PlansCountThemAndNameWhatIsTooMuch) {
  MemoryFile file(TestWorld::hills({4, 4, 4}).file());
  Plan plain, plan;
  ASSERT_TRUE(make_plan(file.source(), plain).ok());
  plan.needs.field_blocks = plan.needs.field_sample_blocks = 64;
  plan.needs.mesh_bytes = 100 * 512;
  ASSERT_TRUE(make_plan(file.source(), plan).ok());
  EXPECT_GT(plan.cpu_bytes, plain.cpu_bytes + 64 * 4096);
  EXPECT_GE(plan.gpu_bytes, plain.gpu_bytes + 100 * 512);
  plan.needs.field_blocks = (1u << 24) + 1;
  EXPECT_STREQ(make_plan(file.source(), plan).field(), "field_blocks");
  plan.needs.field_blocks = 64;
  plan.needs.field_sample_blocks = (1u << 20) + 1;
  EXPECT_STREQ(make_plan(file.source(), plan).field(), "field_sample_blocks");
}

TEST_F(Isosurfaces, CastShadows) {
  // A ball over a plate, whose shadow falls beside it.
  open_field([](glm::dvec3 p) { return std::min(p.y - 20, glm::length(p - glm::dvec3(64, 60, 64)) - 15); });
  // What the middle of the picture shows of the plate.
  const auto brightness = [&](double x) {
    const karst::ViewState shown = view({x, 80, 110}, {x, 20, 64}, 1);
    FrameInput input;
    input.views = {&shown, 1};
    input.work_ms = 0;
    const Vec3 from = host_->world->from_world({0, 0, 0}), to = host_->world->from_world({0.6, 0.8, 0});
    input.sun.towards = {to.x - from.x, to.y - from.y, to.z - from.z};
    FrameResult result;
    EXPECT_TRUE(renderer_->begin_frame(input, result).ok());
    picture_.clear();
    Target target;
    target.viewport = {0, 0, kWidth, kHeight};
    target.framebuffer = picture_.name();
    picture_.bind();
    EXPECT_TRUE(renderer_->draw(0, target).ok());
    EXPECT_TRUE(renderer_->end_frame().ok());
    return int{picture_.read().at(kWidth / 2, kHeight / 2)[1]};
  };
  const int shadowed = brightness(34), lit = brightness(94);
  EXPECT_LT(shadowed + 40, lit);
  EXPECT_GT(shadowed, 10);
}

}  // namespace
}  // namespace karst::test
