// SPDX-License-Identifier: MIT
// Octahedral normals in two snorm8 (Meyer et al., "On Floating-Point Normal Vectors", 2010): the sphere is
// projected to the octahedron |x|+|y|+|z| = 1 and its lower half (y < 0) unfolded. The pole is y, so that
// only overhangs use the unfolded part. tests/property/normal_error_test.cpp prints the largest error.
#pragma once

#include <cmath>
#include <cstdint>

#include <glm/vec3.hpp>

namespace karst::core {

// Low byte x, high byte z. n need not be of unit length; the zero vector gives (0, 1, 0).
inline std::uint16_t encode_octahedral(glm::vec3 n) {
  const float sum = std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z);
  const float scale = 1.0f / (sum > 1e-30f ? sum : 1e-30f);
  float x = n.x * scale;
  float z = n.z * scale;
  if (n.y < 0) {
    const float fold_x = std::copysign(1.0f - std::fabs(z), x);
    z = std::copysign(1.0f - std::fabs(x), z);
    x = fold_x;
  }
  // Rounds halves up: adding 128 makes the value positive, so that cutting off is rounding down.
  const auto biased = [](float v) { return static_cast<std::uint32_t>(v * 127.0f + 128.5f); };
  return static_cast<std::uint16_t>((biased(x) | biased(z) << 8) ^ 0x8080u);
}

// Of unit length up to float rounding.
inline glm::vec3 decode_octahedral(std::uint16_t packed) {
  float x = static_cast<float>(static_cast<std::int8_t>(packed & 0xff)) / 127.0f;
  float z = static_cast<float>(static_cast<std::int8_t>(packed >> 8)) / 127.0f;
  const float y = 1.0f - std::fabs(x) - std::fabs(z);
  if (y < 0) {
    const float unfold_x = std::copysign(1.0f - std::fabs(z), x);
    z = std::copysign(1.0f - std::fabs(x), z);
    x = unfold_x;
  }
  const float length = std::sqrt(x * x + y * y + z * z);
  return {x / length, y / length, z / length};
}

}  // namespace karst::core
