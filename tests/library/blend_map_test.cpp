// SPDX-License-Identifier: MIT
// Painted weights on the ground: the materials that a blend map names lie where it says, and nowhere else.
#include <cstring>
#include <memory>
#include <utility>

#include <gtest/gtest.h>

#include "terrain/shading/materials.h"
#include "tests/library/colours.h"
#include "tests/library/host.h"
#include "tests/support/test_world.h"
#include "tests/support/world_io.h"

namespace karst {
namespace {

using core::BlendMap;
using core::MaterialSet;
using test::HostWorld;
using test::kBlue;
using test::kGreen;
using test::kRed;
using test::Pixels;
using test::share;

constexpr int kSide = 128;
constexpr int kMapSide = 32;
// A plain of 32 x 32 voxels with a bump. Its north west is painted green and its north east blue, by channels
// r and a.
std::vector<std::byte> painted_file(bool marked = true) {
  const test::TestWorld shape({32, 8, 32}, [](glm::ivec3 v) {
    return v.y < 3 || (v.y < 4 && v.x > 12 && v.x < 20 && v.z > 12 && v.z < 20);
  });
  const std::vector<std::byte> plain = shape.file();
  MaterialSet set = test::three_colours();
  set.blend_map = {kMapSide, kMapSide, {2, 0, 0, 3}};
  std::vector<std::byte> map(std::size_t{kMapSide} * kMapSide * core::kBlendTexelBytes);
  for (std::size_t texel = 0; texel < map.size() / 8; ++texel) {
    map[4 * texel + (texel % kMapSide < kMapSide / 2 ? 0 : 3)] = std::byte{255};
  }
  const core::WorldInfo info = shape.info();
  const std::vector<std::byte> textures = test::textures_of(set);
  const std::vector<std::uint8_t> overrides(info.patches, marked ? core::kPaintedByMap : std::uint8_t{1});
  core::WorldMaterials materials{set, textures, overrides};
  materials.blend_map = map;
  std::vector<std::byte> file;
  const Status status =
      core::write_world({info, &shape.octree(), core::read_patches(plain), materials}, file);
  EXPECT_TRUE(status.ok()) << status.what() << " " << status.field();
  return file;
}

class BlendMaps : public test::HostTest {
 protected:
  BlendMaps() : HostTest(kSide, kSide) {}
  void open_for(Shading shading, std::vector<std::byte> file = painted_file()) {
    Needs needs;
    if (shading == Shading::deferred) needs.deferred_width = needs.deferred_height = kSide;
    open(needs, {}, {.shading = shading}, std::move(file));
  }

  Pixels map() { return test::picture_from_above(*host_->world, *renderer_, picture_); }
};

TEST_F(BlendMaps, LieWhereTheyArePainted) {
  Pixels pictures[2];
  for (const Shading shading : {Shading::forward, Shading::deferred}) {
    open_for(shading);
    const WorldInfo& info = host_->world->info();
    EXPECT_EQ(info.blend_map[0], 32u);
    EXPECT_EQ(info.blend_map[1], 32u);
    const Pixels pixels = pictures[shading == Shading::deferred] = map();
    EXPECT_EQ(share(pixels, kGreen, 0.05, 0.46, 0.54, 0.95), 1);
    EXPECT_EQ(share(pixels, kBlue, 0.54, 0.95, 0.54, 0.95), 1);
    EXPECT_EQ(share(pixels, kRed, 0.05, 0.95, 0.05, 0.46), 1);
  }
  EXPECT_LE(largest_difference(pictures[0], pictures[1]), 1);
}

TEST_F(BlendMaps, APatchWithAMaterialOfItsOwnIsNotPainted) {
  open_for(Shading::forward, painted_file(false));
  EXPECT_EQ(share(map(), kRed, 0.05, 0.95, 0.05, 0.95), 1);
}

TEST_F(BlendMaps, MemoryIsInThePlan) {
  open_for(Shading::forward);
  const std::uint64_t with = host_->plan.gpu_bytes;
  HostWorld without({}, {}, [] {
    std::vector<std::byte> file = painted_file();
    std::memcpy(file.data() + core::entry_of(file, "BMAP"), "XTRA", 4);
    core::fix_checksums(file);
    return file;
  }());
  EXPECT_EQ(with - without.plan.gpu_bytes, (32u * 32 + 16 * 16 + 8 * 8 + 4 * 4) * 4);
}

TEST_F(BlendMaps, ADamagedRowFailsAtTheStart) {
  std::vector<std::byte> file = painted_file();
  const auto start =
      core::load_at<std::uint64_t>(file, core::entry_of(file, "BMAP") + core::world_offsets::kEntryOffset);
  file[start + 16 + 32 * 4 + 700] ^= std::byte{1};
  host_ = std::make_unique<HostWorld>(Needs(), Placement(), file);
  ASSERT_NE(host_->world, nullptr);
  const Status status = Renderer::create(*host_->world, picture_.loader(), {}, renderer_);
  EXPECT_EQ(status.code(), StatusCode::corrupt);
  EXPECT_STREQ(status.field(), "blend map");
}

// What lies over all of it hides the map too, and takes no memory for it.
TEST_F(BlendMaps, UnderADrapeThereIsNone) {
  Needs needs;
  needs.drape_width = needs.drape_height = 4;
  open(needs, {}, {}, painted_file());
  std::vector<std::uint8_t> blue;
  for (int k = 0; k < 16; ++k) blue.insert(blue.end(), {10, 10, 230, 255});
  ASSERT_TRUE(renderer_->set_drape(blue).ok());
  EXPECT_EQ(share(map(), kBlue, 0.05, 0.95, 0.05, 0.95), 1);
}

}  // namespace
}  // namespace karst
