// SPDX-License-Identifier: MIT
// What the painters of procedural materials share. Each paints a square image of any power of two texels
// from 128 on, the same picture at any size; sizes below are shares of a repeat.
#pragma once

#include "bake/textures/material_image.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace karst::bake {

void paint_grass(MaterialImage& image);
void paint_rock(MaterialImage& image);
void paint_strata(MaterialImage& image);
void paint_sand(MaterialImage& image);
void paint_snow(MaterialImage& image);
void paint_ceiling(MaterialImage& image);

struct PaintedTexel {
  glm::vec3 albedo{0};  // linear
  float height = 0;     // 0..1
  float roughness = 1;
};

inline float clamp01(float x) {
  return x < 0 ? 0.0f : x > 1 ? 1.0f : x;
}

inline float smooth(float low, float high, float x) {
  const float t = clamp01((x - low) / (high - low));
  return t * t * (3 - 2 * t);
}

inline float blend(float a, float b, float t) {
  return a + (b - a) * t;
}

inline glm::vec3 blend(glm::vec3 a, glm::vec3 b, float t) {
  return a + (b - a) * t;
}

// Sets every texel to texel(p), p the middle of it in 0..1.
template <class F>
void paint(MaterialImage& image, const F& texel) {
  const float size = 1 / static_cast<float>(image.side);
  for (int j = 0; j < image.side; ++j) {
    for (int i = 0; i < image.side; ++i) {
      const glm::vec2 p((static_cast<float>(i) + 0.5f) * size, (static_cast<float>(j) + 0.5f) * size);
      const PaintedTexel painted = texel(p);
      const std::size_t at = image.at(i, j);
      for (int c = 0; c < 3; ++c) image.albedo[at][c] = clamp01(painted.albedo[c]);
      image.height[at] = clamp01(painted.height);
      image.roughness[at] = clamp01(painted.roughness);
    }
  }
}

}  // namespace karst::bake
