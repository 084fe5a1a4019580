// SPDX-License-Identifier: MIT
// Grass from above: blades in tufts, soil and dead stalks between them. Blades are drawn one by one as bent,
// tapering strokes, and the higher one hides the lower.
#include "bake/procedural/sample_material_paint.h"
#include "bake/procedural/tile_noise.h"
#include "bake/samples/noise.h"

#include <algorithm>
#include <cmath>

namespace karst::bake {
namespace {

constexpr int kTufts = 26;  // a side
constexpr int kRounds = 13, kBladesARound = 4;

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

struct Soil {
  TileFbm clods{26, 5, 111, 0.6f}, patches{4, 4, 112};
  TileCells pebbles{{44, 44}, 1, 113};

  PaintedTexel at(glm::vec2 p) const;
};

PaintedTexel Soil::at(glm::vec2 p) const {
  const float clod = clods.at(p);
  const TileCells::Nearest pebble = pebbles.nearest(p);
  PaintedTexel texel;
  texel.height = 0.16f + 0.10f * clod;
  glm::vec3 colour = blend(glm::vec3(0.070f, 0.053f, 0.028f), glm::vec3(0.112f, 0.092f, 0.048f),
                           smooth(-0.5f, 0.5f, patches.at(p)));
  colour *= 1 + 0.4f * clod;
  if (pebble.id % 9 == 0 && pebble.distance < 0.3f) {
    texel.height += 0.08f * (1 - pebble.distance / 0.3f);
    colour = glm::vec3(0.15f, 0.135f, 0.115f) * (0.7f + 0.5f * unit_of(pebble.id));
  }
  texel.albedo = colour;
  texel.roughness = 0.95f;
  return texel;
}

struct Tuft {
  glm::vec2 middle{0};
  float lush = 0, dry = 0;  // 0..1, about
  glm::vec2 wind{0};
  float stand = 0;  // how much higher it stands than others
  float hue = 0;
};

struct Tufts {
  TileFbm lush{7, 3, 122}, dry{7, 3, 123};
  TileNoise wind_x{{3, 3}, 124}, wind_y{{3, 3}, 125};

  Tuft at(int number) const;
};

Tuft Tufts::at(int number) const {
  const std::uint32_t hash = hash_cell(number % kTufts, number / kTufts, 0, 121);
  Tuft tuft;
  tuft.middle = {(static_cast<float>(number % kTufts) + unit_of(hash)) / kTufts,
                 (static_cast<float>(number / kTufts) + unit_of(mix_bits(hash))) / kTufts};
  tuft.lush = smooth(-0.6f, 0.3f, lush.at(tuft.middle)) * (0.55f + 0.45f * unit_of(mix_bits(hash + 5)));
  tuft.dry = 0.25f + 0.35f * dry.at(tuft.middle) + 0.4f * (unit_of(mix_bits(hash + 6)) - 0.5f);
  tuft.wind = {0.5f * wind_x.at(tuft.middle), 0.5f * wind_y.at(tuft.middle)};
  tuft.stand = tuft.lush * (0.4f + 0.6f * unit_of(mix_bits(hash + 7)));
  tuft.hue = unit_of(mix_bits(hash + 8));
  return tuft;
}

// Random numbers of one blade.
class BladeRandom {
 public:
  explicit BladeRandom(std::uint32_t state) : state_(state) {}
  float next() {
    state_ = mix_bits(state_ + 0x9e3779b9u);
    return unit_of(state_);
  }
  // Not as two arguments of a call: compilers evaluate those in different orders.
  glm::vec2 next_pair() {
    const float first = next() - 0.5f;
    const float second = next() - 0.5f;
    return {first, second};
  }

 private:
  std::uint32_t state_;
};

Blade make_blade(const Tuft& tuft, BladeRandom& random) {
  Blade blade;
  const glm::vec2 off = random.next_pair();
  blade.root = tuft.middle + (0.8f / kTufts) * off;
  const float length = (0.020f + 0.034f * random.next()) * (0.6f + 0.5f * tuft.lush);
  const glm::vec2 way = 1.5f * off + tuft.wind + 0.9f * random.next_pair();
  blade.way = way * (length / (std::sqrt(way.x * way.x + way.y * way.y) + 1e-3f));
  blade.bend = (random.next() - 0.5f) * 0.5f * glm::vec2(-blade.way.y, blade.way.x);
  blade.width = 0.0035f + 0.0025f * random.next();
  blade.foot = 0.14f + 0.10f * random.next() + 0.22f * tuft.stand;
  blade.tip = blade.foot + (0.12f + 0.18f * random.next()) * (0.5f + 0.5f * tuft.lush);
  const float straw = smooth(0.45f, 0.95f, 0.65f * random.next() + 0.6f * tuft.dry);
  const glm::vec3 green = blend(glm::vec3(0.062f, 0.090f, 0.026f), glm::vec3(0.132f, 0.144f, 0.048f),
                                0.5f * random.next() + 0.5f * tuft.hue);
  blade.colour = blend(green, glm::vec3(0.235f, 0.195f, 0.092f), straw);
  return blade;
}

}  // namespace

void paint_grass(MaterialImage& image) {
  const Soil soil;
  paint(image, [&](glm::vec2 p) { return soil.at(p); });
  const Tufts tufts;
  Meadow meadow(image);
  // Four blades a tuft at a time, so that no tuft lies wholly above its neighbour.
  for (int round = 0; round < kRounds; ++round) {
    for (int number = 0; number < kTufts * kTufts; ++number) {
      const Tuft tuft = tufts.at(number);
      for (int k = 0; k < kBladesARound; ++k) {
        BladeRandom random(hash_cell(number, round * kBladesARound + k, 0, 126));
        if (random.next() <= 0.15f + 0.85f * tuft.lush) meadow.draw(make_blade(tuft, random));
      }
    }
  }
  image.derive_slopes(0.014f);
}

}  // namespace karst::bake
