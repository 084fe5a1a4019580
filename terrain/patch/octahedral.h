// SPDX-License-Identifier: MIT
// Octahedral normals in two snorm8 (Meyer et al., "On Floating-Point Normal Vectors", 2010): the sphere is projected
// to the octahedron |x|+|y|+|z| = 1 and its lower half (z < 0) unfolded. Rounding to nearest; largest error is
// reported by tests/property/normal_error_test.cpp.
#pragma once

#include <cmath>
#include <cstdint>

#include <glm/vec3.hpp>

namespace karst {

// Low byte x, high byte y. n need not be of unit length; the zero vector gives (0, 0, 1).
inline std::uint16_t encode_octahedral(glm::vec3 n) {
  const float sum = std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z);
  const float scale = 1.0f / (sum > 1e-30f ? sum : 1e-30f);
  float x = n.x * scale;
  float y = n.y * scale;
  if (n.z < 0) {
    const float fold_x = std::copysign(1.0f - std::fabs(y), x);
    y = std::copysign(1.0f - std::fabs(x), y);
    x = fold_x;
  }
  const auto snorm8 = [](float v) { return static_cast<std::int32_t>(v * 127.0f + std::copysign(0.5f, v)); };
  return static_cast<std::uint16_t>((snorm8(x) & 0xff) | (snorm8(y) & 0xff) << 8);
}

// Of unit length up to float rounding.
inline glm::vec3 decode_octahedral(std::uint16_t packed) {
  float x = static_cast<float>(static_cast<std::int8_t>(packed & 0xff)) / 127.0f;
  float y = static_cast<float>(static_cast<std::int8_t>(packed >> 8)) / 127.0f;
  const float z = 1.0f - std::fabs(x) - std::fabs(y);
  if (z < 0) {
    const float unfold_x = std::copysign(1.0f - std::fabs(y), x);
    y = std::copysign(1.0f - std::fabs(x), y);
    x = unfold_x;
  }
  const float length = std::sqrt(x * x + y * y + z * z);
  return {x / length, y / length, z / length};
}

}  // namespace karst
