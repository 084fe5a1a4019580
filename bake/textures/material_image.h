// SPDX-License-Identifier: MIT
// One material's texture at full size, in numbers that can be averaged: linear colour, height, slopes
// instead of normals. It tiles. Row 0 is at t = 0, the lower edge where t points up.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <vector>

namespace karst::bake {

struct MaterialImage {
  int side = 0;                   // texels; all below side x side, row by row
  std::vector<glm::vec3> albedo;  // linear, 0..1
  std::vector<float> height;      // 0..1
  std::vector<glm::vec2> slope;   // of the height along s and t, both in repeats of the texture
  std::vector<float> roughness;   // 0..1; its square is GGX's alpha

  explicit MaterialImage(int texels = 0)
      : side(texels), albedo(count()), height(count()), slope(count()), roughness(count(), 1.0f) {}

  std::size_t count() const { return static_cast<std::size_t>(side) * static_cast<std::size_t>(side); }
  std::size_t at(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(side) + static_cast<std::size_t>(i);
  }

  // Slopes of the height by central differences; height 1 is `relief` repeats high.
  void derive_slopes(float relief);
  // Averages of 2 x 2 texels, `times` times; the height's slopes stay those of the fine image, averaged.
  MaterialImage halved() const;
};

// sRGB (IEC 61966-2-1) for 8 bits. Encoding takes the nearest code, without libm: the same everywhere.
float srgb_to_linear(int code);
int linear_to_srgb(float linear);
// Of any value; below 0 and above 1 as at 0 and 1. To the nearest of 65,536 codes.
float srgb_fraction_to_linear(float encoded);

}  // namespace karst::bake
