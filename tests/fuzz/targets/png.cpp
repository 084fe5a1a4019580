// SPDX-License-Identifier: MIT
// PNG as it is, and with checksums that fit; what is accepted is written and read again.
#include "app/files/png_file.h"
#include "tests/fuzz/run/fuzz_target.h"

#include <zlib.h>

#include <algorithm>
#include <vector>

namespace karst {
namespace {

constexpr int kMostSide = 64;
constexpr std::uint64_t kMostBytes = 4 * kMostSide * kMostSide;

std::uint32_t load_big(const std::byte* at) {
  std::uint32_t value = 0;
  for (int k = 0; k < 4; ++k) value = value << 8 | std::to_integer<std::uint32_t>(at[k]);
  return value;
}

void fix_chunk_checksums(std::vector<std::byte>& png) {
  for (std::size_t at = 8; at + 12 <= png.size();) {
    const std::uint32_t bytes = load_big(png.data() + at);
    if (bytes > png.size() - at - 12) return;
    const auto crc = static_cast<std::uint32_t>(
        crc32(0, reinterpret_cast<const Bytef*>(png.data() + at + 4), static_cast<uInt>(bytes + 4)));
    for (std::size_t k = 0; k < 4; ++k) png[at + 8 + bytes + k] = static_cast<std::byte>(crc >> (24 - 8 * k));
    at += 12 + std::size_t{bytes};
  }
}

void decode(std::span<const std::byte> png) {
  app::PngPicture picture;
  const Error error = app::decode_png(png, kMostSide, kMostBytes, picture);
  must_be_short(error);
  if (!error.ok()) return must(picture.rgba.empty());
  must(picture.width >= 1 && picture.width <= kMostSide && picture.height >= 1 &&
       picture.height <= kMostSide);
  must(picture.rgba.size() == std::size_t{4} * static_cast<unsigned>(picture.width * picture.height));
  std::vector<std::byte> again;
  must(app::encode_png(picture.rgba, picture.width, picture.height, again).ok());
  app::PngPicture same;
  must(app::decode_png(again, kMostSide, kMostBytes, same).ok());
  for (std::size_t k = 0; k < same.rgba.size(); ++k) must(k % 4 == 3 || same.rgba[k] == picture.rgba[k]);
}

}  // namespace

void fuzz_one(std::span<const std::byte> input) {
  std::vector<std::byte> png(input.begin(), input.end());
  fix_chunk_checksums(png);
  decode(png);
  if (!std::equal(png.begin(), png.end(), input.begin())) decode(input);
}

}  // namespace karst
