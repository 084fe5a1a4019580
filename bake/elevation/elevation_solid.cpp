// SPDX-License-Identifier: MIT
#include "bake/elevation/elevation_solid.h"

#include "bake/base/parallel.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace karst::bake {
namespace {

// Points a side of a footprint: two a sample of the elevation, so that none is skipped.
constexpr int kLeastPoints = 2, kMostPoints = 64;

int points_for(double voxel_m, double spacing_m) {
  return static_cast<int>(
      std::clamp(std::ceil(2 * voxel_m / spacing_m), double{kLeastPoints}, double{kMostPoints}));
}

// Sweeps over all columns; each changes fewer, and 20 were enough for every terrain tried.
constexpr int kMostSweeps = 100;

class Settle {
 public:
  Settle(std::vector<float>& tops, int width, int height) : means_(tops), width_(width), height_(height) {
    for (const float t : tops) tops_.push_back(std::isnan(t) ? kHole : static_cast<int>(std::ceil(t - 0.5f)));
  }

  std::vector<float> run() {
    for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
      int changed = 0;
      for (int z = 0; z < height_; ++z) {
        for (int x = 0; x < width_; ++x) changed += part_diagonal(x, z) + level_tip(x, z);
      }
      if (changed == 0) break;
    }
    std::vector<float> result;
    for (const int t : tops_) {
      result.push_back(t == kHole ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(t));
    }
    return result;
  }

 private:
  static constexpr int kHole = std::numeric_limits<int>::min();

  std::size_t at(int x, int z) const {
    return static_cast<std::size_t>(z) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }

  // Into the middle two of its four neighbours' tops. Sides and holes count as level.
  int level_tip(int x, int z) {
    int& top = tops_[at(x, z)];
    if (top == kHole) return 0;
    const auto neighbour = [&](int i, int j) {
      if (i < 0 || j < 0 || i >= width_ || j >= height_ || tops_[at(i, j)] == kHole) return top;
      return tops_[at(i, j)];
    };
    int around[4] = {neighbour(x - 1, z), neighbour(x + 1, z), neighbour(x, z - 1), neighbour(x, z + 1)};
    std::sort(std::begin(around), std::end(around));
    const int levelled = std::clamp(top, around[1], around[2]);
    return std::exchange(top, levelled) != levelled ? 1 : 0;
  }

  // Of the four columns from (x, z) on, moves the one whose mean is nearest to where it would have to be.
  int part_diagonal(int x, int z) {
    if (x + 1 >= width_ || z + 1 >= height_) return 0;
    const std::size_t column[4] = {at(x, z), at(x + 1, z), at(x + 1, z + 1), at(x, z + 1)};
    for (const std::size_t c : column) {
      if (tops_[c] == kHole) return 0;
    }
    for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
      const std::size_t high[2] = {column[k], column[k + 2]}, low[2] = {column[1 - k], column[3 - k]};
      const int least = std::min(tops_[high[0]], tops_[high[1]]),
                most = std::max(tops_[low[0]], tops_[low[1]]);
      if (least <= most) continue;
      const std::pair<std::size_t, int> moves[4] = {
          {low[0], least}, {low[1], least}, {high[0], most}, {high[1], most}};
      const auto cost = [&](const auto& move) {
        return std::abs(means_[move.first] - static_cast<float>(move.second));
      };
      const auto best = std::min_element(std::begin(moves), std::end(moves),
                                         [&](const auto& a, const auto& b) { return cost(a) < cost(b); });
      tops_[best->first] = best->second;
      return 1;
    }
    return 0;
  }

  const std::vector<float>& means_;
  std::vector<int> tops_;
  int width_, height_;
};

}  // namespace

ElevationSolid::ElevationSolid(const Elevation& elevation, bool holes)
    : surface_(elevation), cell_m_(std::min(elevation.spacing_x_m, elevation.spacing_z_m)), holes_(holes) {}

double ElevationSolid::value_m(glm::dvec3 position_m) const {
  const double below = surface_.at(position_m.x, position_m.z) - position_m.y;
  if (!holes_) return below;
  return std::min(below, (surface_.validity(position_m.x, position_m.z) - 0.5) * 2 * cell_m_);
}

std::vector<float> column_tops(const ElevationSolid& solid, const Elevation& elevation, const WorldGrid& grid,
                               int threads) {
  const auto width = static_cast<std::size_t>(grid.extent.x);
  std::vector<float> tops(width * static_cast<std::size_t>(grid.extent.z));
  const int nx = points_for(grid.voxel_m, elevation.spacing_x_m);
  const int nz = points_for(grid.voxel_m, elevation.spacing_z_m);
  const auto mean_top = [&](std::size_t x, std::size_t z) {
    double sum = 0;
    int known = 0;
    for (int k = 0; k < nx * nz; ++k) {
      const int column = k % nx;
      const int row = k / nx;
      const glm::dvec3 p = grid.to_m(
          {static_cast<double>(x) + (column + 0.5) / nx, 0, static_cast<double>(z) + (row + 0.5) / nz});
      if (solid.in_hole(p.x, p.z)) continue;
      sum += solid.elevation_m(p.x, p.z);
      ++known;
    }
    if (2 * known < nx * nz) return std::numeric_limits<float>::quiet_NaN();
    return static_cast<float>((sum / known - grid.origin_m.y) / grid.voxel_m);
  };
  parallel_chunks(static_cast<std::size_t>(grid.extent.z), 1, threads,
                  [&](std::size_t first, std::size_t last, int) {
                    for (std::size_t z = first; z < last; ++z) {
                      for (std::size_t x = 0; x < width; ++x) tops[z * width + x] = mean_top(x, z);
                    }
                  });
  settle_tops(tops, grid.extent.x, grid.extent.z);
  return tops;
}

void settle_tops(std::vector<float>& tops, int width, int height) {
  tops = Settle(tops, width, height).run();
}

double ColumnSolid::value_m(glm::dvec3 position_m) const {
  const glm::dvec3 v = (position_m - grid_.origin_m) / grid_.voxel_m;
  const int x = std::clamp(static_cast<int>(std::floor(v.x)), 0, grid_.extent.x - 1);
  const int z = std::clamp(static_cast<int>(std::floor(v.z)), 0, grid_.extent.z - 1);
  const float top = tops_[static_cast<std::size_t>(z) * static_cast<std::size_t>(grid_.extent.x) +
                          static_cast<std::size_t>(x)];
  // A hole is empty to the bottom and below.
  if (std::isnan(top)) return -grid_.voxel_m;
  return (double{top} - v.y) * grid_.voxel_m;
}

}  // namespace karst::bake
