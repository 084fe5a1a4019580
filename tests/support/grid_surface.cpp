// SPDX-License-Identifier: MIT
#include "tests/support/grid_surface.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>

#include "terrain/base/lattice.h"

namespace karst::core {
namespace {

constexpr std::uint32_t kNobody = 0xffffffffu;

// Every second bit of a Morton code, packed.
std::uint32_t packed(std::uint32_t code) {
  std::uint32_t result = 0;
  for (std::uint32_t bit = 0; bit < 16; ++bit) result |= (code >> (2 * bit) & 1u) << bit;
  return result;
}

// In [0, 1), the same on every standard library.
double fraction(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

}  // namespace

GridSurface make_grid_surface(int width, int depth, double reach_voxels, std::uint64_t seed, int sheets) {
  std::mt19937_64 random(seed);
  const double phase = 6.28 * fraction(random);
  GridSurface result;
  const auto columns = static_cast<std::size_t>(width * depth);
  std::vector<std::uint32_t> at(columns * static_cast<std::size_t>(sheets), kNobody);
  const auto id_at = [&](int sheet, int x, int z) -> std::uint32_t& {
    return at[static_cast<std::size_t>(sheet) * columns + static_cast<std::size_t>(z * width + x)];
  };
  const auto beside_at = [&](int sheet, int x, int z) {
    return x < 0 || z < 0 || x >= width || z >= depth ? kNobody : id_at(sheet, x, z);
  };
  for (std::uint32_t code = 0; code < static_cast<std::uint32_t>(sheets) << 18; ++code) {
    const int sheet = static_cast<int>(code >> 18);
    const int x = static_cast<int>(packed(code & 0x3ffffu));
    const int z = static_cast<int>(packed((code & 0x3ffffu) >> 1));
    if (x >= width || z >= depth) continue;
    id_at(sheet, x, z) = static_cast<std::uint32_t>(result.patches.size());
    const double height =
        40.0 * sheet + 12.0 + 6.0 * std::sin(0.11 * x + phase) + 5.0 * std::cos(0.07 * z - phase);
    Volume volume{};
    volume.corner[0] = static_cast<std::uint16_t>(x + 1);
    volume.corner[1] = static_cast<std::uint16_t>(height);
    volume.corner[2] = static_cast<std::uint16_t>(z + 1);
    volume.patch_count = 1;
    Patch patch{};
    patch.volume = static_cast<std::uint32_t>(result.volumes.size());
    patch.height_block = kNoHeights;
    PatchBounds box;
    for (int axis = 0; axis < 3; ++axis) {
      const double steps = reach_voxels * kStepsPerVoxel;
      const double a = steps * (2.0 * fraction(random) - 1.0);
      const double b = steps * (2.0 * fraction(random) - 1.0);
      box.min[axis] = static_cast<std::int16_t>(std::min(a, b));
      box.max[axis] = static_cast<std::int16_t>(std::max(a, b));
    }
    result.volumes.push_back(volume);
    result.patches.push_back(patch);
    result.bounds.push_back(box);
  }
  for (int n = 0; n < sheets * width * depth; ++n) {
    const int sheet = n / (width * depth);
    const int x = n % width;
    const int z = n / width % depth;
    Patch& patch = result.patches[id_at(sheet, x, z)];
    const std::uint32_t beside[4] = {beside_at(sheet, x, z + 1), beside_at(sheet, x + 1, z),
                                     beside_at(sheet, x, z - 1), beside_at(sheet, x - 1, z)};
    for (int edge = 0; edge < 4; ++edge) {
      if (beside[edge] != kNobody) patch.neighbour[edge] = PatchEdge::make(beside[edge], (edge + 2) % 4);
    }
  }
  result.nodes.resize(BoundsTree::node_count(static_cast<std::uint32_t>(result.patches.size())));
  result.tree.create(result.nodes);
  if (!result.tree.build(result.surface(), result.bounds).ok()) result.patches.clear();
  return result;
}

}  // namespace karst::core
