// SPDX-License-Identifier: MIT
// Materials of an isosurface's voxels in pictures: they lie where the voxels are, at all levels of detail and
// both ways of shading; between two of them no third one is seen; what has none looks as if none could be.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "tests/library/colours.h"
#include "tests/library/host.h"

// Behind it, which knows the public names alone.
#include "scene/world/world_object.h"
#include "tests/support/field_shapes.h"

namespace karst::test {
namespace {

constexpr int kSide = 144;
constexpr glm::ivec3 kBlocks(8);  // 128 voxels a side
constexpr glm::dvec3 kCentre(64.0);

// Material m has colour m % 3; by rules all is the first, red.
core::MaterialSet colours(std::uint32_t count) {
  core::MaterialSet set = three_colours();
  set.count = count;
  for (std::uint32_t m = 3; m < count; ++m) {
    set.materials[m] = set.materials[m % 3];
    set.materials[m].slope_low = 3;
    set.materials[m].slope_high = 4;
    set.materials[m].name[0] = static_cast<char>('0' + m);
  }
  return set;
}
using Code = std::function<std::uint8_t(glm::ivec3 sample)>;

class IsosurfaceMaterials : public HostTest {
 protected:
  IsosurfaceMaterials() : HostTest(kSide, kSide) {}

  // material_blocks less than 0: as many as there are.
  void open_field(const FieldShape& shape, std::uint32_t materials, karst::Shading shading,
                  int material_blocks = -1) {
    const auto blocks = static_cast<std::uint32_t>(kBlocks.x * kBlocks.y * kBlocks.z);
    Needs needs;
    needs.field_blocks = needs.field_sample_blocks = blocks;
    needs.field_material_blocks = material_blocks < 0 ? blocks : static_cast<std::uint32_t>(material_blocks);
    if (shading == karst::Shading::deferred) needs.deferred_width = needs.deferred_height = kSide;
    const core::MaterialSet set = colours(materials);
    const std::vector<std::byte> bytes = textures_of(set);
    open(needs, {}, {.shading = shading}, TestWorld::hills({4, 4, 4}).file({set, bytes}));
    core::FieldBlocks& field = terrain().world.field();
    ASSERT_TRUE(field.reset(field_info(kBlocks, blocks)).ok());
    fill_field(field, shape);
    terrain().isosurface.attach(field);
  }
  core::TerrainParts& terrain() { return static_cast<core::WorldObject&>(*host_->world).terrain; }
  void make_of(const Code& code) {
    core::FieldMaterials& out = terrain().world.field().materials();
    ASSERT_TRUE(out.exists());
    for (int b = 0; b < kBlocks.x * kBlocks.y * kBlocks.z; ++b) {
      const glm::ivec3 block(b % kBlocks.x, b / kBlocks.x % kBlocks.y, b / kBlocks.x / kBlocks.y);
      const std::span<std::uint8_t> codes = out.open(block);
      ASSERT_FALSE(codes.empty());
      for (int s = 0; s < 4096; ++s)
        codes[static_cast<std::size_t>(s)] = code(block * 16 + glm::ivec3(s & 15, s >> 4 & 15, s >> 8));
      out.close(block);
    }
    terrain().isosurface.change(glm::ivec3(0), kBlocks * 16 - 1);
  }

