// SPDX-License-Identifier: MIT
// Decoding of ETC2 and EAC blocks; see etc2.h for the source. Every function follows one section of it.
#include <cstring>

#include "etc2/etc2.h"
#include "etc2/etc2_blocks.h"
#include "etc2/etc2_format.h"

namespace karst::etc2 {
namespace {

using Colour = int[kChannels];

int texel_index(std::uint64_t block, int p) {
  return field(block, 16 + p, 1) << 1 | field(block, p, 1);
}

void put(BlockTexels& out, int p, int r, int g, int b) {
  out.rgba[p][0] = static_cast<std::uint8_t>(clamp_byte(r));
  out.rgba[p][1] = static_cast<std::uint8_t>(clamp_byte(g));
  out.rgba[p][2] = static_cast<std::uint8_t>(clamp_byte(b));
}

// Individual and differential mode: base[half] in bytes.
void decode_halves(std::uint64_t block, const Colour (&base)[2], BlockTexels& out) {
  const int tables[2] = {field(block, 37, 3), field(block, 34, 3)};
  const bool flip = field(block, kFlipBit, 1) != 0;
  for (int p = 0; p < kTexels; ++p) {
    const int x = p >> 2, y = p & 3;
    const int half = (flip ? y : x) >> 1;
    const int m = modifier(tables[half], texel_index(block, p));
    put(out, p, base[half][0] + m, base[half][1] + m, base[half][2] + m);
  }
}

void decode_paints(std::uint64_t block, const Colour (&paint)[4], BlockTexels& out) {
  for (int p = 0; p < kTexels; ++p) {
    const Colour& c = paint[texel_index(block, p)];
    put(out, p, c[0], c[1], c[2]);
  }
}

void decode_t(std::uint64_t block, BlockTexels& out) {
  const Colour first = {field(block, 59, 2) << 2 | field(block, 56, 2), field(block, 52, 4),
                        field(block, 48, 4)};
  const Colour second = {field(block, 44, 4), field(block, 40, 4), field(block, 36, 4)};
  const int d = kDistances[field(block, 34, 2) << 1 | field(block, 32, 1)];
  Colour paint[4];
  for (int c = 0; c < kChannels; ++c) {
    const int b = extend(second[c], 4);
    paint[0][c] = extend(first[c], 4);
    paint[1][c] = b + d;
    paint[2][c] = b;
    paint[3][c] = b - d;
  }
  decode_paints(block, paint, out);
}

void decode_h(std::uint64_t block, BlockTexels& out) {
  const Colour first = {field(block, 59, 4), field(block, 56, 3) << 1 | field(block, 52, 1),
                        field(block, 51, 1) << 3 | field(block, 47, 3)};
  const Colour second = {field(block, 43, 4), field(block, 39, 4), field(block, 35, 4)};
  const int ordered = colour_rank(first) >= colour_rank(second) ? 1 : 0;
  const int d = kDistances[field(block, 34, 1) << 2 | field(block, 32, 1) << 1 | ordered];
  Colour paint[4];
  for (int c = 0; c < kChannels; ++c) {
    const int a = extend(first[c], 4), b = extend(second[c], 4);
    paint[0][c] = a + d;
    paint[1][c] = a - d;
    paint[2][c] = b + d;
    paint[3][c] = b - d;
  }
  decode_paints(block, paint, out);
}

void decode_planar(std::uint64_t block, BlockTexels& out) {
  const Colour o = {extend(field(block, 57, 6), 6), extend(field(block, 56, 1) << 6 | field(block, 49, 6), 7),
                    extend(field(block, 48, 1) << 5 | field(block, 43, 2) << 3 | field(block, 39, 3), 6)};
  const Colour h = {extend(field(block, 34, 5) << 1 | field(block, 32, 1), 6), extend(field(block, 25, 7), 7),
                    extend(field(block, 19, 6), 6)};
  const Colour v = {extend(field(block, 13, 6), 6), extend(field(block, 6, 7), 7),
                    extend(field(block, 0, 6), 6)};
  for (int p = 0; p < kTexels; ++p) {
    const int x = p >> 2, y = p & 3;
    put(out, p, plane_at(o[0], h[0], v[0], x, y), plane_at(o[1], h[1], v[1], x, y),
        plane_at(o[2], h[2], v[2], x, y));
  }
}

bool is_5_bit(int v) {
  return v >= 0 && v < 32;
}

}  // namespace

void decode_colour(std::uint64_t block, BlockTexels& out) {
  Colour base[2];
  if (field(block, kDifferentialBit, 1) == 0) {
    for (int c = 0; c < kChannels; ++c) {
      base[0][c] = extend(field(block, 60 - 8 * c, 4), 4);
      base[1][c] = extend(field(block, 56 - 8 * c, 4), 4);
    }
    return decode_halves(block, base, out);
  }
  int sum[kChannels];
  for (int c = 0; c < kChannels; ++c) {
    const int first = field(block, 59 - 8 * c, 5);
    sum[c] = first + signed_field(block, 56 - 8 * c, 3);
    base[0][c] = extend(first, 5);
    base[1][c] = extend(sum[c] & 31, 5);
  }
  if (!is_5_bit(sum[0])) return decode_t(block, out);
  if (!is_5_bit(sum[1])) return decode_h(block, out);
  if (!is_5_bit(sum[2])) return decode_planar(block, out);
  decode_halves(block, base, out);
}

void decode_alpha(std::uint64_t block, BlockTexels& out) {
  const int base = field(block, 56, 8), multiplier = field(block, 52, 4);
  const int* modifiers = kAlphaModifiers[field(block, 48, 4)];
  for (int p = 0; p < kTexels; ++p) {
    const int v = base + multiplier * modifiers[field(block, 45 - 3 * p, 3)];
    out.rgba[p][3] = static_cast<std::uint8_t>(clamp_byte(v));
  }
}

std::uint64_t load_block(const std::uint8_t* bytes) {
  std::uint64_t block = 0;
  for (int i = 0; i < 8; ++i) block = block << 8 | bytes[i];
  return block;
}

void store_block(std::uint64_t block, std::uint8_t* bytes) {
  for (int i = 0; i < 8; ++i) bytes[i] = static_cast<std::uint8_t>(block >> (56 - 8 * i));
}

Status check_sizes(std::size_t rgba_bytes, std::uint32_t width, std::uint32_t height,
                   std::size_t blocks_bytes) {
  if (width < 1 || width > kEtc2MostSide)
    return {StatusCode::invalid_argument, "out of range", "width", width};
  if (height < 1 || height > kEtc2MostSide)
    return {StatusCode::invalid_argument, "out of range", "height", height};
  if (rgba_bytes != std::size_t{width} * height * 4)
    return {StatusCode::invalid_argument, "not width * height texels", "rgba", rgba_bytes};
  if (blocks_bytes != etc2_bytes(width, height))
    return {StatusCode::invalid_argument, "not etc2_bytes(width, height)", "blocks", blocks_bytes};
  return {};
}

Status decode_etc2(std::span<const std::uint8_t> blocks, std::uint32_t width, std::uint32_t height,
                   std::span<std::uint8_t> rgba) {
  if (const Status status = etc2::check_sizes(rgba.size(), width, height, blocks.size()); !status.ok())
    return status;
  const std::uint8_t* from = blocks.data();
  for (std::uint32_t y0 = 0; y0 < height; y0 += 4) {
    for (std::uint32_t x0 = 0; x0 < width; x0 += 4, from += kEtc2BlockBytes) {
      etc2::BlockTexels texels;
      etc2::decode_alpha(etc2::load_block(from), texels);
      etc2::decode_colour(etc2::load_block(from + 8), texels);
      for (std::uint32_t p = 0; p < etc2::kTexels; ++p) {
        const std::uint32_t x = x0 + (p >> 2), y = y0 + (p & 3);
        if (x < width && y < height) std::memcpy(&rgba[(std::size_t{y} * width + x) * 4], texels.rgba[p], 4);
      }
    }
  }
  return {};
}

}  // namespace karst::etc2
