// SPDX-License-Identifier: MIT
// Strata: level beds, t up, thick ones made of thin ones. Hard beds stand out as ledges of uneven depth, soft
// ones crumble below them; short cracks run down from ledge to ledge.
#include "bake/procedural/sample_material_paint.h"
#include "bake/procedural/tile_noise.h"
#include "bake/samples/noise.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace karst::bake {
namespace {

// One bed, found from the height t alone.
struct Bed {
  float from_bottom = 0, from_top = 0;  // shares of a repeat
  float thickness = 0;
  std::uint32_t id = 0;
};

// A repeat cut into beds of uneven thickness.
class Beds {
 public:
  Beds(int count, std::uint32_t seed) {
    float end = 0;
    for (int k = 0; k < count; ++k) {
      const float u = unit_of(hash_cell(k, 0, 0, seed));
      ids_.push_back(hash_cell(k, 1, 0, seed));
      end += 0.3f + 1.4f * u * u;
      tops_.push_back(end);
    }
    for (float& top : tops_) top /= end;
    tops_.back() = 1;
  }

  Bed at(float t) const {
    t -= std::floor(t);
    std::size_t k = 0;
    while (k + 1 < tops_.size() && t >= tops_[k]) ++k;
    const float bottom = k == 0 ? 0.0f : tops_[k - 1];
    return {t - bottom, tops_[k] - t, tops_[k] - bottom, ids_[k]};
  }

 private:
  std::vector<float> tops_;
  std::vector<std::uint32_t> ids_;
};

// Sandstone, limestone, mudstone, shale, siltstone: of about the same brightness, so that none stands out,
// and not far from their mean, because the picture multiplies two scales of them.
glm::vec3 bed_colour(std::uint32_t id) {
  static constexpr glm::vec3 kColours[] = {{0.305f, 0.205f, 0.125f},
                                           {0.325f, 0.265f, 0.185f},
                                           {0.255f, 0.140f, 0.085f},
                                           {0.225f, 0.185f, 0.150f},
                                           {0.285f, 0.175f, 0.105f}};
  const glm::vec3 own =
      blend(kColours[mix_bits(id + 2) % 5], kColours[mix_bits(id + 3) % 5], unit_of(mix_bits(id + 4)));
  return blend(own, glm::vec3(0.279f, 0.194f, 0.130f), 0.3f);
}

float hardness_of(std::uint32_t id) {
  return unit_of(mix_bits(id + 1));
}

}  // namespace

void paint_strata(MaterialImage& image) {
  const Beds thick(11, 772), thin(46, 773);
  const TileFbm sagging({2, 3}, 3, 81), ragging({12, 16}, 5, 82, 0.6f), wearing({5, 14}, 4, 83, 0.55f),
      chipping({16, 30}, 4, 89, 0.55f), bending({7, 9}, 4, 84), opening({6, 9}, 3, 91),
      laminating({3, 72}, 3, 85, 0.65f), crumbling({26, 34}, 5, 86, 0.65f), roughening({9, 13}, 6, 87, 0.6f),
      streaks({24, 3}, 5, 88, 0.6f);
  const TileCells cells({8, 5}, 1, 90), shards({21, 30}, 1, 92);
  paint(image, [&](glm::vec2 p) {
    // Beds swell and sag a little, and their borders are ragged.
    const float sag = 0.011f * sagging.at(p);
    const float ragged = 0.0045f * ragging.at(p);
    const Bed major = thick.at(p.y + 0.03f + sag + ragged);
    const Bed minor = thin.at(p.y + 0.57f + 1.2f * sag + 0.8f * ragged);
    // How far a ledge stands out changes along it.
    const float worn = wearing.at({p.x, p.y + sag});
    const float chipped = chipping.at({p.x, p.y + sag});
    const float hard =
        clamp01(0.62f * hardness_of(major.id) + 0.48f * hardness_of(minor.id) - 0.05f + 0.22f * worn);

    // Cracks: borders of tall cells, in hard beds, bent, and each bed's own.
    const float shift = unit_of(mix_bits(major.id + 6));
    const glm::vec2 bent(p.x + shift + 0.022f * bending.at(p), p.y + 0.02f * chipped);
    const TileCells::Nearest cell = cells.nearest(bent);
    const TileCells::Nearest shard = shards.nearest({p.x + 0.012f * chipped, p.y + 0.012f * worn});
    const float upright =
        smooth(0.5f, 0.85f, std::abs(cell.to.x) / (std::abs(cell.to.x) + std::abs(cell.to.y) + 1e-3f));
    const float open = smooth(0.35f, 0.65f, hard) * smooth(-0.15f, 0.3f, opening.at(p)) * upright;
    const float gap = open == 0 ? 0.0f : open * (1 - smooth(0.0f, 0.035f, cells.border(bent, cell)));

    const float laminae = laminating.at({p.x, p.y + 2 * sag + ragged});
    const float crumbs = crumbling.at(p);
    const float rough = roughening.at(p);
    const float facet = unit_of(shard.id) - 0.5f;
    const float block = (unit_of(mix_bits(cell.id ^ major.id)) - 0.5f) * smooth(0.3f, 0.7f, hard);

    PaintedTexel texel;
    // Edges are rounded, more so where worn; soft beds are hollowed out from below the bed above.
    const float edge = smooth(0.0f, 0.010f, std::min(minor.from_top, minor.from_bottom));
    const float overhang = 1 - smooth(0.0f, 0.02f, major.from_top);
    texel.height = 0.24f + 0.42f * hard * (0.75f + 0.25f * edge) - 0.08f * overhang * (1 - hard) +
                   0.10f * block + 0.045f * laminae + 0.09f * rough + (0.03f + 0.05f * (1 - hard)) * crumbs +
                   0.05f * facet - 0.13f * gap;

    glm::vec3 colour = blend(bed_colour(major.id), bed_colour(minor.id), 0.5f);
    colour *= 0.98f + 0.20f * laminae + 0.12f * block + 0.16f * crumbs + 0.10f * rough + 0.10f * facet;
    colour *= 1 - 0.48f * gap;
    // Shade and dirt in the hollows, dust on the ledges.
    colour *= 0.70f + 0.46f * smooth(0.15f, 0.65f, texel.height);
    // Water runs down and leaves dark and pale streaks.
    colour *= 1 + 0.20f * streaks.at(p);
    texel.albedo = colour;
    texel.roughness = 0.86f + 0.06f * crumbs + 0.05f * gap - 0.05f * hard;
    return texel;
  });
  image.derive_slopes(0.085f);
}

}  // namespace karst::bake
