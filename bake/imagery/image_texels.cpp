// SPDX-License-Identifier: MIT
#include "bake/imagery/image_texels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "etc2/etc2.h"
#include "terrain/base/check.h"

namespace karst::bake {
namespace {

// Images are large: all modes take twice the time of these and gain a fourth of a decibel.
constexpr unsigned kModes = etc2::kEtc2Differential | etc2::kEtc2Planar;

// IEC 61966-2-1.
double linear_of(int byte) {
  const double s = byte / 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

struct Tables {
  static constexpr int kSteps = 1 << 14;  // a step is a sixth of a byte's in the dark
  std::array<float, 256> linear;
  std::array<std::uint8_t, kSteps + 1> byte;

  Tables() {
    for (int n = 0; n < 256; ++n) linear[static_cast<std::size_t>(n)] = static_cast<float>(linear_of(n));
    for (int n = 0; n <= kSteps; ++n) {
      const double l = static_cast<double>(n) / kSteps;
      const double s = l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055;
      byte[static_cast<std::size_t>(n)] = static_cast<std::uint8_t>(std::lround(255 * s));
    }
  }
  std::byte encode(float value) const {
    const auto step = static_cast<int>(std::clamp(value, 0.0f, 1.0f) * kSteps + 0.5f);
    return std::byte{byte[static_cast<std::size_t>(step)]};
  }
};
const Tables& tables() {
  static const Tables made;
  return made;
}

int value(std::span<const std::byte> texels, std::size_t at) {
  return std::to_integer<int>(texels[at]);
}

std::size_t texel_at(int side, int x, int y) {
  return 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(side) + static_cast<std::size_t>(x));
}

}  // namespace

void lay_over(std::span<const std::byte> over, std::span<std::byte> texels) {
  KARST_ASSERT(over.size() == texels.size());
  for (std::size_t at = 0; at < texels.size(); at += 4) {
    const int covers = value(over, at + 3);
    if (covers == 0) continue;
    const int below = value(texels, at + 3) * (255 - covers) / 255;
    if (covers == 255 || below == 0) {
      std::copy_n(over.begin() + static_cast<std::ptrdiff_t>(at), 3,
                  texels.begin() + static_cast<std::ptrdiff_t>(at));
    } else {
      for (std::size_t c = 0; c < 3; ++c) {
        const int mixed = value(over, at + c) * covers + value(texels, at + c) * below;
        texels[at + c] = static_cast<std::byte>(mixed / (covers + below));
      }
    }
    texels[at + 3] = static_cast<std::byte>(covers + below);
  }
}

void halve_texels(std::span<const std::byte> texels, int side, std::span<std::byte> out) {
  const Tables& table = tables();
  const int half = side / 2;
  KARST_ASSERT(out.size() == texel_at(half, 0, half));
  for (int y = 0; y < half; ++y) {
    for (int x = 0; x < half; ++x) {
      float sum[3] = {};
      int weight = 0;
      for (int k = 0; k < 4; ++k) {
        const std::size_t at = texel_at(side, 2 * x + (k & 1), 2 * y + (k >> 1));
        const int covers = value(texels, at + 3);
        weight += covers;
        for (std::size_t c = 0; c < 3; ++c) {
          const auto linear = table.linear[static_cast<std::size_t>(value(texels, at + c))];
          sum[c] += static_cast<float>(covers) * linear;
        }
      }
      const std::size_t to = texel_at(half, x, y);
      for (std::size_t c = 0; c < 3; ++c)
        out[to + c] = weight == 0 ? std::byte{0} : table.encode(sum[c] / static_cast<float>(weight));
      out[to + 3] = static_cast<std::byte>((weight + 2) / 4);
    }
  }
}

// Halves what there is until all is covered by something, and goes back from there.
void fill_uncovered(std::span<std::byte> texels, int side) {
  bool whole = true;
  bool empty = true;
  for (std::size_t at = 3; at < texels.size(); at += 4) {
    whole = whole && texels[at] != std::byte{0};
    empty = empty && texels[at] == std::byte{0};
  }
  if (whole || empty || side % 2 != 0) return;
  std::vector<std::byte> smaller(texels.size() / 4);
  halve_texels(texels, side, smaller);
  // What is covered a little counts as colour, not as less of it.
  for (std::size_t at = 3; at < smaller.size(); at += 4) {
    const int x = static_cast<int>(at / 4) % (side / 2);
    const int y = static_cast<int>(at / 4) / (side / 2);
    bool any = false;
    for (int k = 0; k < 4; ++k)
      any = any || texels[texel_at(side, 2 * x + (k & 1), 2 * y + (k >> 1)) + 3] != std::byte{0};
    smaller[at] = any ? std::byte{255} : std::byte{0};
  }
  fill_uncovered(smaller, side / 2);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const std::size_t at = texel_at(side, x, y);
      if (texels[at + 3] != std::byte{0}) continue;
      const std::size_t from = texel_at(side / 2, x / 2, y / 2);
      for (std::size_t c = 0; c < 3; ++c) texels[at + c] = smaller[from + c];
    }
  }
}

