// SPDX-License-Identifier: MIT
// Which texels of a blend map a place of the world may mix, at any level of the map: what is painted, and
// what is not.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>

#include <glm/vec2.hpp>

#include "terrain/shading/materials.h"

namespace karst::core {

// Columns and rows low .. high - 1.
struct TexelRect {
  glm::uvec2 low{0};
  glm::uvec2 high{0};

  bool exists() const { return high.x > low.x && high.y > low.y; }
  void join(const TexelRect& other) {
    if (!other.exists()) return;
    if (!exists()) {
      *this = other;
      return;
    }
    low = {std::min(low.x, other.low.x), std::min(low.y, other.low.y)};
    high = {std::max(high.x, other.high.x), std::max(high.y, other.high.y)};
  }
};

// A place mixes the texels beside it, each of which is made of 2^level finer ones, at kMostBlendLevels - 1 at
// most.
inline constexpr double kBlendReach = 1.5 * (1 << (kMostBlendLevels - 1)) + 1;

// Texels that places from low to high mix, voxels along x and z.
inline TexelRect texels_reaching(const BlendMap& map, const BlendSpan& span, const glm::dvec2& low,
                                 const glm::dvec2& high) {
  TexelRect rect;
  const std::uint32_t texels[2] = {map.width, map.depth};
  for (int axis = 0; axis < 2; ++axis) {
    const double scale = texels[axis] / span.size[axis], most = texels[axis];
    const auto at = [&](double voxels) { return (voxels - span.low[axis]) * scale; };
    rect.low[axis] =
        static_cast<std::uint32_t>(std::clamp(std::floor(at(low[axis]) - kBlendReach), 0.0, most));
    rect.high[axis] =
        static_cast<std::uint32_t>(std::clamp(std::ceil(at(high[axis]) + kBlendReach), 0.0, most));
  }
  return rect;
}

// Whether a texel of the rectangle has a weight.
inline bool is_painted(const BlendMap& map, std::span<const std::byte> texels, const TexelRect& rect) {
  for (std::uint32_t z = rect.low.y; z < rect.high.y; ++z) {
    const std::byte* const row = texels.data() + std::size_t{z} * map.width * kBlendTexelBytes;
    for (std::uint32_t x = rect.low.x; x < rect.high.x; ++x) {
      std::uint32_t weights = 0;
      std::memcpy(&weights, row + x * kBlendTexelBytes, sizeof weights);
      if (weights != 0) return true;
    }
  }
  return false;
}

}  // namespace karst::core
