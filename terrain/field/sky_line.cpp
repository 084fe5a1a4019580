// SPDX-License-Identifier: MIT
#include "terrain/field/sky_line.h"

#include <algorithm>
#include <cmath>

namespace karst::core {
namespace {

// Steps from leaf to leaf, so that air and solid cost one step each where they are large.
std::int32_t column_top(const Octree& octree, std::int32_t extent_y, std::int32_t x, std::int32_t z) {
  std::int32_t y = extent_y - 1;
  while (y >= 0) {
    const Octree::Leaf leaf = octree.find_leaf({x, y, z});
    if (leaf.filled) return std::min(leaf.origin.y + leaf.size, y + 1);
    y = leaf.origin.y - 1;
  }
  return 0;
}

}  // namespace

SkyLine::SkyLine(const Octree& octree, glm::ivec3 extent) : octree_(&octree), extent_(extent) {
  for (int dz = 0; dz <= kSkyReach; ++dz) {
    for (int dx = 0; dx <= kSkyReach; ++dx) {
      rise_[dz][dx] = kSkySlope * std::sqrt(static_cast<float>(dx * dx + dz * dz));
    }
  }
  for (std::int32_t z = 0; z < std::min(kSkyReach, extent_.z); ++z) read_row(z);
}

void SkyLine::read_row(std::int32_t z) {
  auto& row = tops_[z % kRows];
  for (std::int32_t x = 0; x < extent_.x; ++x) {
    row[static_cast<std::size_t>(x)] = static_cast<std::int16_t>(column_top(*octree_, extent_.y, x, z));
  }
}

void SkyLine::next(std::span<float> out) {
  if (z_ + kSkyReach < extent_.z) read_row(z_ + kSkyReach);
  const std::int32_t first_z = std::max(z_ - kSkyReach, 0);
  const std::int32_t last_z = std::min(z_ + kSkyReach, extent_.z - 1);
  for (std::int32_t x = 0; x < extent_.x; ++x) {
    const std::int32_t first_x = std::max(x - kSkyReach, 0);
    const std::int32_t last_x = std::min(x + kSkyReach, extent_.x - 1);
    float least = static_cast<float>(extent_.y);
    for (std::int32_t near_z = first_z; near_z <= last_z; ++near_z) {
      const float* rise = rise_[std::abs(near_z - z_)];
      const auto& tops = tops_[near_z % kRows];
      for (std::int32_t near_x = first_x; near_x <= last_x; ++near_x) {
        least = std::min(
            least, static_cast<float>(tops[static_cast<std::size_t>(near_x)]) + rise[std::abs(near_x - x)]);
      }
    }
    out[static_cast<std::size_t>(x)] = least;
  }
  ++z_;
}

}  // namespace karst::core
