// SPDX-License-Identifier: MIT
// Texture compression that every OpenGL ES 3.0 device reads: COMPRESSED_RGBA8_ETC2_EAC and
// COMPRESSED_SRGB8_ALPHA8_ETC2_EAC, one byte a texel. The two formats have the same blocks; they differ in
// what the texture unit does with the decoded bytes.
//
// Source of the format: The Khronos Group, OpenGL ES 3.0 specification, appendix C, "Compressed Texture Image
// Formats" (ETC2 and EAC). How the encoder searches is its own.
//
// An image is rows of blocks of 4 x 4 texels, top row first as its texels are; a block is 8 bytes of alpha
// (EAC) and 8 bytes of colour (ETC2). Sides that are no multiple of 4 end in blocks whose texels outside the
// image repeat the nearest inside. Integers only: the same image gives the same bits everywhere.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "karst/status.h"

namespace karst::etc2 {

inline constexpr std::uint32_t kEtc2BlockBytes = 16;
inline constexpr std::uint32_t kEtc2MostSide = 16384;  // texels; beyond what devices take

// Ways to describe a block's colour; combine with |.
enum Etc2Modes : unsigned {
  kEtc2Individual = 1,    // two halves, each a colour of 4 bits a channel and offsets along grey
  kEtc2Differential = 2,  // the same, 5 bits a channel, the halves' colours not far from each other
  kEtc2T = 4,             // two colours, offsets along grey to either side of the second
  kEtc2H = 8,             // two colours, offsets along grey to either side of both
  kEtc2Planar = 16,       // a plane a channel
  kEtc2AllModes = 31,
};

struct Etc2Settings {
  // What an error in red, green and blue weighs, 0..kMostWeight, not all 0. Alpha is encoded apart.
  static constexpr std::uint8_t kMostWeight = 32;
  std::array<std::uint8_t, 3> weights = {1, 1, 1};
  unsigned modes = kEtc2AllModes;  // what the encoder may use; at least one
};

// Of an image with sides of 1..kEtc2MostSide texels.
constexpr std::uint32_t etc2_bytes(std::uint32_t width, std::uint32_t height) {
  return ((width + 3) / 4) * ((height + 3) / 4) * kEtc2BlockBytes;
}

// rgba: width * height * 4 bytes, rows without gaps. blocks: etc2_bytes(width, height).
// invalid_argument, naming the parameter, where a size, a side or a setting is out of range.
// Takes the best of all allowed modes by weighted squared error, so allowing more never makes it worse.
Status encode_etc2(std::span<const std::uint8_t> rgba, std::uint32_t width, std::uint32_t height,
                   std::span<std::uint8_t> blocks, const Etc2Settings& settings = {});

// The same sizes. Any bytes are a legal image.
Status decode_etc2(std::span<const std::uint8_t> blocks, std::uint32_t width, std::uint32_t height,
                   std::span<std::uint8_t> rgba);

}  // namespace karst::etc2
