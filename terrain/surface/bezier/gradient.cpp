// SPDX-License-Identifier: MIT
#include "terrain/surface/bezier/gradient.h"

#include <array>

namespace karst::core {
namespace {

// One row of six voxels gives, at its two middle voxels, the smoothed value (1-2-1) and the falling
// difference of the smoothed value. Four 16-bit lanes: smooth at 2, smooth at 3, slope at 2, slope at 3.
struct Lanes {
  std::int16_t v[4];
};

constexpr Lanes operator+(Lanes a, Lanes b) {
  Lanes r{};
  for (int i = 0; i < 4; ++i) r.v[i] = static_cast<std::int16_t>(a.v[i] + b.v[i]);
  return r;
}
constexpr Lanes operator-(Lanes a, Lanes b) {
  Lanes r{};
  for (int i = 0; i < 4; ++i) r.v[i] = static_cast<std::int16_t>(a.v[i] - b.v[i]);
  return r;
}
constexpr Lanes twice(Lanes a) {
  return a + a;
}

// Values at -2..2 around the middle one.
constexpr Lanes smooth(Lanes below, Lanes middle, Lanes above) {
  return below + twice(middle) + above;
}
constexpr Lanes slope(Lanes far_below, Lanes below, Lanes above, Lanes far_above) {
  return far_below + twice(below) - twice(above) - far_above;
}

constexpr std::array<Lanes, 64> make_row_table() {
  std::array<Lanes, 64> table{};
  for (int bits = 0; bits < 64; ++bits) {
    int o[6]{};
    for (int x = 0; x < 6; ++x) o[x] = bits >> x & 1;
    for (int c = 0; c < 2; ++c) {
      const int x = 2 + c;
      table[static_cast<std::size_t>(bits)].v[c] = static_cast<std::int16_t>(o[x - 1] + 2 * o[x] + o[x + 1]);
      table[static_cast<std::size_t>(bits)].v[2 + c] =
          static_cast<std::int16_t>(o[x - 2] + 2 * o[x - 1] - 2 * o[x + 1] - o[x + 2]);
    }
  }
  return table;
}

constexpr std::array<Lanes, 64> kRowTable = make_row_table();

}  // namespace

void NeighbourhoodReader::read_block(glm::ivec3 block) {
  block_ = block;
  for (int z = 0; z < kRows; ++z) {
    for (int y = 0; y < kRows; ++y)
      rows_[z][y] = reader_.read_row(block.x - 3, block.y - 3 + y, block.z - 3 + z, kRows);
  }
}

Neighbourhood NeighbourhoodReader::read(glm::ivec3 corner) {
  const glm::ivec3 block(corner.x & -kBlock, corner.y & -kBlock, corner.z & -kBlock);
  if (block != block_) read_block(block);
  const glm::ivec3 inside = corner - block;
  Neighbourhood n;
  for (int z = 0; z < 6; ++z) {
    for (int y = 0; y < 6; ++y) n.row[z][y] = rows_[inside.z + z][inside.y + y] >> inside.x & 63u;
  }
  return n;
}

void corner_gradients(const Neighbourhood& n, std::int8_t (&gradient)[8][3]) {
  Lanes smooth_y[6][2];
  Lanes slope_y[6][2];
  for (int z = 0; z < 6; ++z) {
    Lanes row[6];
    for (int y = 0; y < 6; ++y) row[y] = kRowTable[n.row[z][y]];
    for (int c = 0; c < 2; ++c) {
      smooth_y[z][c] = smooth(row[c + 1], row[c + 2], row[c + 3]);
      slope_y[z][c] = slope(row[c], row[c + 1], row[c + 3], row[c + 4]);
    }
  }
  for (int cz = 0; cz < 2; ++cz) {
    for (int cy = 0; cy < 2; ++cy) {
      const Lanes x_and_value = smooth(smooth_y[cz + 1][cy], smooth_y[cz + 2][cy], smooth_y[cz + 3][cy]);
      const Lanes y = smooth(slope_y[cz + 1][cy], slope_y[cz + 2][cy], slope_y[cz + 3][cy]);
      const Lanes z =
          slope(smooth_y[cz][cy], smooth_y[cz + 1][cy], smooth_y[cz + 3][cy], smooth_y[cz + 4][cy]);
      for (int cx = 0; cx < 2; ++cx) {
        std::int8_t* g = gradient[cx + 2 * cy + 4 * cz];
        g[0] = static_cast<std::int8_t>(x_and_value.v[2 + cx]);
        g[1] = static_cast<std::int8_t>(y.v[cx]);
        g[2] = static_cast<std::int8_t>(z.v[cx]);
      }
    }
  }
}

}  // namespace karst::core
