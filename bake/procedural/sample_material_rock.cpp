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

Blocks blocks(const TileCells& cells, glm::vec2 p, float crack) {
  const TileCells::Nearest cell = cells.nearest(p);
  const float border = cells.border(p, cell);
  const float tilt_x = unit_of(cell.id * 0x9e3779b1u) - 0.5f;
  const float tilt_y = unit_of(cell.id * 0x85ebca77u) - 0.5f;
  Blocks b;
  b.level = 1.1f * (unit_of(cell.id * 0xc2b2ae3du) - 0.5f) - 1.3f * (tilt_x * cell.to.x + tilt_y * cell.to.y);
  b.gap = 1 - smooth(0, crack, border);
  b.halo = 1 - smooth(0, 6 * crack, border);
  b.tint = unit_of(cell.id * 0x27d4eb2fu);
  return b;
}

// Bends what is painted.
class Warp {
 public:
  Warp(int period, float reach, int octaves, std::uint32_t seed)
      : x_(period, octaves, seed), y_(period, octaves, seed + 7), reach_(reach) {}

  glm::vec2 at(glm::vec2 p) const { return {p.x + reach_ * x_.at(p), p.y + reach_ * y_.at(p)}; }

 private:
  TileFbm x_, y_;
  float reach_;
};

}  // namespace

void paint_rock(MaterialImage& image) {
  const Warp coarse_warp(4, 0.05f, 4, 11), large_warp(6, 0.03f, 4, 12), fine_warp(10, 0.016f, 4, 13),
      chip_warp(30, 0.005f, 2, 15);
  constexpr float kJitter = 0.95f;
  const TileCells huge_cells({4, 3}, kJitter, 21), large_cells({6, 9}, kJitter, 22),
      middle_cells({15, 12}, kJitter, 23), small_cells({27, 31}, kJitter, 24),
      chip_cells({56, 60}, kJitter, 25);
  const TileFbm opening(5, 3, 31), splitting(7, 3, 37), breaking(4, 3, 32), graining(48, 4, 33, 0.65f),
      weathering(5, 6, 34, 0.55f), warming(4, 5, 35), lichens(11, 5, 36, 0.65f);
  paint(image, [&](glm::vec2 p) {
    // Faces broken at every size: facets of facets, with steps between them rather than grooves.
    const glm::vec2 bent = coarse_warp.at(p);
    const glm::vec2 fine = fine_warp.at(p);
    const Blocks huge = blocks(huge_cells, bent, 0.035f);
    const Blocks large = blocks(large_cells, large_warp.at(p), 0.05f);
    const Blocks middle = blocks(middle_cells, fine, 0.08f);
    const Blocks small = blocks(small_cells, fine, 0.1f);
    const Blocks chips = blocks(chip_cells, chip_warp.at(p), 0.2f);
    // Cracks open here and close there.
    const float open = smooth(0.05f, 0.5f, opening.at(p));
    const float split = smooth(0.0f, 0.4f, splitting.at(p));
    const float broken = smooth(-0.3f, 0.4f, breaking.at(p));
    const float grain = graining.at(p);
    const float weathered = weathering.at(bent);
    const float gap =
        1 - (1 - 0.9f * open * huge.gap) * (1 - 0.8f * split * large.gap) * (1 - 0.35f * broken * middle.gap);

    PaintedTexel texel;
    texel.height =
        0.52f + 0.20f * huge.level + 0.22f * large.level +
        (0.5f + 0.5f * broken) * (0.15f * middle.level + 0.09f * small.level + 0.035f * chips.level) +
        0.13f * weathered + 0.03f * grain - 0.20f * gap;

    const glm::vec3 grey(0.200f, 0.186f, 0.168f), warm(0.252f, 0.200f, 0.142f), dark(0.060f, 0.052f, 0.043f);
    glm::vec3 colour = blend(grey, warm, smooth(-0.4f, 0.5f, warming.at(bent)));
    colour *= 0.84f + 0.05f * huge.tint + 0.13f * large.tint + 0.12f * middle.tint + 0.10f * small.tint;
    colour *= 1 + 0.34f * weathered + 0.20f * grain;
    // Dirt runs out of cracks, hollows keep it, edges are rubbed bright.
    colour *= 1 - 0.38f * open * huge.halo - 0.30f * split * large.halo;
    colour = blend(colour, dark, 0.85f * gap);
    colour *= 0.76f + 0.40f * smooth(0.15f, 0.80f, texel.height);
    const float lichen = smooth(0.22f, 0.34f, lichens.at(bent)) * (1 - gap);
    colour = blend(colour, glm::vec3(0.235f, 0.232f, 0.165f), 0.45f * lichen);
    texel.albedo = colour;
    texel.roughness = 0.80f + 0.08f * grain + 0.10f * lichen + 0.10f * gap;
    return texel;
  });
  image.derive_slopes(0.105f);
}

void paint_ceiling(MaterialImage& image) {
  const Warp wide_warp(5, 0.03f, 4, 51), narrow_warp(11, 0.015f, 3, 53);
  // Scallops: bowls that meet in sharp ridges.
  const TileCells wide({6, 6}, 0.9f, 61), narrow({15, 14}, 0.9f, 62);
  const TileFbm lumping(9, 5, 63, 0.55f), graining(40, 4, 64, 0.6f), liming(6, 5, 65, 0.6f),
      damping(5, 4, 66), rusting(7, 5, 67);
  paint(image, [&](glm::vec2 p) {
    const glm::vec2 bent = wide_warp.at(p);
    const float bowl = clamp01(wide.nearest(bent).distance * 1.25f);
    const float dent = clamp01(narrow.nearest(narrow_warp.at(p)).distance * 1.25f);
    const float lumps = lumping.at(p);
    const float grain = graining.at(p);
    const float lime = smooth(0.12f, 0.38f, liming.at(bent) + 0.12f * (1 - bowl));
    PaintedTexel texel;
    const float shape = 0.18f + 0.34f * bowl * bowl + 0.16f * dent * dent + 0.16f * lumps + 0.07f * lime;
    const float damp = smooth(-0.35f, 0.35f, damping.at(p) + 0.45f * (0.5f - shape));
    // A film of water fills the grain.
    texel.height = shape + 0.035f * grain * (1 - 0.8f * damp);

    const glm::vec3 wet(0.058f, 0.052f, 0.046f), dry(0.145f, 0.128f, 0.108f);
    glm::vec3 colour = blend(dry, wet, damp);
    colour = blend(colour, glm::vec3(0.155f, 0.10f, 0.052f), 0.38f * smooth(0.0f, 0.5f, rusting.at(bent)));
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
