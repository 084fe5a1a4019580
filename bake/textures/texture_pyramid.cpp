// SPDX-License-Identifier: MIT
#include "bake/textures/texture_pyramid.h"

#include "bake/base/parallel.h"
#include "etc2/etc2.h"

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace karst::bake {
using namespace etc2;
namespace {

// The least average that a file may state.
constexpr float kLeastAverage = 1e-3f;
// Brightness beyond its span is cut off: that of at most this share of a texture.
constexpr float kBeyondSpan = 0.004f;
constexpr float kLeastSpan = 0.01f;
constexpr float kMostSlopeSpan = 16;
constexpr float kMostTint = 16;

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

// ITU-R BT.709.
float luminance(glm::vec3 linear) {
  return 0.2126f * linear.r + 0.7152f * linear.g + 0.0722f * linear.b;
}

float brightness_of(const Texel& texel, const Material& material) {
  const glm::vec3 average(material.average[0], material.average[1], material.average[2]);
  return luminance(texel.albedo) / luminance(average);
}

// The least span that leaves kBeyondSpan of these values out, which it reorders.
float span_of(std::vector<float>& values) {
  const auto beyond = static_cast<std::ptrdiff_t>(kBeyondSpan * static_cast<float>(values.size()));
  const auto nth = values.end() - 1 - beyond;
  std::nth_element(values.begin(), nth, values.end());
  return std::max(*nth, kLeastSpan);
}

// Of slopes: a small span cuts steep ones off, a large one is coarse. The mean square of the sine by which
// angles are off, for a code's rounding being spread evenly; or something above `most`, if it is.
float slope_loss(const Level& level, float span, const NearCodes& codes, float most) {
  const double step = double{span} / codes.steps, rounding = step * step / 12;
  double sum = 0;
  for (const Texel& texel : level.texels) {
    for (const float slope : {texel.slope.x, texel.slope.y}) {
      const double is = slope, held = std::clamp(slope, -span, span), steep = 1 + held * held;
      sum += (is - held) * (is - held) / ((1 + is * is) * steep) + rounding / (steep * steep);
    }
    if (sum > double{most}) break;
  }
  return static_cast<float>(sum);
}

float slope_span_of(const Level& level, const NearCodes& codes) {
  float most = kLeastSpan;
  for (const Texel& texel : level.texels)
    most = std::max({most, std::abs(texel.slope.x), std::abs(texel.slope.y)});
  float best = most, least = slope_loss(level, most, codes, std::numeric_limits<float>::max());
  for (float span = 0.875f * most; span >= kLeastSpan; span *= 0.875f) {
    const float loss = slope_loss(level, span, codes, least);
    if (loss < least) {
      least = loss;
      best = span;
    }
  }
  return best;
}

// How much each channel follows brightness, by least squares. Never so much that albedo becomes negative.
void set_tint(const Level& level, Material& material) {
  double product[3] = {}, square = 0;
  for (const Texel& texel : level.texels) {
    const double off = double{brightness_of(texel, material)} - 1;
    square += off * off;
    for (int c = 0; c < 3; ++c) {
      const double average = material.average[c];
      product[c] += off * (double{texel.albedo[c]} / average - 1);
    }
  }
  for (int c = 0; c < 3; ++c) {
    // Of a plain texture there is nothing to say.
    const double least = 1e-6 * static_cast<double>(level.texels.size());
    const double tint = square > least ? product[c] / square : 1;
    material.tint[c] =
        std::clamp(static_cast<float>(tint), 0.0f, std::min(1 / material.brightness_span, kMostTint));
  }
}

// average, roughness, tint and spans.
void describe(const Level& level, const NearCodes& codes, Material& material) {
  Level coarse = coarser(level);
  while (coarse.side > 1) coarse = coarser(coarse);
  const Texel& whole = coarse.texels[0];
  for (int c = 0; c < 3; ++c) material.average[c] = std::max(whole.albedo[c], kLeastAverage);
  const glm::vec2 mean = whole.slope;
  const float variance = std::max(whole.slope_square - (mean.x * mean.x + mean.y * mean.y), 0.0f);
  material.roughness = std::min(std::sqrt(std::sqrt(whole.alpha_square + variance)), 1.0f);
  std::vector<float> off;
  off.reserve(level.texels.size());
  for (const Texel& texel : level.texels) off.push_back(std::abs(brightness_of(texel, material) - 1));
  material.brightness_span = std::min(span_of(off), 1.0f);
  material.slope_span = std::min(slope_span_of(level, codes), kMostSlopeSpan);
  set_tint(level, material);
}

int code_of(float value, int most) {
  const float scaled = std::floor(std::clamp(value, 0.0f, 1.0f) * static_cast<float>(most) + 0.5f);
  return static_cast<int>(scaled);
}

// --- Images in bytes: of a level of either array, as rgba of 8 bits or as 4 channels of 0..1.

using Bytes = std::vector<std::uint8_t>;

Bytes far_image(const Level& level) {
  Bytes rgba(level.texels.size() * 4);
  for (std::size_t k = 0; k < level.texels.size(); ++k) {
    const Texel& texel = level.texels[k];
    for (int c = 0; c < 3; ++c)
      rgba[4 * k + static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(linear_to_srgb(texel.albedo[c]));
    rgba[4 * k + 3] = static_cast<std::uint8_t>(code_of(std::sqrt(std::sqrt(texel.alpha_square)), 255));
  }
  return rgba;
}

// In codes, not yet rounded.
glm::vec4 near_texel(const Texel& texel, const Material& material, const NearCodes& codes) {
  const auto middle = static_cast<float>(codes.middle), steps = static_cast<float>(codes.steps);
  const auto code = [&](float off, float span) { return middle + steps * off / span; };
  return {code(brightness_of(texel, material) - 1, material.brightness_span),
          texel.height * static_cast<float>(codes.most), code(texel.slope.x, material.slope_span),
          code(texel.slope.y, material.slope_span)};
}

// What a texel stands for: brightness, height, slopes.
glm::vec4 read_near(glm::vec4 code, const Material& material, const NearCodes& codes) {
  const glm::vec4 off = (code - static_cast<float>(codes.middle)) / static_cast<float>(codes.steps);
  return {1 + off.r * material.brightness_span, code.g / static_cast<float>(codes.most),
          off.b * material.slope_span, off.a * material.slope_span};
}

// Rounds each texel, and hands what that changed to its neighbours to the right and above. Around the right
// border, so that the texture tiles.
void diffuse(std::vector<glm::vec4>& texels, int side, int most) {
  const auto at = [side](int i, int j) { return static_cast<std::size_t>(j * side + (i + side) % side); };
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      glm::vec4& texel = texels[at(i, j)];
      glm::vec4 off;
      for (int c = 0; c < 4; ++c) {
        const float code = std::floor(std::clamp(texel[c], 0.0f, static_cast<float>(most)) + 0.5f);
        // What a channel cannot hold is not handed on.
        off[c] = std::clamp(texel[c] - code, -0.5f, 0.5f);
        texel[c] = code;
      }
      if (i + 1 < side) texels[at(i + 1, j)] += 7.0f / 16 * off;
      if (j + 1 == side) continue;
      texels[at(i - 1, j + 1)] += 3.0f / 16 * off;
      texels[at(i, j + 1)] += 5.0f / 16 * off;
      texels[at(i + 1, j + 1)] += 1.0f / 16 * off;
    }
  }
}

std::vector<glm::vec4> near_image(const Level& level, const Material& material, TextureFormat format) {
  const NearCodes codes = near_codes(format);
  std::vector<glm::vec4> texels;
  texels.reserve(level.texels.size());
  for (const Texel& texel : level.texels) texels.push_back(near_texel(texel, material, codes));
  if (format == TextureFormat::rgba4) {
    diffuse(texels, level.side, codes.most);
    return texels;
  }
  for (glm::vec4& texel : texels) {
    for (int c = 0; c < 4; ++c)
      texel[c] = std::floor(std::clamp(texel[c], 0.0f, static_cast<float>(codes.most)) + 0.5f);
  }
  return texels;
}

// --- Storing, and what it changes: sums over texels of squares.

struct Squares {
  double albedo = 0, roughness = 0, brightness = 0, height = 0, degrees = 0;
};

// Albedo errors weigh alike; alpha is apart.
void compress(const Bytes& rgba, int texels, std::span<std::byte> out, Squares& squares) {
  const auto side = static_cast<std::uint32_t>(texels);
  const std::span<std::uint8_t> blocks(reinterpret_cast<std::uint8_t*>(out.data()), out.size());
  Bytes decoded(rgba.size());
  const Status encoded = encode_etc2(rgba, side, side, blocks);
  const Status read = decode_etc2(blocks, side, side, decoded);
  // Sizes and settings are this file's own.
  static_cast<void>(encoded);
  static_cast<void>(read);
  for (std::size_t k = 0; k < rgba.size(); ++k) {
    const double off = int{rgba[k]} - int{decoded[k]};
    (k % 4 == 3 ? squares.roughness : squares.albedo) += off * off / (k % 4 == 3 ? 1 : 3);
  }
}

void store_far(const Level& level, TextureFormat format, std::span<std::byte> out, Squares& squares) {
  const Bytes rgba = far_image(level);
  if (format == TextureFormat::etc2) {
    compress(rgba, level.side, out, squares);
    return;
  }
  for (std::size_t k = 0; k < rgba.size(); ++k) out[k] = std::byte{rgba[k]};
}

void store_near(const Level& level, const Material& material, TextureFormat format, std::span<std::byte> out,
                Squares& squares) {
  const std::vector<glm::vec4> texels = near_image(level, material, format);
  const auto code = [&](std::size_t k, int c) { return static_cast<unsigned>(texels[k][c]); };
  for (std::size_t k = 0; k < texels.size(); ++k) {
    if (format == TextureFormat::rgba4) {
      // GL_UNSIGNED_SHORT_4_4_4_4, little-endian.
      out[2 * k] = static_cast<std::byte>(code(k, 2) << 4 | code(k, 3));
      out[2 * k + 1] = static_cast<std::byte>(code(k, 0) << 4 | code(k, 1));
    } else {
      for (int c = 0; c < 4; ++c)
        out[4 * k + static_cast<std::size_t>(c)] = static_cast<std::byte>(code(k, c));
    }
    const Texel& texel = level.texels[k];
    const glm::dvec4 is(read_near(texels[k], material, near_codes(format)));
    const double brighter = is.r - double{brightness_of(texel, material)};
    const double higher = is.g - double{texel.height};
    squares.brightness += brighter * brighter;
    squares.height += higher * higher;
    const glm::dvec3 a(texel.slope.x, texel.slope.y, 1), b(is.b, is.a, 1);
    const double cosine = glm::dot(a, b) / std::sqrt(glm::dot(a, a) * glm::dot(b, b));
    const double degrees = std::acos(std::clamp(cosine, -1.0, 1.0)) * (180 / 3.14159265358979324);
    squares.degrees += degrees * degrees;
  }
}

double psnr(double peak, double square_sum, double texels) {
  return 10 * std::log10(peak * peak * texels / square_sum);
}

TextureLoss loss_of(std::span<const Squares> layers, double texels) {
  Squares sum;
  for (const Squares& s : layers) {
    sum.albedo += s.albedo;
    sum.roughness += s.roughness;
    sum.brightness += s.brightness;
    sum.height += s.height;
    sum.degrees += s.degrees;
  }
  return {psnr(255, sum.albedo, texels / 4), psnr(255, sum.roughness, texels / 4),
          psnr(1, sum.brightness, texels), psnr(1, sum.height, texels), std::sqrt(sum.degrees / texels)};
}

}  // namespace

