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
  // One channel of the first texel of a level, rgba8.
  int first(TextureArray array, int level, int channel, std::uint32_t layer = 0) const {
    return std::to_integer<int>(
        bytes[texture_offset(set, array, level, layer) + static_cast<std::size_t>(channel)]);
  }
  // Codes of a channel of the first layer's level, rgba4.
  std::vector<int> codes(int level, int channel) const {
    const std::size_t start = texture_offset(set, TextureArray::near, level, 0);
    std::vector<int> all;
    for (std::size_t k = 0; k < texture_image_bytes(set.format, set.side, TextureArray::near, level);
         k += 2) {
      const int texel = std::to_integer<int>(bytes[start + k]) | std::to_integer<int>(bytes[start + k + 1])
                                                                     << 8;
      all.push_back(texel >> (12 - 4 * channel) & 15);
    }
    return all;
  }
};

double mean(const std::vector<int>& values) {
  double sum = 0;
  for (const int value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

TEST(TexturePyramid, APlainImageIsPlainAtEveryLevel) {
  const Made made({plain(0.5f)}, TextureFormat::rgba8);
  ASSERT_EQ(made.bytes.size(), 4u * (64 + 16 + 4 + 1) + 4u * (256 + 64 + 16 + 4 + 1));
  for (int level = 0; level < 4; ++level) {
    EXPECT_EQ(made.first(TextureArray::far, level, 0), 124);  // 0.2 in sRGB
    EXPECT_EQ(made.first(TextureArray::far, level, 3), 128);
  }
  for (int level = 0; level < 5; ++level) {
    for (int channel = 0; channel < 4; ++channel)
      EXPECT_EQ(made.first(TextureArray::near, level, channel), 128) << channel;
  }
  EXPECT_NEAR(made.set.materials[0].average[0], 0.2f, 1e-6f);
  EXPECT_NEAR(made.set.materials[0].average[1], 0.1f, 1e-6f);
  EXPECT_NEAR(made.set.materials[0].roughness, 0.5f, 1e-6f);
  EXPECT_EQ(made.loss.normal_degrees, 0);
  EXPECT_TRUE(std::isinf(made.loss.albedo_db) && std::isinf(made.loss.roughness_db));
  EXPECT_GT(made.loss.brightness_db, 100);
}

TEST(TexturePyramid, AlbedoIsAveragedInLinearLight) {
  MaterialImage image = plain(1);
  for (std::size_t k = 0; k < image.count(); ++k)
    image.albedo[k] = glm::vec3((k + k / kSide) % 2 == 0 ? 1.0f : 0.0f);
  const Made made({image}, TextureFormat::rgba8);
  EXPECT_EQ(made.first(TextureArray::far, 0, 0), 188);  // 0.5 in sRGB, where 127 would be 0.21
  EXPECT_NEAR(made.set.materials[0].average[2], 0.5f, 1e-6f);
  // Twice as bright as the average, and black.
  const Material& material = made.set.materials[0];
  EXPECT_FLOAT_EQ(material.brightness_span, 1);
  EXPECT_EQ(made.first(TextureArray::near, 0, 0), 255);
  EXPECT_EQ(made.first(TextureArray::near, 0, 4), 1);
  EXPECT_EQ(made.first(TextureArray::near, 1, 0), 128);
  for (const float tint : material.tint) EXPECT_NEAR(tint, 1, 1e-4f);
}

// Blue does not change with brightness, red twice as much as green.
TEST(TexturePyramid, ColoursFollowBrightness) {
  MaterialImage image = plain(1);
  for (std::size_t k = 0; k < image.count(); ++k) {
    const float off = k % 2 == 0 ? 0.2f : -0.2f;
    image.albedo[k] = glm::vec3(0.3f * (1 + 2 * off), 0.3f * (1 + off), 0.3f);
  }
  const Material material = Made({image}, TextureFormat::rgba8).set.materials[0];
  // Luminance changes by a share of 2 * 0.2126 + 0.7152.
  const float most = 0.2f * (2 * 0.2126f + 0.7152f);
  EXPECT_NEAR(material.brightness_span, most, 1e-4f);
  EXPECT_NEAR(material.tint[0], 0.4f / most, 1e-3f);
  EXPECT_NEAR(material.tint[1], 0.2f / most, 1e-3f);
  EXPECT_NEAR(material.tint[2], 0, 1e-3f);
}

// Bumps that are too small to be seen make the whole rougher; each level is as rough as the image says.
TEST(TexturePyramid, LostSlopesBecomeRoughness) {
  MaterialImage image = plain(0.5f);
  for (std::size_t k = 0; k < image.count(); ++k) image.slope[k] = {k % 2 == 0 ? 0.5f : -0.5f, 0.25f};
  const Made made({image}, TextureFormat::rgba8);
  const Material& material = made.set.materials[0];
  EXPECT_FLOAT_EQ(material.slope_span, 0.5f);
  // alpha^2 = 0.5^4 + 0.5^2
  EXPECT_NEAR(material.roughness, std::pow(0.3125, 0.25), 1e-4);
  EXPECT_EQ(made.first(TextureArray::near, 0, 4 + 2), 1);
  for (int level = 0; level < 5; ++level) {
    EXPECT_EQ(made.first(TextureArray::near, level, 2), level == 0 ? 255 : 128);
    EXPECT_EQ(made.first(TextureArray::near, level, 3), 192);
  }
  for (int level = 0; level < 4; ++level) EXPECT_EQ(made.first(TextureArray::far, level, 3), 128);
}

// Between two codes of four bits, texels take turns, so that the average stays.
TEST(TexturePyramid, FewBitsKeepTheAverage) {
  MaterialImage image = plain(0.5f);
  for (std::size_t k = 0; k < image.count(); ++k) {
    image.height[k] = 0.5f;  // 7.5 of 15
    image.slope[k] = {k % 5 == 0 ? 0.3f : 0.1f, 0.0f};
  }
  const Made made({image}, TextureFormat::etc2);
  const std::vector<int> heights = made.codes(0, 1);
  EXPECT_NEAR(mean(heights), 7.5, 0.02);
  for (const int height : heights) EXPECT_TRUE(height == 7 || height == 8) << height;
  const float span = made.set.materials[0].slope_span;
  EXPECT_FLOAT_EQ(span, 0.3f);
  EXPECT_NEAR((mean(made.codes(0, 2)) - 7) / 7 * span, 0.14, 0.002);
  EXPECT_EQ(made.codes(0, 3)[9], 7);
  EXPECT_EQ(made.codes(0, 0)[9], 7);
}

// A few steep texels are cut off where that makes the others finer.
TEST(TexturePyramid, FewBitsSpareSteepSlopes) {
  MaterialImage image = plain(0.5f);
  for (std::size_t k = 0; k < image.count(); ++k)
    image.slope[k] = {k == 40 ? 8.0f : k % 2 == 0 ? 0.2f : -0.2f, 0.0f};
  const float few = Made({image}, TextureFormat::etc2).set.materials[0].slope_span;
  EXPECT_GT(few, 0.19f);
  EXPECT_LT(few, 0.5f);
  EXPECT_GT(Made({image}, TextureFormat::rgba8).set.materials[0].slope_span, few);
}

TEST(TexturePyramid, CompressedIsAboutTheSame) {
  const std::vector<MaterialImage> images = {make_sample_material("rock", 64),
                                             make_sample_material("sand", 64)};
  const Made raw(images, TextureFormat::rgba8), made(images, TextureFormat::etc2);
  EXPECT_EQ(made.bytes.size(), 2u * (32 * 32 + 16 * 16 + 64 + 3 * 16) + 2u * 2 * 5461);
  double square = 0;
  for (std::uint32_t layer = 0; layer < 2; ++layer) {
    std::vector<std::uint8_t> texels(32 * 32 * 4), blocks(32 * 32);
    std::memcpy(blocks.data(), made.bytes.data() + texture_offset(made.set, TextureArray::far, 0, layer),
                blocks.size());
    ASSERT_TRUE(decode_etc2(blocks, 32, 32, texels).ok());
    const std::size_t start = texture_offset(raw.set, TextureArray::far, 0, layer);
    for (std::size_t k = 0; k < texels.size(); ++k) {
      if (k % 4 == 3) continue;
      const double off = texels[k] - std::to_integer<int>(raw.bytes[start + k]);
      square += off * off / 3;
    }
  }
  EXPECT_NEAR(made.loss.albedo_db, 10 * std::log10(65'025 * 2 * 1'024 / square), 1e-6);
  EXPECT_GT(made.loss.albedo_db, 33);
  EXPECT_GT(made.loss.roughness_db, 36);
  EXPECT_GT(made.loss.brightness_db, 25);
  EXPECT_GT(made.loss.height_db, 30);
  EXPECT_GT(made.loss.normal_degrees, 0.5);
  EXPECT_LT(made.loss.normal_degrees, 9);
  EXPECT_GT(raw.loss.brightness_db, made.loss.brightness_db + 15);
  EXPECT_LT(raw.loss.normal_degrees, made.loss.normal_degrees / 2);
}

TEST(TexturePyramid, ThreadsChangeNothing) {
  const std::vector<MaterialImage> images = {make_sample_material("snow", 32),
                                             make_sample_material("ceiling", 32),
                                             make_sample_material("strata", 32)};
  EXPECT_EQ(Made(images, TextureFormat::etc2).bytes, Made(images, TextureFormat::etc2, 5).bytes);
}

}  // namespace
}  // namespace karst::bake