  // From the south; from afar as large as from near.
  Pixels picture(double distance, double error_px) {
    const Vec3 origin = host_->world->info().origin_m;
    const auto place = [&](glm::dvec3 v) { return Vec3{origin.x + v.x, origin.y + v.y, origin.z + v.z}; };
    karst::ViewState view =
        looking(*host_->world, place(kCentre + glm::dvec3(0, 0, distance)), place(kCentre), kSide, kSide);
    set_perspective(view, 2 * std::atan(36 / distance) * 180 / 3.14159265358979, 0.05, 3000);
    view.error_px = error_px;
    FrameResult result;
    EXPECT_EQ(holes(view, 0, result), 0u);
    EXPECT_TRUE(result.complete);
    EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
    return picture_.read();
  }
  int coarsest() {
    int level = 0;
    for (const core::ChosenBlock& block : terrain().isosurface.drawn())
      level = std::max(level, int{block.block.level});
    return level;
  }
};

// A wall to the north, rough so that triangles of all kinds cross the borders.
double rough_wall(glm::dvec3 p) {
  return 1.2 * std::sin(0.31 * p.x + 1) * std::sin(0.27 * p.y) + p.z - 64;
}

TEST_F(IsosurfaceMaterials, LieWhereTheVoxelsAre) {
  for (const std::uint32_t count : {3u, 8u}) {
    // Of eight, the last and the sixth.
    const auto green = static_cast<std::uint8_t>(count == 3 ? 2 : 8);
    const auto blue = static_cast<std::uint8_t>(count == 3 ? 3 : 6);
    Pixels pictures[2][2];
    for (const karst::Shading shading : {karst::Shading::forward, karst::Shading::deferred}) {
      open_field(rough_wall, count, shading);
      make_of([&](glm::ivec3 at) {
        // Behind the surface is other rock, and in the air before it, too.
        if (at.z < 60) return std::uint8_t{1};
        if (at.z > 66) return std::uint8_t{1};
        return at.y >= 80 ? std::uint8_t{0} : at.x < 64 ? green : blue;
      });
      for (const bool coarse : {false, true}) {
        const Pixels pixels = pictures[shading == karst::Shading::deferred][coarse] =
            picture(coarse ? 100 : 70, coarse ? 60 : 1);
        EXPECT_EQ(coarsest() > 1, coarse) << coarsest();
        EXPECT_EQ(share(pixels, kGreen, 0, 0.47, 0, 0.68), 1) << count << ' ' << coarse;
        EXPECT_EQ(share(pixels, kBlue, 0.53, 1, 0, 0.68), 1) << count << ' ' << coarse;
        EXPECT_EQ(share(pixels, kRed, 0, 1, 0.76, 1), 1) << count << ' ' << coarse;
      }
    }
    for (const bool coarse : {false, true})
      EXPECT_LE(largest_difference(pictures[0][coarse], pictures[1][coarse]), 2) << count << ' ' << coarse;
  }
}

TEST_F(IsosurfaceMaterials, BetweenTwoNoThirdIsSeen) {
  for (const karst::Shading shading : {karst::Shading::forward, karst::Shading::deferred}) {
    open_field(rough_wall, 3, shading);
    // The first and the third in patches of a few voxels: numbers between them are the second's, which is
    // green.
    make_of([](glm::ivec3 at) { return static_cast<std::uint8_t>((at.x / 5 + at.y / 7) % 2 == 0 ? 1 : 3); });
    for (const double error : {1.0, 60.0}) {
      const Pixels pixels = picture(70, error);
      EXPECT_EQ(share(pixels, kGreen, 0, 1, 0, 1), 0);
      EXPECT_GT(share(pixels, kRed, 0, 1, 0, 1), 0.35);
      EXPECT_GT(share(pixels, kBlue, 0, 1, 0, 1), 0.35);
    }
  }
}

TEST_F(IsosurfaceMaterials, MixesAreSeenAsMixes) {
  open_field([](glm::dvec3 p) { return p.z - 64; }, 3, karst::Shading::forward);
  // More blue from west to east, by sevenths.
  make_of([](glm::ivec3 at) {
    const int sevenths = std::clamp((at.x - 36) / 8, 0, 7);
    if (sevenths == 0 || sevenths == 7) return static_cast<std::uint8_t>(sevenths == 0 ? 2 : 3);
    return core::code_of({2, 3, static_cast<std::uint8_t>(sevenths)});
  });
  const Pixels pixels = picture(70, 1);
  // The height of texels is alike, so the blend is theirs by share alone.
  double before = -1e9, least = 1e9, most = -1e9;
  for (int x = 4; x < kSide - 4; ++x) {
    const std::uint8_t* p = pixels.at(x, kSide / 2);
    const double blue = int{p[2]} - int{p[1]};
    EXPECT_GE(blue, before - 8) << x;
    before = std::max(before, blue);
    least = std::min(least, blue);
    most = std::max(most, blue);
  }
  EXPECT_LT(least, -40);
  EXPECT_GT(most, 40);
  // Half way, both.
  const std::uint8_t* p = pixels.at(kSide / 2, kSide / 2);
  EXPECT_GT(p[1], 40);
  EXPECT_GT(p[2], 40);
}

TEST_F(IsosurfaceMaterials, WhatHasNoneLooksAsIfNoneCouldBe) {
  for (const karst::Shading shading : {karst::Shading::forward, karst::Shading::deferred}) {
    open_field(rough_wall, 3, shading, 0);
    EXPECT_FALSE(terrain().world.field().materials().exists());
    const Pixels without = picture(70, 1);
    open_field(rough_wall, 3, shading, 1);
    ASSERT_TRUE(terrain().world.field().materials().exists());
    const Pixels with = picture(70, 1);
    EXPECT_EQ(largest_difference(without, with), 0);
    EXPECT_EQ(share(with, kRed, 0, 1, 0, 1), 1);
  }
}

TEST_F(IsosurfaceMaterials, MemoryIsInThePlan) {
  std::uint64_t cpu[2], gpu[2];
  for (const int blocks : {0, 5}) {
    open_field(rough_wall, 3, karst::Shading::deferred, blocks);
    cpu[blocks > 0] = host_->plan.cpu_bytes;
    gpu[blocks > 0] = host_->plan.gpu_bytes;
  }
  EXPECT_EQ(cpu[1] - cpu[0], 5 * 4096u + 4 * 512u);
  EXPECT_EQ(gpu[1] - gpu[0], 2u * kSide * kSide);
  Plan plan;
  plan.needs.field_material_blocks = (1u << 20) + 1;
  EXPECT_STREQ(make_plan(host_->source, plan).field(), "field_material_blocks");
}

}  // namespace
}  // namespace karst::test
