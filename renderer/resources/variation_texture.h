// SPDX-License-Identifier: MIT
// Noise in space that moves the borders between materials (K 4.2.2, equation 4.6): three octaves of simplex
// noise, n = h(x) + 0.487 h(2x) + 0.231 h(4x), in a texture that tiles. One lookup costs a small GPU less
// than three evaluations.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

namespace karst::core {

inline constexpr int kVariationSide = 48;  // texels
inline constexpr int kVariationCells = 6;  // of the first octave, over the texture's side; a multiple of 3

// Simplex noise in three dimensions, -1..1, that repeats after `period` cells on each axis, a multiple of 3:
// the skew takes a shift by three cells along an axis to whole cells of the lattice. K. Perlin, "Noise
// Hardware", 2001; S. Gustavson, "Simplex noise demystified", 2005.
float simplex_noise(glm::vec3 at, int period);

// Layer z of the texture, kVariationSide^2 bytes, centred on 128. All platforms get the same bytes.
void variation_layer(int z, std::span<std::uint8_t> out);

}  // namespace karst::core
