// SPDX-License-Identifier: MIT
// Worlds of a ground with an isosurface in a region of it: closed from outside, from inside of a cave and
// across the region's sides, whatever is missing; far away the ground stands for it; shadows are cast by
// both.
#include <array>
#include <cmath>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/library/ground_file.h"
#include "tests/library/region_frames.h"
#include "tests/support/field_shapes.h"

namespace karst {
namespace {

using test::Pixels;

// Voxels are a metre of eight cells, nodes of size 0 two.
constexpr glm::ivec3 kExtent{33, 24, 33};
constexpr int kCells = 8;
constexpr int kFirst[2] = {12, 9};
constexpr int kSamples[2] = {189, 165};
// A chamber, and a shaft from it up into the open.
constexpr glm::dvec3 kChamber{16, 6, 16};
constexpr double kChamberRadius = 4.5;
constexpr double kShaftRadius = 1.8;
constexpr double kShaftX = 19;

double ground_height(double x, double z) {
  return 15 + 3 * test::value_noise(5, glm::dvec3(x, 0, z) / 9.0);
}

// Metres, above 0 in the air.
double distance(glm::dvec3 p) {
  const double land = 0.8 * (p.y - ground_height(p.x, p.z));
  const double chamber = kChamberRadius - glm::length(p - kChamber);
  const double shaft = std::min(kShaftRadius - std::hypot(p.x - kShaftX, p.z - kChamber.z), p.y - kChamber.y);
  return std::max({land, chamber, shaft});
}

std::vector<std::byte> field_region_file() {
  test::TestWorld voxels(
      kExtent, [](glm::ivec3 v) { return distance(glm::dvec3(v) + 0.5) < 0; }, true);
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
  core::FieldInfo info;
  info.cell_log2 = core::kLeastCellLog2;
  info.in_region = true;
  info.blocks = {(kExtent.x - 1) * kCells / 16 + 1, kExtent.y * kCells / 16,
                 (kExtent.z - 1) * kCells / 16 + 1};
  info.stored = static_cast<std::uint32_t>(info.table_blocks());
  std::vector<std::uint32_t> table(info.table_blocks());
  std::vector<std::byte> samples(table.size() * core::FieldBlocks::kBlockBytes);
  core::FieldBlocks field;
  field.create({table, samples});
  EXPECT_TRUE(field.reset(info).ok());
  test::fill_field(field, [](glm::dvec3 s) { return kCells * distance(s / double{kCells} + 0.5); });
  return test::ground_file(ground, voxels, field, 8'000);
}

class FieldRegions : public test::RegionHostTest {
 protected:
  static const std::vector<std::byte>& file() {
    static const std::vector<std::byte> bytes = field_region_file();
    return bytes;
  }
  void open_region(Needs needs = {}, GlOptions options = {}) { open(needs, {}, options, file()); }
};

TEST_F(FieldRegions, TheWorldSaysWhatItHas) {
  open_region();
  const WorldInfo& info = host_->world->info();
  EXPECT_EQ(info.patches, 0u);
  EXPECT_EQ(info.regions, 1u);
  EXPECT_EQ(info.region_first[0][0], kFirst[0]);
  EXPECT_EQ(info.region_nodes[0][1], 16);
  EXPECT_DOUBLE_EQ(info.field_cell_m, 1.0 / kCells);
  const DeviceInfo device = device_info(*renderer_);
  EXPECT_EQ(device.cpu_bytes, host_->plan.cpu_bytes);
  EXPECT_EQ(device.gpu_bytes, host_->plan.gpu_bytes);
}

// Where the region's surface is, on the shaft's floor and on the ground beside.
TEST_F(FieldRegions, QueriesMeetTheHighestSurface) {
  Needs needs;
  needs.queries = 1;
  open_region(needs);
  Query* query = nullptr;
  ASSERT_TRUE(host_->world->take_query(query).ok());
  const auto height = [&](double x, double z) {
    Hit hit;
    EXPECT_TRUE(query->ground(host_->world->from_world({x, 1000, z}), 0, Wait::for_file, hit))
        << x << " " << z;
    return host_->world->to_world(hit.place).y;
  };
  int in_region = 0;
  for (double z = -6.3; z < 39; z += 2.9) {
    for (double x = -6.1; x < 39; x += 2.7) {
      if (std::hypot(x - kShaftX, z - kChamber.z) < kShaftRadius + 1) continue;
      EXPECT_NEAR(height(x, z), ground_height(x, z), 0.06) << x << " " << z;
      in_region += x > 1 && x < 32 && z > 1 && z < 32 ? 1 : 0;
    }
  }
  EXPECT_GT(in_region, 90);
  const double aside = kShaftX - kChamber.x;
  EXPECT_NEAR(height(kShaftX, kChamber.z),
              kChamber.y - std::sqrt(kChamberRadius * kChamberRadius - aside * aside), 0.06);
  EXPECT_FALSE(query->inside(host_->world->from_world({kChamber.x, kChamber.y, kChamber.z}), Wait::for_file));
  EXPECT_TRUE(query->inside(host_->world->from_world({8, 4, 8}), Wait::for_file));
  host_->world->release(query);
}

TEST_F(FieldRegions, NoPixelLooksThroughWhateverIsMissing) {
  const test::RegionSite site = {glm::dvec3(0.0), glm::dvec3(kExtent), kChamber};
  test::RegionScene scene = {{&site, 1}, ground_height, 12, 19};
  for (int axis = 0; axis < 2; ++axis) {
    scene.low[axis] = 1 - 2 * kFirst[axis];
    scene.high[axis] = 0.5 * kSamples[axis] - 1 - 2 * kFirst[axis];
  }
  look_for_holes(file(), scene, std::array<std::uint64_t, 2>{0, std::uint64_t{3} << 19}, 11, 300);
}

// Far away the ground stands for it, and no block is drawn.
TEST_F(FieldRegions, FarAwayTheGroundStandsForIt) {
  open_region();
  const auto blocks = [&](double height) {
    ViewState shown = view({16, height, 16}, {16.1, 0, 16}, 60);
    set_perspective(shown, 60, 1, 1e6);
    const FrameResult result = test::draw_frame(*renderer_, picture_, {shown}, 0);
    EXPECT_TRUE(result.complete);
    EXPECT_LE(result.error_px[0], shown.error_px);
    return costs(*renderer_).blocks_drawn;
  };
  EXPECT_GT(blocks(100), 0u);
  EXPECT_EQ(blocks(20000), 0u);
  EXPECT_GT(blocks(100), 0u);
}

// Under a low sun there are shadows in the region and on the ground around it.
TEST_F(FieldRegions, BothCastShadows) {
  const auto picture = [&](std::uint32_t maps) {
    Needs needs;
    needs.shadow_maps = maps;
    needs.shadow_size = 1024;
    open_region(needs);
    const ViewState shown = view({16, 60, 16}, {16.1, 0, 16}, 60);
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
  const auto dark = [&](int first, int last) {
    int count = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = first; x < last; ++x) count += 4 * lit.at(x, y)[1] > 5 * shadowed.at(x, y)[1] ? 1 : 0;
    }
    return count;
  };
  EXPECT_GT(dark(kWidth * 2 / 5, kWidth * 3 / 5), 100);
  EXPECT_GT(dark(0, kWidth / 5) + dark(4 * kWidth / 5, kWidth), 100);
}

}  // namespace
}  // namespace karst
