// SPDX-License-Identifier: MIT
// Noise on a torus: all of it repeats with period 1 in both coordinates, so that an image made of it tiles.
// What is random of a lattice point or a cell is kept in a table, since images ask for each many times.
// Integer hashes and plain + - * / sqrt alone (noise.h): the same bits on every compiler.
//   Perlin, "Improving noise" (2002): gradient noise.  Worley, "A cellular texture basis function" (1996).
#pragma once

#include <glm/vec2.hpp>

#include <cstdint>
#include <vector>

namespace karst::bake {

// Gradient noise, within about +-1, zero at lattice points.
class TileNoise {
 public:
  // period: cells along s and t, at least 1 of each; different ones for what is long in one direction.
  TileNoise(glm::ivec2 period, std::uint32_t seed);

  float at(glm::vec2 p) const;

 private:
  glm::ivec2 period_;
  // Gradients at lattice points, a row for each along t; the first point and row stand once more
  // behind the last.
  std::vector<glm::vec2> gradients_;
};

// Sum of octaves, each twice as fine and `gain` times as strong as the one before; within about +-1.
class TileFbm {
 public:
  TileFbm(glm::ivec2 period, int octaves, std::uint32_t seed, float gain = 0.5f);
  TileFbm(int period, int octaves, std::uint32_t seed, float gain = 0.5f)
      : TileFbm(glm::ivec2(period), octaves, seed, gain) {}

  float at(glm::vec2 p) const;

 private:
  std::vector<TileNoise> octaves_;
  float gain_;
  float all_ = 0;  // of the octaves' strengths
};

// Points strewn one a cell; distances in cells.
class TileCells {
 public:
  // period: cells along s and t, at least 1 of each. jitter: 0 strews none, 1 all over the cell.
  TileCells(glm::ivec2 period, float jitter, std::uint32_t seed);

  struct Nearest {
    float distance = 0;    // from p to the nearest point
    std::uint32_t id = 0;  // random, of the point
    glm::vec2 to{0};       // from p to it
  };
  Nearest nearest(glm::vec2 p) const;
  // From p to the border of its nearest point's cell with a neighbouring one.
  float border(glm::vec2 p, const Nearest& nearest) const;

 private:
  struct Point {
    glm::vec2 place{0};  // in its cell, 0..1
    std::uint32_t id = 0;
  };
  // Of the cell that p is in, of a row of points_; its neighbours lie around it.
  const Point* cell_of(glm::ivec2 cell) const;

  glm::ivec2 period_;
  std::vector<Point> points_;  // of cells, with a rim of kRim of those around
};

// Bits of a hash as a number in 0..1.
constexpr float unit_of(std::uint32_t hash) {
  return static_cast<float>(hash >> 8) * 0x1p-24f;
}

}  // namespace karst::bake
