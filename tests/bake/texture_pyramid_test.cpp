// SPDX-License-Identifier: MIT
// Pyramids of textures: what is averaged how, and what compression costs.
#include "bake/textures/texture_pyramid.h"

#include "bake/procedural/sample_materials.h"
#include "etc2/etc2.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

namespace karst::bake {
using namespace etc2;
namespace {

constexpr int kSide = 16;

MaterialImage plain(float roughness) {
  MaterialImage image(kSide);
  for (std::size_t k = 0; k < image.count(); ++k) {
    image.albedo[k] = glm::vec3(0.2f, 0.1f, 0.4f);
    image.height[k] = 0.5f;
    image.roughness[k] = roughness;
  }
  return image;
}

struct Made {
  MaterialSet set;
  TextureLoss loss;
  std::vector<std::byte> bytes;

  Made(const std::vector<MaterialImage>& images, TextureFormat format, int threads = 1) {
    set.count = static_cast<std::uint32_t>(images.size());
    set.side = static_cast<std::uint32_t>(images[0].side);
    set.format = format;
    bytes = MakeTextures{images, threads}.run(set, loss);
  }
  // One channel of the first texel of a level.
  int first(TextureArray array, int level, int channel, std::uint32_t layer = 0) const {
    return std::to_integer<int>(
        bytes[texture_offset(set, array, level, layer) + static_cast<std::size_t>(channel)]);
  }
};

TEST(TexturePyramid, APlainImageIsPlainAtEveryLevel) {
  const Made made({plain(0.5f)}, TextureFormat::rgba8);
  ASSERT_EQ(made.bytes.size(), 2u * 4 * (256 + 64 + 16 + 4 + 1));
  for (int level = 0; level < 5; ++level) {
    EXPECT_EQ(made.first(TextureArray::albedo_height, level, 0), 124);  // 0.2 in sRGB
    EXPECT_EQ(made.first(TextureArray::albedo_height, level, 3), 128);
    EXPECT_EQ(made.first(TextureArray::normal_roughness, level, 0), 128);
    EXPECT_EQ(made.first(TextureArray::normal_roughness, level, 1), 128);
    EXPECT_EQ(made.first(TextureArray::normal_roughness, level, 2), 128);
    EXPECT_EQ(made.first(TextureArray::normal_roughness, level, 3), 128);
  }
  EXPECT_NEAR(made.set.materials[0].average[0], 0.2f, 0.003f);
  EXPECT_NEAR(made.set.materials[0].average[1], 0.1f, 0.003f);
  EXPECT_EQ(made.loss.normal_degrees, 0);
  EXPECT_TRUE(std::isinf(made.loss.albedo_db));
}

TEST(TexturePyramid, AlbedoIsAveragedInLinearLight) {
  MaterialImage image = plain(1);
  for (std::size_t k = 0; k < image.count(); ++k)
    image.albedo[k] = glm::vec3((k + k / kSide) % 2 == 0 ? 1.0f : 0.0f);
  const Made made({image}, TextureFormat::rgba8);
  EXPECT_EQ(made.first(TextureArray::albedo_height, 0, 0), 255);
  EXPECT_EQ(made.first(TextureArray::albedo_height, 1, 0), 188);  // 0.5 in sRGB, where 127 would be 0.21
  EXPECT_NEAR(made.set.materials[0].average[2], 0.5f, 0.005f);
}

// What a level loses of the slopes' variance, its roughness gains.
TEST(TexturePyramid, LostNormalsBecomeRoughness) {
  MaterialImage image = plain(0.5f);
  for (std::size_t k = 0; k < image.count(); ++k) image.slope[k] = {k % 2 == 0 ? 0.5f : -0.5f, 0.25f};
  const Made made({image}, TextureFormat::rgba8);
  const double length = std::sqrt(1 + 0.25 + 0.0625);
  EXPECT_NEAR(made.first(TextureArray::normal_roughness, 0, 3), 128 - 127 * 0.5 / length, 0.51);
  EXPECT_NEAR(made.first(TextureArray::normal_roughness, 0, 0), 127.5, 1);
  const double coarse = std::sqrt(1 + 0.0625);
  for (int level = 1; level < 5; ++level) {
    EXPECT_EQ(made.first(TextureArray::normal_roughness, level, 3), 128);
    EXPECT_NEAR(made.first(TextureArray::normal_roughness, level, 1), 128 - 127 * 0.25 / coarse, 0.51);
    // alpha^2 = 0.5^4 + 0.5^2
    EXPECT_NEAR(made.first(TextureArray::normal_roughness, level, 0), 255 * std::pow(0.3125, 0.25), 1);
    EXPECT_EQ(made.first(TextureArray::normal_roughness, level, 0),
              made.first(TextureArray::normal_roughness, level, 2));
  }
}

TEST(TexturePyramid, Etc2DecodesToAboutTheSame) {
  const std::vector<MaterialImage> images = {make_sample_material("rock", 64),
                                             make_sample_material("sand", 64)};
  const Made raw(images, TextureFormat::rgba8), made(images, TextureFormat::etc2);
  EXPECT_EQ(made.bytes.size() * 4, 2u * 2 * (64 * 64 + 32 * 32 + 16 * 16 + 64 + 16 + 16 + 16) * 4);
  double square = 0;
  for (std::uint32_t layer = 0; layer < 2; ++layer) {
    std::vector<std::uint8_t> texels(64 * 64 * 4), blocks(64 * 64);
    std::memcpy(blocks.data(),
                made.bytes.data() + texture_offset(made.set, TextureArray::albedo_height, 0, layer),
                blocks.size());
    ASSERT_TRUE(decode_etc2(blocks, 64, 64, texels).ok());
    const std::size_t start = texture_offset(raw.set, TextureArray::albedo_height, 0, layer);
    for (std::size_t k = 0; k < texels.size(); ++k) {
      if (k % 4 == 3) continue;
      const double off = texels[k] - std::to_integer<int>(raw.bytes[start + k]);
      square += off * off / 3;
    }
  }
  EXPECT_NEAR(made.loss.albedo_db, 10 * std::log10(65'025 * 2 * 4'096 / square), 1e-6);
  EXPECT_GT(made.loss.albedo_db, 33);
  EXPECT_GT(made.loss.height_db, 36);
  EXPECT_GT(made.loss.roughness_db, 20);
  EXPECT_GT(made.loss.normal_degrees, 0);
  EXPECT_LT(made.loss.normal_degrees, 9);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(made.set.materials[0].average[c] / raw.set.materials[0].average[c], 1, 0.05);
  }
}

TEST(TexturePyramid, ThreadsChangeNothing) {
  const std::vector<MaterialImage> images = {make_sample_material("snow", 32),
                                             make_sample_material("ceiling", 32),
                                             make_sample_material("strata", 32)};
  EXPECT_EQ(Made(images, TextureFormat::etc2).bytes, Made(images, TextureFormat::etc2, 5).bytes);
}

}  // namespace
}  // namespace karst::bake
