// SPDX-License-Identifier: MIT
// Worlds of a ground with a region of voxels in it: closed from outside, from inside of a cave and across the
// region's sides, whatever is missing; queries meet the cave and the ground; shadows are cast by both.
#include <array>
#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/library/ground_file.h"
#include "tests/library/region_frames.h"

namespace karst {
namespace {

using test::Pixels;

// Voxels are a metre, nodes of size 0 two.
constexpr glm::ivec3 kExtent{41, 24, 37};
constexpr int kFirst[2] = {12, 9};
constexpr int kSamples[2] = {189, 165};
// A chamber, and a shaft from it up into the open.
constexpr glm::dvec3 kChamber{20, 6, 18};
constexpr double kChamberRadius = 4.5;
constexpr double kShaftRadius = 1.8;
constexpr double kShaftX = 23;

double ground_height(double x, double z) {
  return 15 + 3 * test::value_noise(5, glm::dvec3(x, 0, z) / 9.0);
}

bool in_cave(glm::dvec3 p) {
  const glm::dvec3 from = p - kChamber;
  if (glm::length(from) < kChamberRadius) return true;
  return std::hypot(p.x - kShaftX, p.z - kChamber.z) < kShaftRadius && p.y > kChamber.y;
}

std::vector<std::byte> region_file() {
  test::TestWorld voxels(
      kExtent,
      [](glm::ivec3 v) {
        const glm::dvec3 middle = glm::dvec3(v) + 0.5;
        return middle.y < ground_height(middle.x, middle.z) && !in_cave(middle);
      },
      true);
  voxels.set_heights(3, [](glm::dvec3) { return 0.0; });
  test::MemoryRegion region{kExtent.x, kExtent.z, kFirst[0], kFirst[1], {}};
  region.measure.error = 16.0 * core::kStepsPerVoxel;
  region.measure.reach = core::kStepsPerVoxel * glm::length(glm::dvec3(kExtent));
  const test::MemoryGround ground(
      kSamples[0], kSamples[1], 4096, 4096,
      [](std::int64_t i, std::int64_t k) {
        const double x = 0.5 + 0.5 * double(i) - 2 * kFirst[0];
        const double z = 0.5 + 0.5 * double(k) - 2 * kFirst[1];
        return static_cast<std::int32_t>(ground_height(x, z) * core::kStepsPerVoxel / core::kVertexStep);
      },
      {region});
  return test::ground_file(ground, voxels);
}

class Regions : public test::RegionHostTest {
 protected:
  static const std::vector<std::byte>& file() {
    static const std::vector<std::byte> bytes = region_file();
    return bytes;
  }
  void open_region(Needs needs = {}, GlOptions options = {}) { open(needs, {}, options, file()); }
};

TEST_F(Regions, TheWorldSaysWhereItsVoxelsAre) {
  open_region();
  const WorldInfo& info = host_->world->info();
  EXPECT_EQ(info.region_first[0][0], kFirst[0]);
  EXPECT_EQ(info.region_first[0][1], kFirst[1]);
  EXPECT_EQ(info.region_nodes[0][0], 20);
  EXPECT_EQ(info.region_nodes[0][1], 18);
  EXPECT_DOUBLE_EQ(info.ground_spacing_m[0], 0.5);
  EXPECT_NEAR(info.low_m.x, 0.5 - 2 * kFirst[0], 1e-6);
  const DeviceInfo device = device_info(*renderer_);
  EXPECT_EQ(device.cpu_bytes, host_->plan.cpu_bytes);
  EXPECT_EQ(device.gpu_bytes, host_->plan.gpu_bytes);
}

TEST_F(Regions, QueriesMeetTheCaveInsideAndTheGroundOutside) {
  Needs needs;
  needs.queries = 1;
  open_region(needs);
  Query* query = nullptr;
  ASSERT_TRUE(host_->world->take_query(query).ok());
  const auto surfaces = [&](double x, double z, std::span<Hit> hits) {
    const std::uint32_t count = query->column(host_->world->from_world({x, 100, z}), Wait::for_file, hits);
    for (Hit& hit : hits) hit.place = host_->world->to_world(hit.place);
    return count;
  };
  Hit hits[8];
  // The chamber beside the shaft: the ground, the chamber's ceiling and its floor.
  EXPECT_EQ(surfaces(kChamber.x - 1, kChamber.z, hits), 3u);
  EXPECT_NEAR(hits[0].place.y, ground_height(kChamber.x - 1, kChamber.z), 1);
  EXPECT_NEAR(hits[2].place.y, kChamber.y - kChamberRadius, 1);
  // Through the shaft: the floor alone.
  EXPECT_EQ(surfaces(kShaftX, kChamber.z, hits), 1u);
  EXPECT_LT(hits[0].place.y, kChamber.y);
  // In the region and far from the cave, and outside: one surface each.
  for (const auto& [x, z] : {std::pair(4.0, 5.0), std::pair(36.0, 30.0), std::pair(-10.0, 20.0),
                             std::pair(50.0, 50.0), std::pair(20.0, -10.0)}) {
    EXPECT_EQ(surfaces(x, z, hits), 1u) << x << ' ' << z;
    EXPECT_NEAR(hits[0].place.y, ground_height(x, z), 1) << x << ' ' << z;
  }
  host_->world->release(query);
}

TEST_F(Regions, NoPixelLooksThroughWhateverIsMissing) {
  const test::RegionSite site = {glm::dvec3(0.0), glm::dvec3(kExtent), kChamber};
  test::RegionScene scene = {{&site, 1}, ground_height, 12, 19};
  for (int axis = 0; axis < 2; ++axis) {
    scene.low[axis] = 1 - 2 * kFirst[axis];
    scene.high[axis] = 0.5 * kSamples[axis] - 1 - 2 * kFirst[axis];
  }
  look_for_holes(file(), scene, std::array<std::uint64_t, 2>{0, std::uint64_t{3} << 19}, 11, 600);
}

// Far away the ground stands for the region, and no patch is drawn.
TEST_F(Regions, FarAwayTheGroundStandsForIt) {
  open_region();
  const auto patches = [&](double height) {
    ViewState shown = view({20, height, 18}, {20.1, 0, 18}, 60);
    set_perspective(shown, 60, 1, 1e6);
    const FrameResult result = test::draw_frame(*renderer_, picture_, {shown}, 0);
    EXPECT_TRUE(result.complete);
    EXPECT_LE(result.error_px[0], shown.error_px);
    return costs(*renderer_).patches_drawn;
  };
  EXPECT_GT(patches(100), 0u);
  EXPECT_EQ(patches(20000), 0u);
}

// Its patches are then not looked at, until it is drawn again: in the frame that it is near, as it always is.
TEST_F(Regions, FarAwayItsPatchesAreNotLookedAt) {
  const glm::dvec3 near_by(-60, 60, 18), far_off(-20000, 4000, 18);
  const auto picture = [&](glm::dvec3 eye, double work_ms) {
    ViewState shown = view(eye, {20, 0, 18}, 60);
    set_perspective(shown, 60, 1, 1e6);
    test::draw_frame(*renderer_, picture_, {shown}, work_ms);
    return picture_.read();
  };
  open_region();
  const Pixels close = picture(near_by, 0);
  const std::uint32_t drawn = costs(*renderer_).patches_drawn;
  EXPECT_GT(drawn, 0u);
  picture(far_off, 0);
  EXPECT_EQ(costs(*renderer_).patches_drawn, 0u);
  EXPECT_EQ(costs(*renderer_).patches_skipped, 0u);
  for (const double work_ms : {0.0, 1e-3}) {
    const Pixels far_away = picture(far_off, work_ms);
    EXPECT_EQ(costs(*renderer_).patches_skipped, host_->world->info().patches);
    EXPECT_EQ(test::largest_difference(picture(far_off, 0), far_away), 0);
    EXPECT_EQ(test::largest_difference(picture(near_by, work_ms), close), 0);
    EXPECT_EQ(costs(*renderer_).patches_drawn, drawn);
    EXPECT_EQ(costs(*renderer_).patches_skipped, 0u);
    // Once it was asked for, the ground stands for it anew.
    picture(far_off, 0);
  }
}

// Under a low sun there are shadows in the region and on the ground around it.
TEST_F(Regions, BothCastShadows) {
  const auto picture = [&](std::uint32_t maps) {
    Needs needs;
    needs.shadow_maps = maps;
    needs.shadow_size = 1024;
    open_region(needs);
    const ViewState shown = view({20, 60, 18}, {20.1, 0, 18}, 60);
    FrameInput input;
    input.views = {&shown, 1};
    input.work_ms = 0;
    input.sun.towards = {1, 0.2, 0};
    FrameResult result;
    EXPECT_TRUE(renderer_->begin_frame(input, result).ok());
    picture_.clear();
    Target target;
    target.viewport = {0, 0, kWidth, kHeight};
    target.framebuffer = picture_.name();
    picture_.bind();
    EXPECT_TRUE(renderer_->draw(0, target).ok());
    EXPECT_TRUE(renderer_->end_frame().ok());
    EXPECT_EQ(costs(*renderer_).shadow_triangles > 0, maps > 0);
    close();
    return picture_.read();
  };
  const Pixels lit = picture(0), shadowed = picture(2);
  // The region is the middle third of the picture's width, and higher than the picture.
  const auto dark = [&](int first, int last) {
    int count = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = first; x < last; ++x) count += 4 * lit.at(x, y)[1] > 5 * shadowed.at(x, y)[1] ? 1 : 0;
    }
    return count;
  };
  const int in_region = dark(kWidth / 3, 2 * kWidth / 3);
  const int outside = dark(0, kWidth / 5) + dark(4 * kWidth / 5, kWidth);
  std::printf("%d pixels of the region and %d of the ground are in shadow\n", in_region, outside);
  EXPECT_GT(in_region, 100);
  EXPECT_GT(outside, 100);
}

}  // namespace
}  // namespace karst
