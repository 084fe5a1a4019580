// SPDX-License-Identifier: MIT
// Noise on a torus: all of it repeats with period 1 in both coordinates, so that an image made of it tiles.
// Integer hashes and plain + - * / sqrt alone (noise.h): the same bits on every compiler.
//   Perlin, "Improving noise" (2002): gradient noise.  Worley, "A cellular texture basis function" (1996).
#pragma once

#include <glm/vec2.hpp>

#include <cstdint>

namespace karst::bake {

// Gradient noise of `period` cells a side, within about +-1, zero at lattice points.
float tile_noise(glm::vec2 p, int period, std::uint32_t seed);
// Cells of different number along s and t, for what is long in one direction.
float tile_noise(glm::vec2 p, glm::ivec2 period, std::uint32_t seed);

// Sum of octaves, each twice as fine and `gain` times as strong as the one before; within about +-1.
float tile_fbm(glm::vec2 p, int period, int octaves, std::uint32_t seed, float gain = 0.5f);
float tile_fbm(glm::vec2 p, glm::ivec2 period, int octaves, std::uint32_t seed, float gain = 0.5f);

// The nearest of points strewn one a cell, `period` cells a side; distances in cells.
struct TileCell {
  float nearest = 0;     // distance to the point
  float border = 0;      // distance to the border with the neighbouring cell
  std::uint32_t id = 0;  // random, of the point
  glm::vec2 to{0};       // from p to the point
};
TileCell tile_cell(glm::vec2 p, glm::ivec2 period, float jitter, std::uint32_t seed);

// Bits of a hash as a number in 0..1.
constexpr float unit_of(std::uint32_t hash) {
  return static_cast<float>(hash >> 8) * 0x1p-24f;
}

}  // namespace karst::bake
