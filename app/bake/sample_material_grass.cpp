// SPDX-License-Identifier: MIT
// Grass from above: blades in tufts, soil and dead stalks between them. Blades are drawn one by one as bent,
// tapering strokes, and the higher one hides the lower.
#include "app/bake/noise.h"
#include "app/bake/sample_material_paint.h"
#include "app/bake/tile_noise.h"

#include <algorithm>
#include <cmath>

namespace karst::bake {
namespace {

constexpr int kTufts = 26;  // a side

struct Blade {
  glm::vec2 root{0};
  glm::vec2 way{0};         // from root to tip, shares of a repeat
  glm::vec2 bend{0};        // how far the middle lies off the line
  float width = 0;          // at the root
  float foot = 0, tip = 0;  // heights
  glm::vec3 colour{0};
};

class Meadow {
 public:
  explicit Meadow(MaterialImage& image) : image_(image), size_(static_cast<float>(image.side)) {}

  void draw(const Blade& blade) {
    const float length = std::sqrt(blade.way.x * blade.way.x + blade.way.y * blade.way.y);
    const int steps = std::max(4, static_cast<int>(length * size_ * 2));
    for (int k = 0; k <= steps; ++k) {
      const float t = static_cast<float>(k) / static_cast<float>(steps);
      const float bow = 4 * t * (1 - t);
      const glm::vec2 at = blade.root + t * blade.way + bow * blade.bend;
      const float height = blend(blade.foot, blade.tip, t * (2 - t));
      // Light comes through the tips, the feet are in shade.
      disc(at, 0.5f * blade.width * (1 - 0.85f * t), height, (0.55f + 0.6f * t) * blade.colour);
    }
  }

 private:
  void disc(glm::vec2 at, float radius, float height, glm::vec3 colour) {
    const float x = at.x * size_, y = at.y * size_, r = std::max(radius * size_, 0.55f);
    const int i0 = static_cast<int>(std::floor(x - r)), i1 = static_cast<int>(std::floor(x + r));
    const int j0 = static_cast<int>(std::floor(y - r)), j1 = static_cast<int>(std::floor(y + r));
    for (int j = j0; j <= j1; ++j) {
      for (int i = i0; i <= i1; ++i) {
        const float dx = static_cast<float>(i) + 0.5f - x, dy = static_cast<float>(j) + 0.5f - y;
        const float square = (dx * dx + dy * dy) / (r * r);
        if (square > 1) continue;
        const std::size_t texel = image_.at(i & (image_.side - 1), j & (image_.side - 1));
        // The blade's back is round.
        const float here = height - 0.03f * square;
        if (here <= image_.height[texel]) continue;
        image_.height[texel] = here;
        image_.albedo[texel] = colour;
        image_.roughness[texel] = 0.68f;
      }
    }
  }

  MaterialImage& image_;
  float size_;
};

PaintedTexel soil(glm::vec2 p) {
  const float clods = tile_fbm(p, 26, 5, 111, 0.6f);
  const float patches = tile_fbm(p, 4, 4, 112);
  const TileCell pebble = tile_cell(p, {44, 44}, 1, 113);
  PaintedTexel texel;
  texel.height = 0.16f + 0.10f * clods;
  glm::vec3 colour = blend(glm::vec3(0.072f, 0.050f, 0.030f), glm::vec3(0.115f, 0.088f, 0.052f),
                           smooth(-0.5f, 0.5f, patches));
  colour *= 1 + 0.4f * clods;
  if (pebble.id % 9 == 0 && pebble.nearest < 0.3f) {
    texel.height += 0.08f * (1 - pebble.nearest / 0.3f);
    colour = glm::vec3(0.15f, 0.135f, 0.115f) * (0.7f + 0.5f * unit_of(pebble.id));
  }
  texel.albedo = colour;
  texel.roughness = 0.95f;
  return texel;
}

}  // namespace

void paint_grass(MaterialImage& image) {
  paint(image, soil);
  Meadow meadow(image);
  // Four blades a tuft at a time, so that no tuft lies wholly above its neighbour.
  for (int round = 0; round < 13; ++round) {
    for (int tuft = 0; tuft < kTufts * kTufts; ++tuft) {
      const std::uint32_t hash = hash_cell(tuft % kTufts, tuft / kTufts, 0, 121);
      const glm::vec2 middle((static_cast<float>(tuft % kTufts) + unit_of(hash)) / kTufts,
                             (static_cast<float>(tuft / kTufts) + unit_of(mix_bits(hash))) / kTufts);
      const float lush =
          smooth(-0.6f, 0.3f, tile_fbm(middle, 7, 3, 122)) * (0.55f + 0.45f * unit_of(mix_bits(hash + 5)));
      const float dry =
          0.25f + 0.35f * tile_fbm(middle, 7, 3, 123) + 0.4f * (unit_of(mix_bits(hash + 6)) - 0.5f);
      const glm::vec2 wind(0.5f * tile_noise(middle, 3, 124), 0.5f * tile_noise(middle, 3, 125));
      const float stand = lush * (0.4f + 0.6f * unit_of(mix_bits(hash + 7)));
      const float hue = unit_of(mix_bits(hash + 8));
      for (int k = 0; k < 4; ++k) {
        std::uint32_t random = hash_cell(tuft, round * 4 + k, 0, 126);
        const auto next = [&] {
          random = mix_bits(random + 0x9e3779b9u);
          return unit_of(random);
        };
        if (next() > 0.15f + 0.85f * lush) continue;
        Blade blade;
        const glm::vec2 off(next() - 0.5f, next() - 0.5f);
        blade.root = middle + (0.8f / kTufts) * off;
        const float length = (0.020f + 0.034f * next()) * (0.6f + 0.5f * lush);
        glm::vec2 way = 1.5f * off + wind + 0.9f * glm::vec2(next() - 0.5f, next() - 0.5f);
        const float norm = std::sqrt(way.x * way.x + way.y * way.y) + 1e-3f;
        way *= length / norm;
        blade.way = way;
        blade.bend = (next() - 0.5f) * 0.5f * glm::vec2(-way.y, way.x);
        blade.width = 0.0035f + 0.0025f * next();
        blade.foot = 0.14f + 0.10f * next() + 0.22f * stand;
        blade.tip = blade.foot + (0.12f + 0.18f * next()) * (0.5f + 0.5f * lush);
        const float straw = smooth(0.45f, 0.95f, 0.65f * next() + 0.6f * dry);
        const glm::vec3 green = blend(glm::vec3(0.062f, 0.090f, 0.026f), glm::vec3(0.132f, 0.144f, 0.048f),
                                      0.5f * next() + 0.5f * hue);
        blade.colour = blend(green, glm::vec3(0.235f, 0.195f, 0.092f), straw);
        meadow.draw(blade);
      }
    }
  }
  image.derive_slopes(0.014f);
}

}  // namespace karst::bake