double EncodingError::psnr_db() const {
  if (squares == 0) return std::numeric_limits<double>::infinity();
  return 10 * std::log10(255.0 * 255.0 * static_cast<double>(values) / squares);
}

namespace {

void encode_level(std::span<const std::byte> texels, int side, ImageFormat format, std::span<std::byte> out,
                  EncodingError* error) {
  if (format == ImageFormat::rgba8) {
    std::copy(texels.begin(), texels.end(), out.begin());
  } else {
    const auto wide = static_cast<std::uint32_t>(side);
    std::vector<std::uint8_t> bytes(texels.size()), blocks(etc2::etc2_bytes(wide, wide));
    std::memcpy(bytes.data(), texels.data(), texels.size());
    if (format == ImageFormat::etc2_rgb) {
      for (std::size_t at = 3; at < bytes.size(); at += 4) bytes[at] = 255;
    }
    etc2::Etc2Settings settings;
    settings.modes = kModes;
    const Status encoded = etc2::encode_etc2(bytes, wide, wide, blocks, settings);
    KARST_ASSERT(encoded.ok());
    static_cast<void>(encoded);
    if (format == ImageFormat::etc2_rgba) {
      std::memcpy(out.data(), blocks.data(), blocks.size());
    } else {
      // The second half of each block has the colours.
      for (std::size_t n = 0; n < blocks.size() / 16; ++n)
        std::memcpy(out.data() + 8 * n, blocks.data() + 16 * n + 8, 8);
    }
    if (error == nullptr) return;
    const Status decoded = etc2::decode_etc2(blocks, wide, wide, bytes);
    KARST_ASSERT(decoded.ok());
    static_cast<void>(decoded);
    for (int y = kImageBorder; y < side - kImageBorder; ++y) {
      for (int x = kImageBorder; x < side - kImageBorder; ++x) {
        const std::size_t at = texel_at(side, x, y);
        if (texels[at + 3] == std::byte{0}) continue;
        for (std::size_t c = 0; c < 3; ++c) {
          const double off = value(texels, at + c) - bytes[at + c];
          error->squares += off * off;
        }
        error->values += 3;
      }
    }
  }
}

}  // namespace

void encode_image(std::span<const std::byte> texels, ImageFormat format, std::span<std::byte> out,
                  EncodingError& error) {
  KARST_ASSERT(texels.size() == texel_at(kImageSide, 0, kImageSide) &&
               out.size() == image_texel_bytes(format));
  const std::size_t first = image_level_bytes(format, 0);
  encode_level(texels, kImageSide, format, out.first(first), &error);
  std::vector<std::byte> smaller(texels.size() / 4);
  halve_texels(texels, kImageSide, smaller);
  fill_uncovered(smaller, kImageSide / 2);
  encode_level(smaller, kImageSide / 2, format, out.subspan(first), nullptr);
}

}  // namespace karst::bake
