// SPDX-License-Identifier: MIT
#include "renderer/resources/variation_texture.h"

#include <algorithm>
#include <cmath>

namespace karst::core {
namespace {

// Scales the sum of a simplex's corners to -1..1. Found by measuring.
constexpr float kSimplexScale = 76.0f;
// Times the sum of the octaves: one texel in 200 is cut off.
constexpr float kSumScale = 0.85f;

// Towards the middles of a cube's edges.
constexpr float kDirections[12][3] = {{1, 1, 0}, {-1, 1, 0}, {1, -1, 0}, {-1, -1, 0},
                                      {1, 0, 1}, {-1, 0, 1}, {1, 0, -1}, {-1, 0, -1},
                                      {0, 1, 1}, {0, -1, 1}, {0, 1, -1}, {0, -1, -1}};

std::uint32_t hash(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  // Integer finaliser of MurmurHash3 (A. Appleby) over a combination with large odd constants.
  std::uint32_t h = x * 0x9e3779b1u + y * 0x85ebca77u + z * 0xc2b2ae3du;
  h ^= h >> 16;
  h *= 0x85ebca6bu;
  h ^= h >> 13;
  h *= 0xc2b2ae35u;
  return h ^ h >> 16;
}

struct Cell {
  int i, j, k;
};

// What the corner at c adds; d: from it. Its place in space, times 6, is a whole number, which modulo the
// period names the corner.
float corner(Cell c, float dx, float dy, float dz, int period) {
  const float near = 0.5f - dx * dx - dy * dy - dz * dz;
  if (near <= 0.0f) return 0.0f;
  const int sum = c.i + c.j + c.k;
  const auto wrap = [&](int cell) {
    const int around = 6 * period;
    const int place = (6 * cell - sum) % around;
    return static_cast<std::uint32_t>(place < 0 ? place + around : place);
  };
  const float* d = kDirections[hash(wrap(c.i), wrap(c.j), wrap(c.k)) % 12];
  return near * near * near * near * (d[0] * dx + d[1] * dy + d[2] * dz);
}

}  // namespace

float simplex_noise(glm::vec3 at, int period) {
  const float skewed = (at.x + at.y + at.z) / 3.0f;
  const Cell base = {static_cast<int>(std::floor(at.x + skewed)), static_cast<int>(std::floor(at.y + skewed)),
                     static_cast<int>(std::floor(at.z + skewed))};
  const float back = static_cast<float>(base.i + base.j + base.k) / 6.0f;
  const float x = at.x - (static_cast<float>(base.i) - back);
  const float y = at.y - (static_cast<float>(base.j) - back);
  const float z = at.z - (static_cast<float>(base.k) - back);
  // The axes in falling order of the offset say which simplex of the cell it is.
  const int rank_x = (x >= y) + (x >= z);
  const int rank_y = (y > x) + (y >= z);
  const int rank_z = (z > x) + (z > y);
  float sum = 0.0f;
  for (int step = 0; step < 4; ++step) {
    const int di = rank_x >= 3 - step;
    const int dj = rank_y >= 3 - step;
    const int dk = rank_z >= 3 - step;
    const float moved = static_cast<float>(step) / 6.0f;
    sum += corner({base.i + di, base.j + dj, base.k + dk}, x - static_cast<float>(di) + moved,
                  y - static_cast<float>(dj) + moved, z - static_cast<float>(dk) + moved, period);
  }
  return sum * kSimplexScale;
}

void variation_layer(int z, std::span<std::uint8_t> out) {
  constexpr float kCellsPerTexel = static_cast<float>(kVariationCells) / kVariationSide;
  constexpr float kShares[3] = {1.0f, 0.487f, 0.231f};
  std::size_t n = 0;
  for (int y = 0; y < kVariationSide; ++y) {
    for (int x = 0; x < kVariationSide; ++x) {
      const glm::vec3 at =
          glm::vec3(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)) * kCellsPerTexel;
      float sum = 0.0f;
      for (int octave = 0; octave < 3; ++octave) {
        sum +=
            kShares[octave] * simplex_noise(at * static_cast<float>(1 << octave), kVariationCells << octave);
      }
      out[n++] = static_cast<std::uint8_t>(std::clamp(128.5f + 127.0f * kSumScale * sum, 1.0f, 255.0f));
    }
  }
}

}  // namespace karst::core