std::vector<std::byte> MakeTextures::run(MaterialSet& set, TextureLoss& loss) const {
  std::vector<std::byte> bytes(texture_bytes(set));
  std::vector<Squares> squares(kTextureArrays * images.size());
  parallel_chunks(images.size(), 1, threads, [&](std::size_t n, std::size_t, int) {
    describe(finest(images[n]), near_codes(texture_format(set.format, TextureArray::near)), set.materials[n]);
  });
  // A layer of an array a task.
  parallel_chunks(squares.size(), 1, threads, [&](std::size_t task, std::size_t, int) {
    const std::size_t index = task / kTextureArrays;
    const auto array = static_cast<TextureArray>(task % kTextureArrays);
    const TextureFormat format = texture_format(set.format, array);
    Level level = finest(images[index]);
    while (level.side > static_cast<int>(texture_side(set.side, array))) level = coarser(level);
    for (int k = 0; k < texture_levels(set.side, array); ++k) {
      if (k > 0) level = coarser(level);
      const std::span<std::byte> out =
          std::span(bytes).subspan(texture_offset(set, array, k, static_cast<std::uint32_t>(index)),
                                   texture_image_bytes(set.format, set.side, array, k));
      Squares off;
      if (array == TextureArray::far) {
        store_far(level, format, out, off);
      } else {
        store_near(level, set.materials[index], format, out, off);
      }
      if (k == 0) squares[task] = off;
    }
  });
  loss = loss_of(squares, static_cast<double>(images.size()) * set.side * set.side);
  return bytes;
}

}  // namespace karst::bake
