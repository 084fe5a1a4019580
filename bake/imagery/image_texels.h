// SPDX-License-Identifier: MIT
// Texels of image tiles: one over another, halved, filled where no image is, and as a file has them. Four
// bytes a texel: red, green, blue as sRGB has them, and how much images cover.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "terrain/imagery/image_tile.h"

namespace karst::bake {
using namespace core;

// over: as many texels, taken where they cover.
void lay_over(std::span<const std::byte> over, std::span<std::byte> texels);

// Half as many a side: means in linear light, weighted by what is covered. side: of texels, even.
void halve_texels(std::span<const std::byte> texels, int side, std::span<std::byte> out);

// Where nothing covers, the colours of what is around; covers stay. So filters mix no colour of nowhere.
void fill_uncovered(std::span<std::byte> texels, int side);

struct EncodingError {
  double squares = 0;        // of differences, all three channels
  std::uint64_t values = 0;  // that were compared
  double psnr_db() const;    // infinite where there is no difference
};

// A tile's two levels as a file has them, behind its head. texels: of kImageSide a side, filled. error: adds
// what the format takes off of the texels inside the border that are covered.
void encode_image(std::span<const std::byte> texels, ImageFormat format, std::span<std::byte> out,
                  EncodingError& error);

}  // namespace karst::bake
