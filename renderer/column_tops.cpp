// SPDX-License-Identifier: MIT
#include "renderer/column_tops.h"

#include <algorithm>

namespace karst {
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

void column_tops_row(const Octree& octree, glm::ivec3 extent, std::int32_t z, std::span<float> out) {
  const auto value = [&](std::int32_t x) -> float& { return out[static_cast<std::size_t>(x)]; };
  for (std::int32_t x = 0; x < extent.x; ++x) {
    std::int32_t least = extent.y;
    for (std::int32_t near_z = std::max(z - 1, 0); near_z <= std::min(z + 1, extent.z - 1); ++near_z) {
      least = std::min(least, column_top(octree, extent.y, x, near_z));
    }
    value(x) = static_cast<float>(least);
  }
  float left = value(0);
  for (std::int32_t x = 0; x < extent.x; ++x) {
    const float here = value(x);
    const float right = value(std::min(x + 1, extent.x - 1));
    value(x) = std::min({left, here, right});
    left = here;
  }
}

}  // namespace karst
