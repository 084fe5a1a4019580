// SPDX-License-Identifier: MIT
// Sand with ripples that the wind made, and snow with soft drifts.
#include "bake/procedural/sample_material_paint.h"
#include "bake/procedural/tile_noise.h"
#include "bake/samples/noise.h"

#include <cmath>

namespace karst::bake {
namespace {

// A ripple's profile over its phase: a long rise against the wind, a short slip face. 0..1.
float ripple(float phase) {
  const float x = phase - std::floor(phase);
  constexpr float kCrest = 0.68f;
  const float t = x < kCrest ? x / kCrest : (1 - x) / (1 - kCrest);
  return t * t * (3 - 2 * t);
}

}  // namespace

void paint_sand(MaterialImage& image) {
  paint(image, [](glm::vec2 p) {
    // Crests wander, end and fork: two trains of ripples that fade into each other where their phases drift.
    const float drift = tile_fbm(p, {3, 5}, 3, 91);
    const float wander = 0.55f * tile_fbm(p, {4, 9}, 3, 92) + 0.9f * tile_noise(p, {2, 3}, 93);
    const float first = ripple(17 * p.x + 2 * p.y + wander);
    const float second = ripple(20 * p.x - 1 * p.y + 0.8f * wander + 0.37f);
    const float mix = smooth(-0.12f, 0.12f, drift);
    const float calm = smooth(-0.7f, 0.3f, tile_fbm(p, 5, 3, 94));
    const float ripples = blend(first, second, mix) * (0.65f + 0.35f * calm);
    const float grain = tile_fbm(p, 128, 2, 95, 0.7f);
    const float dunes = tile_fbm(p, {2, 2}, 3, 96);

    PaintedTexel texel;
    texel.height = 0.32f + 0.36f * ripples + 0.12f * dunes + 0.035f * grain;
    glm::vec3 colour = blend(glm::vec3(0.375f, 0.272f, 0.170f), glm::vec3(0.44f, 0.335f, 0.222f),
                             smooth(0.15f, 0.85f, ripples));
    // Dark, heavy grains gather in the troughs.
    const float heavy = smooth(0.35f, 0.0f, ripples) * smooth(-0.2f, 0.5f, tile_fbm(p, {6, 9}, 4, 97));
    colour = blend(colour, glm::vec3(0.21f, 0.155f, 0.105f), 0.4f * heavy);
    colour *= 1 + 0.12f * grain + 0.10f * tile_fbm(p, 5, 4, 98);
    texel.albedo = colour;
    texel.roughness = 0.90f + 0.06f * grain;
    return texel;
  });
  image.derive_slopes(0.024f);
}

void paint_snow(MaterialImage& image) {
  paint(image, [](glm::vec2 p) {
    const glm::vec2 bent(p.x + 0.05f * tile_fbm(p, 2, 3, 101), p.y + 0.05f * tile_fbm(p, 2, 3, 102));
    const float drifts = tile_fbm(bent, {4, 3}, 4, 103, 0.45f);
    // Low ridges that the wind cut, steep on one side.
    const float cut = tile_fbm(bent, {7, 13}, 3, 104, 0.5f);
    const float ridges = smooth(-0.1f, 0.55f, cut);
    const float lumps = tile_fbm(p, 22, 3, 105);
    const float grain = tile_fbm(p, 100, 2, 106, 0.7f);
    PaintedTexel texel;
    texel.height = 0.5f + 0.22f * drifts + 0.13f * (ridges - 0.4f) + 0.03f * lumps + 0.014f * grain;
    const float shade = smooth(0.25f, 0.8f, texel.height);
    glm::vec3 colour = blend(glm::vec3(0.75f, 0.79f, 0.85f), glm::vec3(0.83f, 0.85f, 0.875f), shade);
    colour *= 1 + 0.025f * grain + 0.02f * lumps;
    texel.albedo = colour;
    // Single crystals that mirror the sun.
    const TileCell crystal = tile_cell(p, {90, 90}, 1, 107);
    const float sparkle = crystal.id % 7 == 0 ? 1 - smooth(0.12f, 0.4f, crystal.nearest) : 0.0f;
    texel.roughness = blend(0.62f + 0.06f * grain, 0.22f, sparkle);
    return texel;
  });
  image.derive_slopes(0.045f);
}

}  // namespace karst::bake
