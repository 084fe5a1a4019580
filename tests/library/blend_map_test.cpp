// SPDX-License-Identifier: MIT
// Painted weights on the ground: the materials that a blend map names lie where it says, and nowhere else.
#include <cstring>
#include <memory>
#include <utility>

#include <gtest/gtest.h>

#include "terrain/shading/materials.h"
#include "tests/library/host.h"
#include "tests/support/test_world.h"
#include "tests/support/world_io.h"

namespace karst {
namespace {

using core::BlendMap;
using core::MaterialSet;
using test::HostWorld;
using test::Pixels;

constexpr int kSide = 128;
constexpr int kMapSide = 32;
enum Colour : std::size_t { kRed, kGreen, kBlue };

// Red ground, and green and blue that no rule lets lie anywhere.
MaterialSet three_colours() {
  MaterialSet set;
  set.count = 3;
  set.side = 16;
  const char* const names[] = {"red", "green", "blue"};
  for (std::size_t m = 0; m < 3; ++m) {
    core::Material& material = set.materials[m];
    std::strcpy(material.name, names[m]);
    if (m > 0) material.slope_low = 3, material.slope_high = 4;
  }
  return set;
}

std::vector<std::byte> textures_of(const MaterialSet& set) {
  std::vector<std::byte> textures(texture_bytes(set), std::byte{128});
  for (int level = 0; level < texture_levels(set.side, core::TextureArray::far); ++level) {
    for (std::uint32_t m = 0; m < set.count; ++m) {
      const std::size_t first = texture_offset(set, core::TextureArray::far, level, m);
      const std::size_t last = texture_offset(set, core::TextureArray::far, level, m + 1);
      for (std::size_t at = first; at < last; ++at) {
        textures[at] = static_cast<std::byte>(at % 4 == m || at % 4 == 3 ? 220 : 10);
      }
    }
  }
  return textures;
}

// A plain of 32 x 32 voxels with a bump. Its north west is painted green and its north east blue, by channels
// r and a.
std::vector<std::byte> painted_file(bool marked = true) {
  const test::TestWorld shape({32, 8, 32}, [](glm::ivec3 v) {
    return v.y < 3 || (v.y < 4 && v.x > 12 && v.x < 20 && v.z > 12 && v.z < 20);
  });
  const std::vector<std::byte> plain = shape.file();
  MaterialSet set = three_colours();
  set.blend_map = {kMapSide, kMapSide, {2, 0, 0, 3}};
  std::vector<std::byte> map(std::size_t{kMapSide} * kMapSide * core::kBlendTexelBytes);
  for (std::size_t texel = 0; texel < map.size() / 8; ++texel) {
    map[4 * texel + (texel % kMapSide < kMapSide / 2 ? 0 : 3)] = std::byte{255};
  }
  const core::WorldInfo info = shape.info();
  const std::vector<std::byte> textures = textures_of(set);
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

  // From above, north up; all of the world.
  Pixels map() {
    const WorldInfo& info = host_->world->info();
    ViewState view;
    view.width_px = view.height_px = kSide;
    const Vec3 eye{(info.low_m.x + info.high_m.x) / 2, info.high_m.y + 20,
                   (info.low_m.z + info.high_m.z) / 2};
    view.eye = host_->world->from_world(eye);
    const Vec3 north = host_->world->from_world({eye.x, eye.y, eye.z - 1});
    EXPECT_TRUE(look_at(view, host_->world->from_world({eye.x, 0, eye.z}),
                        {north.x - view.eye.x, north.y - view.eye.y, north.z - view.eye.z}));
    for (double& entry : view.clip_from_view) entry = 0;
    view.clip_from_view[0] = 2 / (info.high_m.x - info.low_m.x);
    view.clip_from_view[5] = 2 / (info.high_m.z - info.low_m.z);
    view.clip_from_view[10] = -2.0 / 400;
    view.clip_from_view[14] = -1;
    view.clip_from_view[15] = 1;
    test::draw_frame(*renderer_, picture_, {view});
    return picture_.read();
  }
  // Pixels of a colour in a part of the picture, columns and rows in shares of it, rows from the south.
  static double share(const Pixels& pixels, Colour colour, double west, double east, double south,
                      double north) {
    int count = 0, all = 0;
    for (int y = static_cast<int>(south * kSide); y < static_cast<int>(north * kSide); ++y) {
      for (int x = static_cast<int>(west * kSide); x < static_cast<int>(east * kSide); ++x, ++all) {
        const std::uint8_t* p = pixels.at(x, y);
        bool most = true;
        for (std::size_t c = 0; c < 3; ++c) most = most && (c == colour || p[c] < p[colour]);
        count += most;
      }
    }
    return static_cast<double>(count) / all;
  }
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
