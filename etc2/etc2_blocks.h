// SPDX-License-Identifier: MIT
// Single blocks: what the parts of the encoder and the decoder hand to each other.
//
// Encoders look up errors instead of computing them: a block's ErrorRows has, for each channel and each byte
// that a texel could decode to, the weighted squared error at all 16 texels. The error of any choice of
// colours is then a sum of three rows and a minimum over the choices.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "etc2/etc2_format.h"
#include "karst/status.h"
#include "terrain/base/simd.h"

namespace karst::etc2 {
using namespace core;

// Texel p = x * 4 + y, as the format counts.
struct BlockTexels {
  std::uint8_t rgba[kTexels][4];
};

struct Encoded {
  std::uint64_t bits = 0;
  int error = std::numeric_limits<int>::max();  // weighted, squared, summed over the block
};

// Lanes are grouped by quarters of the block, so that each half of it, left or right, top or bottom, is two
// of the four vectors: lane l of vector k is the texel at x = 2 (k >> 1) + (l >> 1), y = 2 (k & 1) + (l & 1).
inline constexpr int lane_texel(int vector, int lane) {
  return (2 * (vector >> 1) + (lane >> 1)) * 4 + 2 * (vector & 1) + (lane & 1);
}

struct ErrorRows {
  simd::Int4 of[kChannels][256][4];
  int weights[kChannels];

  // weights: a channel each, 0..32: a texel's error and what is added to it stay below 2^24.
  void fill(const BlockTexels& texels, const std::uint8_t (&channel_weights)[kChannels]);
  int at(int channel, int value, int vector, int lane) const { return of[channel][value][vector][lane]; }
};

inline simd::Int4 least(simd::Int4 a, simd::Int4 b) {
  return simd::select(a < b, a, b);
}
inline int sum_of(simd::Int4 v) {
  return v[0] + v[1] + v[2] + v[3];
}

// Error and texel indices of colours that texels choose from: the first best for each texel.
struct Paints {
  int colour[4][kChannels];  // bytes
};
std::uint64_t paint_indices(const ErrorRows& rows, const Paints& paints, const int* vectors, int count);

// Rank of a colour of 4 bits a channel, by which H mode hides a bit of its distance in the order of colours.
inline constexpr int colour_rank(const int (&c)[kChannels]) {
  return c[0] << 8 | c[1] << 4 | c[2];
}

// Each gives the best that it finds; of differential blocks those below a limit only, which saves time.
Encoded encode_individual(const BlockTexels& texels, const ErrorRows& rows);
Encoded encode_differential(const BlockTexels& texels, const ErrorRows& rows, int limit);
Encoded encode_t(const BlockTexels& texels, const ErrorRows& rows);
Encoded encode_h(const BlockTexels& texels, const ErrorRows& rows);
Encoded encode_planar(const BlockTexels& texels, const std::uint8_t (&weights)[kChannels]);
Encoded encode_alpha(const BlockTexels& texels);

// Decoders write their channels of all texels.
void decode_colour(std::uint64_t block, BlockTexels& out);
void decode_alpha(std::uint64_t block, BlockTexels& out);

std::uint64_t load_block(const std::uint8_t* bytes);
void store_block(std::uint64_t block, std::uint8_t* bytes);
Status check_sizes(std::size_t rgba_bytes, std::uint32_t width, std::uint32_t height,
                   std::size_t blocks_bytes);

}  // namespace karst::etc2
