// SPDX-License-Identifier: MIT
// Procedural materials: they tile, look the same at every size, and are the same bits everywhere.
#include "bake/procedural/sample_materials.h"

#include "bake/procedural/tile_noise.h"
#include "bake/textures/texture_pyramid.h"
#include "terrain/base/checksum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace karst::bake {
using namespace core;
namespace {

constexpr const char* kNames[] = {"grass", "rock", "strata", "sand", "snow", "ceiling"};

TEST(TileNoise, Repeats) {
  const TileNoise noise({8, 8}, 3);
  const TileFbm fbm({4, 16}, 3, 3);
  const TileCells cells({8, 4}, 0.9f, 3);
  for (int k = 0; k < 200; ++k) {
    // Multiples of 1/1024, so that adding 1 is exact.
    const glm::vec2 p(static_cast<float>(k * 37 % 1024) / 1024, static_cast<float>(k * 101 % 1024) / 1024);
    const glm::vec2 q(p.x + 1, p.y - 2);
    EXPECT_EQ(noise.at(p), noise.at(q));
    EXPECT_EQ(fbm.at(p), fbm.at(q));
    const TileCells::Nearest a = cells.nearest(p), b = cells.nearest(q);
    EXPECT_EQ(a.id, b.id);
    EXPECT_NEAR(a.distance, b.distance, 1e-5);
    EXPECT_NEAR(cells.border(p, a), cells.border(q, b), 1e-5);
    EXPECT_LE(std::abs(noise.at(p)), 1.1f);
    EXPECT_GE(cells.border(p, a), 0);
    EXPECT_LE(a.distance, 1.5f);
  }
  EXPECT_EQ(noise.at({0.25f, 0.5f}), 0);
}

// Mean differences between neighbours, inside and across the border.
TEST(SampleMaterials, Tile) {
  for (const char* name : kNames) {
    const MaterialImage image = make_sample_material(name, 128);
    const int last = image.side - 1;
    const double share = 1.0 / last;
    double inside = 0, across = 0;
    for (int k = 0; k < image.side; ++k) {
      across += std::abs(image.height[image.at(last, k)] - image.height[image.at(0, k)]);
      across += std::abs(image.height[image.at(k, last)] - image.height[image.at(k, 0)]);
      for (int i = 0; i < last; ++i) {
        inside += share * std::abs(image.height[image.at(i, k)] - image.height[image.at(i + 1, k)]);
        inside += share * std::abs(image.height[image.at(k, i)] - image.height[image.at(k, i + 1)]);
      }
    }
    EXPECT_LT(across, 1.6 * inside) << name;
    EXPECT_GT(inside, 0) << name;
  }
}

TEST(SampleMaterials, MeanColoursAreNatural) {
  const struct {
    const char* name;
    glm::vec3 low, high;
  } ranges[] = {{"grass", {0.06f, 0.08f, 0.02f}, {0.13f, 0.14f, 0.06f}},
                {"rock", {0.16f, 0.15f, 0.13f}, {0.26f, 0.24f, 0.22f}},
                {"strata", {0.18f, 0.13f, 0.08f}, {0.32f, 0.24f, 0.18f}},
                {"sand", {0.30f, 0.22f, 0.14f}, {0.44f, 0.36f, 0.26f}},
                {"snow", {0.72f, 0.75f, 0.78f}, {0.85f, 0.88f, 0.92f}},
                {"ceiling", {0.06f, 0.05f, 0.04f}, {0.16f, 0.14f, 0.12f}}};
  for (const auto& range : ranges) {
    for (const int side : {16, 64}) {
      const MaterialImage image = make_sample_material(range.name, side);
      glm::dvec3 sum(0);
      for (std::size_t k = 0; k < image.count(); ++k) {
        sum += glm::dvec3(image.albedo[k]);
        ASSERT_TRUE(image.height[k] >= 0 && image.height[k] <= 1 && image.roughness[k] > 0.05f &&
                    image.roughness[k] <= 1)
            << range.name;
      }
      for (int c = 0; c < 3; ++c) {
        const double mean = sum[c] / static_cast<double>(image.count());
        EXPECT_GT(mean, range.low[c]) << range.name << " " << side;
        EXPECT_LT(mean, range.high[c]) << range.name << " " << side;
      }
    }
  }
}

// gcc and clang, with and without optimisation, make these very bits.
TEST(SampleMaterials, AreTheSameBitsEverywhere) {
  const struct {
    const char* name;
    std::uint32_t crc;
  } pinned[] = {{"grass", 0xdb55e01du}, {"rock", 0x142d59d1u}, {"strata", 0x3441279fu},
                {"sand", 0x957cfef2u},  {"snow", 0xae9291b3u}, {"ceiling", 0x25a1097cu}};
  for (const auto& [name, crc] : pinned) {
    std::vector<MaterialImage> images;
    images.push_back(make_sample_material(name, 64));
    MaterialSet set;
    set.count = 1;
    set.side = 64;
    set.format = TextureFormat::etc2;
    TextureLoss loss;
    EXPECT_EQ(crc32c(MakeTextures{images, 1}.run(set, loss)), crc) << name;
  }
}

}  // namespace
}  // namespace karst::bake
