// SPDX-License-Identifier: MIT
// The one texture of all materials: tiling noise, computed, not loaded. Four channels of 8 bits, all centred
// on 128:
//   r  soft mottle: five octaves of gradient noise
//   g  a rough height field: ridged octaves, as weathered rock and clods have
//   b  slope of g along s
//   a  slope of g along t
// Gradient noise after K. Perlin, "Improving Noise", 2002, with lattice coordinates taken modulo the octave's
// period.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace karst {

inline constexpr int kNoiseSideLog2 = 8;
inline constexpr int kNoiseSide = 1 << kNoiseSideLog2;  // texels

// The rows of the texture, from the first on. All platforms get the same bytes.
class NoiseRows {
 public:
  NoiseRows();
  // Writes the next row, kNoiseSide x 4 bytes; to be called kNoiseSide times.
  void next(std::span<std::uint8_t> rgba);

 private:
  using Row = std::array<float, kNoiseSide>;

  Row heights_[3];  // of the rows before, at and after row_, by row modulo 3: a slope needs both neighbours
  int row_ = 0;
};

}  // namespace karst
