// SPDX-License-Identifier: MIT
// Rock: blocks broken along cracks of three sizes, weathered faces, dust and lichen. Ceiling: rock that
// water dissolved into scallops, dark and wet, with crusts of lime.
#include "bake/procedural/sample_material_paint.h"
#include "bake/procedural/tile_noise.h"

#include <cmath>

namespace karst::bake {
namespace {

// Cells of one size as blocks of rock: a height and a tilt each, and how near the crack between them is.
struct Blocks {
  float level = 0;  // about -1..1, with the block's tilt
  float gap = 0;    // 1 in the middle of a crack, 0 beside it
  float halo = 0;   // the same, wider
  float tint = 0;   // 0..1, of the block
};

Blocks blocks(glm::vec2 p, glm::ivec2 period, float crack, std::uint32_t seed) {
  const TileCell cell = tile_cell(p, period, 0.95f, seed);
  const float tilt_x = unit_of(cell.id * 0x9e3779b1u) - 0.5f;
  const float tilt_y = unit_of(cell.id * 0x85ebca77u) - 0.5f;
  Blocks b;
  b.level = 1.1f * (unit_of(cell.id * 0xc2b2ae3du) - 0.5f) - 1.3f * (tilt_x * cell.to.x + tilt_y * cell.to.y);
  b.gap = 1 - smooth(0, crack, cell.border);
  b.halo = 1 - smooth(0, 6 * crack, cell.border);
  b.tint = unit_of(cell.id * 0x27d4eb2fu);
  return b;
}

glm::vec2 warped(glm::vec2 p, int period, float reach, int octaves, std::uint32_t seed) {
  return {p.x + reach * tile_fbm(p, period, octaves, seed),
          p.y + reach * tile_fbm(p, period, octaves, seed + 7)};
}

}  // namespace

void paint_rock(MaterialImage& image) {
  paint(image, [](glm::vec2 p) {
    // Faces broken at every size: facets of facets, with steps between them rather than grooves.
    const glm::vec2 bent = warped(p, 4, 0.05f, 4, 11);
    const glm::vec2 fine = warped(p, 10, 0.016f, 4, 13);
    const Blocks huge = blocks(bent, {4, 3}, 0.035f, 21);
    const Blocks large = blocks(warped(p, 6, 0.03f, 4, 12), {6, 9}, 0.05f, 22);
    const Blocks middle = blocks(fine, {15, 12}, 0.08f, 23);
    const Blocks small = blocks(fine, {27, 31}, 0.1f, 24);
    const Blocks chips = blocks(warped(p, 30, 0.005f, 2, 15), {56, 60}, 0.2f, 25);
    // Cracks open here and close there.
    const float open = smooth(0.05f, 0.5f, tile_fbm(p, 5, 3, 31));
    const float split = smooth(0.0f, 0.4f, tile_fbm(p, 7, 3, 37));
    const float broken = smooth(-0.3f, 0.4f, tile_fbm(p, 4, 3, 32));
    const float grain = tile_fbm(p, 48, 4, 33, 0.65f);
    const float weathered = tile_fbm(bent, 5, 6, 34, 0.55f);
    const float gap =
        1 - (1 - 0.9f * open * huge.gap) * (1 - 0.8f * split * large.gap) * (1 - 0.35f * broken * middle.gap);

    PaintedTexel texel;
    texel.height =
        0.52f + 0.20f * huge.level + 0.22f * large.level +
        (0.5f + 0.5f * broken) * (0.15f * middle.level + 0.09f * small.level + 0.035f * chips.level) +
        0.13f * weathered + 0.03f * grain - 0.20f * gap;

    const glm::vec3 grey(0.200f, 0.186f, 0.168f), warm(0.252f, 0.200f, 0.142f), dark(0.060f, 0.052f, 0.043f);
    glm::vec3 colour = blend(grey, warm, smooth(-0.4f, 0.5f, tile_fbm(bent, 4, 5, 35)));
    colour *= 0.84f + 0.05f * huge.tint + 0.13f * large.tint + 0.12f * middle.tint + 0.10f * small.tint;
    colour *= 1 + 0.34f * weathered + 0.20f * grain;
    // Dirt runs out of cracks, hollows keep it, edges are rubbed bright.
    colour *= 1 - 0.38f * open * huge.halo - 0.30f * split * large.halo;
    colour = blend(colour, dark, 0.85f * gap);
    colour *= 0.76f + 0.40f * smooth(0.15f, 0.80f, texel.height);
    const float lichen = smooth(0.22f, 0.34f, tile_fbm(bent, 11, 5, 36, 0.65f)) * (1 - gap);
    colour = blend(colour, glm::vec3(0.235f, 0.232f, 0.165f), 0.45f * lichen);
    texel.albedo = colour;
    texel.roughness = 0.80f + 0.08f * grain + 0.10f * lichen + 0.10f * gap;
    return texel;
  });
  image.derive_slopes(0.105f);
}

void paint_ceiling(MaterialImage& image) {
  paint(image, [](glm::vec2 p) {
    const glm::vec2 bent = warped(p, 5, 0.03f, 4, 51);
    // Scallops: bowls that meet in sharp ridges.
    const TileCell wide = tile_cell(bent, {6, 6}, 0.9f, 61);
    const TileCell narrow = tile_cell(warped(p, 11, 0.015f, 3, 53), {15, 14}, 0.9f, 62);
    const float bowl = clamp01(wide.nearest * 1.25f), dent = clamp01(narrow.nearest * 1.25f);
    const float lumps = tile_fbm(p, 9, 5, 63, 0.55f);
    const float grain = tile_fbm(p, 40, 4, 64, 0.6f);
    const float lime = smooth(0.12f, 0.38f, tile_fbm(bent, 6, 5, 65, 0.6f) + 0.12f * (1 - bowl));
    PaintedTexel texel;
    const float shape = 0.18f + 0.34f * bowl * bowl + 0.16f * dent * dent + 0.16f * lumps + 0.07f * lime;
    const float damp = smooth(-0.35f, 0.35f, tile_fbm(p, 5, 4, 66) + 0.45f * (0.5f - shape));
    // A film of water fills the grain.
    texel.height = shape + 0.035f * grain * (1 - 0.8f * damp);

    const glm::vec3 wet(0.058f, 0.052f, 0.046f), dry(0.145f, 0.128f, 0.108f);
    glm::vec3 colour = blend(dry, wet, damp);
    colour =
        blend(colour, glm::vec3(0.155f, 0.10f, 0.052f), 0.38f * smooth(0.0f, 0.5f, tile_fbm(bent, 7, 5, 67)));
    colour = blend(colour, glm::vec3(0.24f, 0.222f, 0.19f), 0.5f * lime * (1 - 0.4f * damp));
    colour *= 1 + 0.22f * grain + 0.18f * lumps;
    colour *= 0.72f + 0.5f * smooth(0.1f, 0.7f, texel.height);
    texel.albedo = colour;
    texel.roughness = blend(0.80f + 0.08f * grain, 0.40f + 0.08f * lumps, damp * (1 - 0.5f * lime));
    return texel;
  });
  image.derive_slopes(0.075f);
}

}  // namespace karst::bake
