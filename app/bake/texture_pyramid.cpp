// SPDX-License-Identifier: MIT
#include "app/bake/texture_pyramid.h"

#include "app/bake/parallel.h"

#include <algorithm>
#include <cmath>

namespace karst::bake {
namespace {

// The least average that a file may state: the shader divides by it.
constexpr float kLeastAverage = 1e-3f;

// What of a texel can be averaged.
struct Texel {
  glm::vec3 albedo{0};
  float height = 0;
  glm::vec2 slope{0};
  float slope_square = 0;  // of its length
  float alpha_square = 0;
};

struct Level {
  int side = 0;
  std::vector<Texel> texels;
};

Level finest(const MaterialImage& image) {
  Level level{image.side, std::vector<Texel>(image.count())};
  for (std::size_t k = 0; k < image.count(); ++k) {
    const glm::vec2 slope = image.slope[k];
    const float alpha = image.roughness[k] * image.roughness[k];
    level.texels[k] = {image.albedo[k], image.height[k], slope, slope.x * slope.x + slope.y * slope.y,
                       alpha * alpha};
  }
  return level;
}

Level coarser(const Level& fine) {
  Level level{fine.side / 2, {}};
  level.texels.resize(fine.texels.size() / 4);
  const auto side = static_cast<std::size_t>(fine.side), half = side / 2;
  for (std::size_t j = 0; j < half; ++j) {
    for (std::size_t i = 0; i < half; ++i) {
      Texel& to = level.texels[j * half + i];
      const std::size_t first = 2 * j * side + 2 * i;
      for (const std::size_t k : {first, first + 1, first + side, first + side + 1}) {
        const Texel& from = fine.texels[k];
        to.albedo += 0.25f * from.albedo;
        to.height += 0.25f * from.height;
        to.slope += 0.25f * from.slope;
        to.slope_square += 0.25f * from.slope_square;
        to.alpha_square += 0.25f * from.alpha_square;
      }
    }
  }
  return level;
}

std::byte quantise(float value) {
  const float scaled = std::floor(std::clamp(value, 0.0f, 1.0f) * 255.0f + 0.5f);
  return static_cast<std::byte>(static_cast<int>(scaled));
}

void store_albedo(const Level& level, std::span<std::byte> rgba) {
  for (std::size_t k = 0; k < level.texels.size(); ++k) {
    const Texel& texel = level.texels[k];
    for (int c = 0; c < 3; ++c)
      rgba[4 * k + static_cast<std::size_t>(c)] = static_cast<std::byte>(linear_to_srgb(texel.albedo[c]));
    rgba[4 * k + 3] = quantise(texel.height);
  }
}

void store_normals(const Level& level, std::span<std::byte> rgba) {
  for (std::size_t k = 0; k < level.texels.size(); ++k) {
    const Texel& texel = level.texels[k];
    const float square = texel.slope.x * texel.slope.x + texel.slope.y * texel.slope.y;
    const float variance = std::max(texel.slope_square - square, 0.0f);
    const float roughness = std::sqrt(std::sqrt(texel.alpha_square + variance));
    const float length = std::sqrt(1 + square);
    rgba[4 * k] = rgba[4 * k + 2] = quantise(roughness);
    rgba[4 * k + 1] = quantise(-texel.slope.y / length * 0.5f + 0.5f);
    rgba[4 * k + 3] = quantise(-texel.slope.x / length * 0.5f + 0.5f);
  }
}

}  // namespace

std::vector<std::byte> MakeTextures::run(MaterialSet& set) const {
  std::vector<std::byte> bytes(texture_bytes(set));
  const auto place = [&](TextureArray array, int level, std::uint32_t layer) {
    return std::span(bytes).subspan(texture_offset(set, array, level, layer),
                                    texture_image_bytes(set.format, set.side, level));
  };
  parallel_chunks(images.size(), 1, threads, [&](std::size_t layer, std::size_t, int) {
    const auto index = static_cast<std::uint32_t>(layer);
    Level level = finest(images[layer]);
    for (int k = 0; k < texture_levels(set.side); ++k) {
      if (k > 0) level = coarser(level);
      store_albedo(level, place(TextureArray::albedo_height, k, index));
      store_normals(level, place(TextureArray::normal_roughness, k, index));
    }
    const std::span<const std::byte> last =
        place(TextureArray::albedo_height, texture_levels(set.side) - 1, index);
    for (std::size_t c = 0; c < 3; ++c) {
      const float average = srgb_to_linear(std::to_integer<int>(last[c]));
      set.materials[index].average[c] = std::max(average, kLeastAverage);
    }
  });
  return bytes;
}

}  // namespace karst::bake
