// SPDX-License-Identifier: MIT
#include "bake/textures/material_image.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace karst::bake {
namespace {

// x^2.4 for x in 0..1: x^2 times the square of its fifth root, found by Newton's method.
double power_2_4(double x) {
  if (x <= 0) return 0;
  double root = 1;
  for (int k = 0; k < 60; ++k) {
    const double fourth = root * root * root * root;
    const double better = root - (root * fourth - x) / (5 * fourth);
    if (better == root) break;  // all steps that follow would be none
    root = better;
  }
  return x * x * root * root;
}

double decode(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : power_2_4((encoded + 0.055) / 1.055);
}

struct SrgbTable {
  std::array<float, 256> linear;
  std::array<float, 255> above;  // the least linear value whose code is more than i

  SrgbTable() {
    for (int i = 0; i < 256; ++i) linear[static_cast<std::size_t>(i)] = static_cast<float>(decode(i / 255.0));
    for (int i = 0; i < 255; ++i)
      above[static_cast<std::size_t>(i)] = static_cast<float>(decode((i + 0.5) / 255.0));
  }
};

const SrgbTable& srgb() {
  static const SrgbTable table;
  return table;
}

}  // namespace

float srgb_to_linear(int code) {
  return srgb().linear[static_cast<std::size_t>(std::clamp(code, 0, 255))];
}

int linear_to_srgb(float linear) {
  const auto& above = srgb().above;
  return static_cast<int>(std::upper_bound(above.begin(), above.end(), linear) - above.begin());
}

float srgb_fraction_to_linear(float encoded) {
  constexpr int kCodes = 65'536;
  static const std::vector<float> table = [] {
    std::vector<float> values;
    for (int i = 0; i < kCodes; ++i) values.push_back(static_cast<float>(decode(i / (kCodes - 1.0))));
    return values;
  }();
  const float scaled = std::clamp(encoded, 0.0f, 1.0f) * (kCodes - 1) + 0.5f;
  return table[static_cast<std::size_t>(std::min(scaled, static_cast<float>(kCodes - 1)))];
}

void MaterialImage::derive_slopes(float relief) {
  const float scale = relief * 0.5f * static_cast<float>(side);
  for (int j = 0; j < side; ++j) {
    const int up = j + 1 < side ? j + 1 : 0, down = j > 0 ? j - 1 : side - 1;
    for (int i = 0; i < side; ++i) {
      const int right = i + 1 < side ? i + 1 : 0, left = i > 0 ? i - 1 : side - 1;
      slope[at(i, j)] = {scale * (height[at(right, j)] - height[at(left, j)]),
                         scale * (height[at(i, up)] - height[at(i, down)])};
    }
  }
}

MaterialImage MaterialImage::halved() const {
  MaterialImage half(side / 2);
  for (int j = 0; j < half.side; ++j) {
    for (int i = 0; i < half.side; ++i) {
      const std::size_t from[] = {at(2 * i, 2 * j), at(2 * i + 1, 2 * j), at(2 * i, 2 * j + 1),
                                  at(2 * i + 1, 2 * j + 1)};
      const std::size_t to = half.at(i, j);
      glm::vec3 colour(0);
      glm::vec2 gradient(0);
      float level = 0, rough = 0;
      for (const std::size_t k : from) {
        colour += albedo[k];
        gradient += slope[k];
        level += height[k];
        rough += roughness[k];
      }
      half.albedo[to] = 0.25f * colour;
      half.slope[to] = 0.25f * gradient;
      half.height[to] = 0.25f * level;
      half.roughness[to] = 0.25f * rough;
    }
  }
  return half;
}

}  // namespace karst::bake
