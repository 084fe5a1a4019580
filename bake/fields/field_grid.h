// SPDX-License-Identifier: MIT
// Values on a grid in space, of which a field is baked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

namespace karst::bake {

struct FieldGrid {
  static constexpr std::uint64_t kMostSamples = std::uint64_t{1} << 26;
  static constexpr int kMostSide = 4'080;  // 510 voxels of 8 cells

  glm::ivec3 size{0};         // samples each way: x to the east, y up, z to the south
  double spacing_m = 0;       // of samples; 0: not known
  bool is_placed = false;     // else the middle of its bottom lies at 0, 0, 0
  glm::dvec3 low_m{0.0};      // of sample (0, 0, 0), where it is
  std::vector<float> values;  // x fastest, then y, then z; finite

  float at(int x, int y, int z) const {
    const auto row =
        static_cast<std::size_t>(z) * static_cast<std::size_t>(size.y) + static_cast<std::size_t>(y);
    return values[row * static_cast<std::size_t>(size.x) + static_cast<std::size_t>(x)];
  }
};

}  // namespace karst::bake
