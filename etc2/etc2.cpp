// SPDX-License-Identifier: MIT
#include "etc2/etc2.h"

#include <cstring>
#include <memory>

#include "etc2/etc2_blocks.h"

namespace karst::etc2 {
namespace {

// Texels outside of the image repeat the nearest inside.
void gather(std::span<const std::uint8_t> rgba, std::uint32_t width, std::uint32_t height, std::uint32_t x0,
            std::uint32_t y0, BlockTexels& out) {
  for (std::uint32_t p = 0; p < kTexels; ++p) {
    const std::uint32_t x = std::min(x0 + (p >> 2), width - 1), y = std::min(y0 + (p & 3), height - 1);
    std::memcpy(out.rgba[p], &rgba[(std::size_t{y} * width + x) * 4], 4);
  }
}

class ColourEncoder {
 public:
  explicit ColourEncoder(const Etc2Settings& settings)
      : weights_{settings.weights[0], settings.weights[1], settings.weights[2]},
        modes_(settings.modes),
        rows_(std::make_unique<ErrorRows>()) {}

  std::uint64_t encode(const BlockTexels& texels) {
    Encoded best;
    const auto consider = [&](unsigned mode, auto encode_mode) {
      if ((modes_ & mode) == 0 || best.error == 0) return;
      const Encoded found = encode_mode();
      if (found.error < best.error) best = found;
    };
    consider(kEtc2Planar, [&] { return encode_planar(texels, weights_); });
    if (best.error == 0) return best.bits;
    rows_->fill(texels, weights_);
    consider(kEtc2T, [&] { return encode_t(texels, *rows_); });
    consider(kEtc2H, [&] { return encode_h(texels, *rows_); });
    consider(kEtc2Individual, [&] { return encode_individual(texels, *rows_); });
    consider(kEtc2Differential, [&] { return encode_differential(texels, *rows_, best.error); });
    return best.bits;
  }

 private:
  std::uint8_t weights_[kChannels];
  unsigned modes_;
  std::unique_ptr<ErrorRows> rows_;  // 48 KiB
};

}  // namespace

void ErrorRows::fill(const BlockTexels& texels, const std::uint8_t (&channel_weights)[kChannels]) {
  for (int c = 0; c < kChannels; ++c) {
    const int w = channel_weights[c];
    weights[c] = w;
    for (int vector = 0; vector < 4; ++vector) {
      simd::Int4 value{};
      for (int lane = 0; lane < simd::kLanes; ++lane) value[lane] = texels.rgba[lane_texel(vector, lane)][c];
      // w (v - t)^2 for v = 0, 1, ...: each differs from the one before by w (2 (v - t) + 1).
      simd::Int4 error{}, step{};
      for (int lane = 0; lane < simd::kLanes; ++lane) {
        error[lane] = w * value[lane] * value[lane];
        step[lane] = w * (1 - 2 * value[lane]);
      }
      for (auto& row : of[c]) {
        row[vector] = error;
        error += step;
        step += simd::splat(2 * w);
      }
    }
  }
}

std::uint64_t paint_indices(const ErrorRows& rows, const Paints& paints, const int* vectors, int count) {
  std::uint64_t bits = 0;
  for (int k = 0; k < count; ++k) {
    const int vector = vectors[k];
    for (int lane = 0; lane < simd::kLanes; ++lane) {
      int best = 0, least_error = std::numeric_limits<int>::max();
      for (int i = 0; i < 4; ++i) {
        int error = 0;
        for (int c = 0; c < kChannels; ++c) error += rows.at(c, paints.colour[i][c], vector, lane);
        if (error >= least_error) continue;
        least_error = error;
        best = i;
      }
      const int p = lane_texel(vector, lane);
      bits |= place(best >> 1, 16 + p) | place(best & 1, p);
    }
  }
  return bits;
}

Status encode_etc2(std::span<const std::uint8_t> rgba, std::uint32_t width, std::uint32_t height,
                   std::span<std::uint8_t> blocks, const Etc2Settings& settings) {
  if (const Status status = etc2::check_sizes(rgba.size(), width, height, blocks.size()); !status.ok())
    return status;
  int sum = 0;
  for (const std::uint8_t w : settings.weights) {
    if (w > Etc2Settings::kMostWeight) return {StatusCode::invalid_argument, "out of range", "weights", w};
    sum += w;
  }
  if (sum == 0) return {StatusCode::invalid_argument, "all 0", "weights"};
  if (settings.modes == 0 || (settings.modes & ~unsigned{kEtc2AllModes}) != 0)
    return {StatusCode::invalid_argument, "no mode or an unknown one", "modes", settings.modes};

  etc2::ColourEncoder colour(settings);
  std::uint8_t* to = blocks.data();
  for (std::uint32_t y = 0; y < height; y += 4) {
    for (std::uint32_t x = 0; x < width; x += 4, to += kEtc2BlockBytes) {
      etc2::BlockTexels texels;
      etc2::gather(rgba, width, height, x, y, texels);
      etc2::store_block(etc2::encode_alpha(texels).bits, to);
      etc2::store_block(colour.encode(texels), to + 8);
    }
  }
  return {};
}

}  // namespace karst::etc2
