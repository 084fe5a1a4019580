// SPDX-License-Identifier: MIT
#include "bake/textures/texture_pyramid.h"

#include "bake/base/parallel.h"
#include "etc2/etc2.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace karst::bake {
using namespace etc2;
namespace {

// The least average that a file may state: the shader divides by it.
constexpr float kLeastAverage = 1e-3f;

// What errors weigh in ETC2. A wrong normal is seen before a wrong roughness, of which there are two copies.
constexpr std::array<std::uint8_t, 3> kAlbedoWeights = {1, 1, 1};
constexpr std::array<std::uint8_t, 3> kNormalWeights = {1, 8, 1};

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

// -1..1, so that 0 is a code.
std::byte quantise_part(float value) {
  const float scaled = std::floor(std::clamp(value, -1.0f, 1.0f) * 127.0f + 128.5f);
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
    rgba[4 * k + 1] = quantise_part(-texel.slope.y / length);
    rgba[4 * k + 3] = quantise_part(-texel.slope.x / length);
  }
}

// Sums over texels of one layer, of the squares of what compression changed.
struct Squares {
  double albedo = 0, height = 0, roughness = 0, degrees = 0;
};

using Rgba = std::span<const std::byte>;

double square_of(Rgba a, Rgba b, std::size_t at) {
  const int difference = std::to_integer<int>(a[at]) - std::to_integer<int>(b[at]);
  return static_cast<double>(difference * difference);
}

glm::dvec3 normal_at(Rgba rgba, std::size_t at) {
  const double s = (std::to_integer<int>(rgba[at + 3]) - 128) / 127.0;
  const double t = (std::to_integer<int>(rgba[at + 1]) - 128) / 127.0;
  return glm::dvec3(s, t, std::sqrt(std::max(1 - s * s - t * t, 0.0)));
}

void add_albedo_loss(Rgba before, Rgba after, Squares& squares) {
  for (std::size_t at = 0; at < before.size(); at += 4) {
    for (std::size_t c = 0; c < 3; ++c) squares.albedo += square_of(before, after, at + c) / 3;
    squares.height += square_of(before, after, at + 3);
  }
}

void add_normal_loss(Rgba before, Rgba after, Squares& squares) {
  for (std::size_t at = 0; at < before.size(); at += 4) {
    squares.roughness += square_of(before, after, at);
    const glm::dvec3 a = normal_at(before, at), b = normal_at(after, at);
    const double cosine = glm::dot(a, b) / std::sqrt(glm::dot(a, a) * glm::dot(b, b));
    const double degrees = std::acos(std::clamp(cosine, -1.0, 1.0)) * (180 / 3.14159265358979324);
    squares.degrees += degrees * degrees;
  }
}

// One layer of one array: an image a level.
class Layer {
 public:
  Layer(TextureArray array, TextureFormat format) : array_(array), format_(format) {}

  // out: texture_image_bytes. Returns the level's texels as they are read back; valid until the next call.
  Rgba store(const Level& level, std::span<std::byte> out) {
    rgba_.resize(level.texels.size() * 4);
    if (array_ == TextureArray::albedo_height) {
      store_albedo(level, rgba_);
    } else {
      store_normals(level, rgba_);
    }
    if (format_ == TextureFormat::rgba8) {
      std::copy(rgba_.begin(), rgba_.end(), out.begin());
      return rgba_;
    }
    const auto side = static_cast<std::uint32_t>(level.side);
    Etc2Settings settings;
    settings.weights = array_ == TextureArray::albedo_height ? kAlbedoWeights : kNormalWeights;
    decoded_.resize(rgba_.size());
    const std::span<std::uint8_t> blocks(reinterpret_cast<std::uint8_t*>(out.data()), out.size());
    const Status encoded = encode_etc2(as_bytes(rgba_), side, side, blocks, settings);
    const Status decoded =
        decode_etc2(blocks, side, side, {reinterpret_cast<std::uint8_t*>(decoded_.data()), decoded_.size()});
    // Sizes and settings are this file's own.
    static_cast<void>(encoded);
    static_cast<void>(decoded);
    return decoded_;
  }
  Rgba before() const { return rgba_; }

 private:
  static std::span<const std::uint8_t> as_bytes(const std::vector<std::byte>& bytes) {
    return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
  }

  TextureArray array_;
  TextureFormat format_;
  std::vector<std::byte> rgba_, decoded_;
};

double psnr(double square_sum, double texels) {
  return 10 * std::log10(255.0 * 255.0 * texels / square_sum);
}

TextureLoss loss_of(std::span<const Squares> layers, double texels) {
  Squares sum;
  for (const Squares& s : layers) {
    sum.albedo += s.albedo;
    sum.height += s.height;
    sum.roughness += s.roughness;
    sum.degrees += s.degrees;
  }
  return {psnr(sum.albedo, texels), psnr(sum.height, texels), psnr(sum.roughness, texels),
          std::sqrt(sum.degrees / texels)};
}

}  // namespace

std::vector<std::byte> MakeTextures::run(MaterialSet& set, TextureLoss& loss) const {
  std::vector<std::byte> bytes(texture_bytes(set));
  std::vector<Squares> squares(kTextureArrays * images.size());
  // A layer of an array a task.
  parallel_chunks(squares.size(), 1, threads, [&](std::size_t task, std::size_t, int) {
    const std::size_t index = task / kTextureArrays;
    const auto array = static_cast<TextureArray>(task % kTextureArrays);
    const auto number = static_cast<std::uint32_t>(index);
    Layer layer(array, set.format);
    Level level = finest(images[index]);
    Rgba texels;
    for (int k = 0; k < texture_levels(set.side); ++k) {
      if (k > 0) level = coarser(level);
      const std::span<std::byte> out = std::span(bytes).subspan(texture_offset(set, array, k, number),
                                                                texture_image_bytes(set.format, set.side, k));
      texels = layer.store(level, out);
      if (k > 0) continue;
      if (array == TextureArray::albedo_height) {
        add_albedo_loss(layer.before(), texels, squares[task]);
      } else {
        add_normal_loss(layer.before(), texels, squares[task]);
      }
    }
    if (array == TextureArray::normal_roughness) {
      set.materials[index].roughness = static_cast<float>(std::to_integer<int>(texels[0])) / 255.0f;
      return;
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const float average = srgb_to_linear(std::to_integer<int>(texels[c]));
      set.materials[index].average[c] = std::max(average, kLeastAverage);
    }
  });
  loss = loss_of(squares, static_cast<double>(images.size()) * set.side * set.side);
  return bytes;
}

}  // namespace karst::bake
