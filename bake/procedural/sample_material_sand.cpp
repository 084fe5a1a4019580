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
  const TileFbm drifting({3, 5}, 3, 91), wandering({4, 9}, 3, 92), calming(5, 3, 94),
      graining(128, 2, 95, 0.7f), dune_shapes(2, 3, 96), heaps({6, 9}, 4, 97), shades(5, 4, 98);
  const TileNoise swing({2, 3}, 93);
  paint(image, [&](glm::vec2 p) {
    // Crests wander, end and fork: two trains of ripples that fade into each other where their phases drift.
    const float drift = drifting.at(p);
    const float wander = 0.55f * wandering.at(p) + 0.9f * swing.at(p);
    const float first = ripple(17 * p.x + 2 * p.y + wander);
    const float second = ripple(20 * p.x - 1 * p.y + 0.8f * wander + 0.37f);
    const float mix = smooth(-0.12f, 0.12f, drift);
    const float calm = smooth(-0.7f, 0.3f, calming.at(p));
    const float ripples = blend(first, second, mix) * (0.65f + 0.35f * calm);
    const float grain = graining.at(p);
    const float dunes = dune_shapes.at(p);

    PaintedTexel texel;
    texel.height = 0.32f + 0.36f * ripples + 0.12f * dunes + 0.035f * grain;
    glm::vec3 colour = blend(glm::vec3(0.375f, 0.272f, 0.170f), glm::vec3(0.44f, 0.335f, 0.222f),
                             smooth(0.15f, 0.85f, ripples));
    // Dark, heavy grains gather in the troughs.
    const float heavy = smooth(0.35f, 0.0f, ripples) * smooth(-0.2f, 0.5f, heaps.at(p));
    colour = blend(colour, glm::vec3(0.21f, 0.155f, 0.105f), 0.4f * heavy);
    colour *= 1 + 0.12f * grain + 0.10f * shades.at(p);
    texel.albedo = colour;
    texel.roughness = 0.90f + 0.06f * grain;
    return texel;
  });
  image.derive_slopes(0.024f);
}

void paint_snow(MaterialImage& image) {
  const TileFbm bend_x(2, 3, 101), bend_y(2, 3, 102), drifting({4, 3}, 4, 103, 0.45f),
      cutting({7, 13}, 3, 104, 0.5f), lumping(22, 3, 105), graining(100, 2, 106, 0.7f);
  const TileCells crystals({90, 90}, 1, 107);
  paint(image, [&](glm::vec2 p) {
    const glm::vec2 bent(p.x + 0.05f * bend_x.at(p), p.y + 0.05f * bend_y.at(p));
    const float drifts = drifting.at(bent);
    // Low ridges that the wind cut, steep on one side.
    const float cut = cutting.at(bent);
    const float ridges = smooth(-0.1f, 0.55f, cut);
    const float lumps = lumping.at(p);
    const float grain = graining.at(p);
    PaintedTexel texel;
    texel.height = 0.5f + 0.22f * drifts + 0.13f * (ridges - 0.4f) + 0.03f * lumps + 0.014f * grain;
    const float shade = smooth(0.25f, 0.8f, texel.height);
    glm::vec3 colour = blend(glm::vec3(0.75f, 0.79f, 0.85f), glm::vec3(0.83f, 0.85f, 0.875f), shade);
    colour *= 1 + 0.025f * grain + 0.02f * lumps;
    texel.albedo = colour;
    // Single crystals that mirror the sun.
    const TileCells::Nearest crystal = crystals.nearest(p);
    const float sparkle = crystal.id % 7 == 0 ? 1 - smooth(0.12f, 0.4f, crystal.distance) : 0.0f;
    texel.roughness = blend(0.62f + 0.06f * grain, 0.22f, sparkle);
    return texel;
  });
  image.derive_slopes(0.045f);
}

}  // namespace karst::bake
