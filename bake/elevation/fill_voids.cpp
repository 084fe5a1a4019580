// SPDX-License-Identifier: MIT
// Filling voids with the smooth membrane through the samples around them (Laplace's equation with the valid
// samples held), by a cascade of grids: known samples are averaged down a pyramid ("pull"), and each level's
// voids start from the level below ("push"; Gortler, Grzeszczuk, Szeliski, Cohen, "The Lumigraph", 1996,
// section 3.4.2) and are smoothed by a few sweeps. What a level smooths is as wide as its cells, so that the
// work is that of the finest level times 4/3, and the result has no creases where the pyramid's cells meet.
#include "bake/elevation/elevation.h"

#include <algorithm>
#include <vector>

#include "terrain/base/check.h"

namespace karst::bake {
namespace {

constexpr int kSweeps =
    12;  // Gauss-Seidel sweeps a level; the start is off only at the scale of a level's own cells

struct Grid {
  int width = 0, height = 0;
  std::vector<float> value;
  std::vector<std::uint8_t> known;

  std::size_t at(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(width) + static_cast<std::size_t>(i);
  }
};

bool complete(const Grid& grid) {
  return std::find(grid.known.begin(), grid.known.end(), std::uint8_t{0}) == grid.known.end();
}

Grid pull(const Grid& fine) {
  Grid coarse;
  coarse.width = (fine.width + 1) / 2;
  coarse.height = (fine.height + 1) / 2;
  const std::size_t size = static_cast<std::size_t>(coarse.width) * static_cast<std::size_t>(coarse.height);
  coarse.value.assign(size, 0);
  coarse.known.assign(size, 0);
  for (int j = 0; j < coarse.height; ++j) {
    for (int i = 0; i < coarse.width; ++i) {
      double sum = 0;
      int count = 0;
      for (int k = 0; k < 4; ++k) {
        const int x = 2 * i + (k & 1), y = 2 * j + (k >> 1);
        if (x >= fine.width || y >= fine.height || fine.known[fine.at(x, y)] == 0) continue;
        sum += double{fine.value[fine.at(x, y)]};
        ++count;
      }
      if (count == 0) continue;
      coarse.value[coarse.at(i, j)] = static_cast<float>(sum / count);
      coarse.known[coarse.at(i, j)] = 1;
    }
  }
  return coarse;
}

// Bilinear value of the coarse grid, all of it set, at the centre of fine cell (x, y).
float sample(const Grid& coarse, int x, int y) {
  const auto near_far = [](int fine, int count, int& near, int& far) {
    near = fine / 2;
    far = std::clamp((fine & 1) == 0 ? near - 1 : near + 1, 0, count - 1);
  };
  int i0 = 0, i1 = 0, j0 = 0, j1 = 0;
  near_far(x, coarse.width, i0, i1);
  near_far(y, coarse.height, j0, j1);
  const auto row = [&](int j) {
    return 0.75f * coarse.value[coarse.at(i0, j)] + 0.25f * coarse.value[coarse.at(i1, j)];
  };
  return 0.75f * row(j0) + 0.25f * row(j1);
}

// Each void becomes the mean of its neighbours; the border mirrors. Two colours, so that order does not
// matter.
void smooth(Grid& grid, const std::vector<std::size_t>& voids) {
  const int w = grid.width, h = grid.height;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (int colour = 0; colour < 2; ++colour) {
      for (const std::size_t k : voids) {
        const int i = static_cast<int>(k % static_cast<std::size_t>(w));
        const int j = static_cast<int>(k / static_cast<std::size_t>(w));
        if (((i + j) & 1) != colour) continue;
        const float west = grid.value[grid.at(i > 0 ? i - 1 : std::min(i + 1, w - 1), j)];
        const float east = grid.value[grid.at(i < w - 1 ? i + 1 : std::max(i - 1, 0), j)];
        const float north = grid.value[grid.at(i, j > 0 ? j - 1 : std::min(j + 1, h - 1))];
        const float south = grid.value[grid.at(i, j < h - 1 ? j + 1 : std::max(j - 1, 0))];
        grid.value[k] = 0.25f * ((west + east) + (north + south));
      }
    }
  }
}

// Precondition: some cell of grid is known.
void fill(Grid& grid) {
  if (complete(grid)) return;
  Grid coarse = pull(grid);
  fill(coarse);
  std::vector<std::size_t> voids;
  for (int j = 0; j < grid.height; ++j) {
    for (int i = 0; i < grid.width; ++i) {
      const std::size_t k = grid.at(i, j);
      if (grid.known[k] != 0) continue;
      grid.value[k] = sample(coarse, i, j);
      voids.push_back(k);
    }
  }
  smooth(grid, voids);
}

}  // namespace

void fill_voids(Elevation& elevation) {
  KARST_ASSERT(std::find(elevation.valid.begin(), elevation.valid.end(), 1) != elevation.valid.end());
  Grid grid{elevation.width, elevation.height, std::move(elevation.heights_m), std::move(elevation.valid)};
  fill(grid);
  elevation.heights_m = std::move(grid.value);
  elevation.valid = std::move(grid.known);
  std::fill(elevation.valid.begin(), elevation.valid.end(), std::uint8_t{1});
}

}  // namespace karst::bake
