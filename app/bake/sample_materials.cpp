// SPDX-License-Identifier: MIT
#include "app/bake/sample_materials.h"

#include "app/bake/tile_noise.h"

#include <algorithm>

namespace karst::bake {
namespace {

// Detail finer than a texel of a small image would be lost or alias: images are made this large at least,
// and averaged down.
constexpr int kLeastMade = 512;

struct Entry {
  std::string_view name;
  glm::vec3 low, high;
  int period;
  glm::ivec2 stretch;
  float relief;
  float roughness;
};
constexpr Entry kEntries[] = {
    {"rock", {0.12f, 0.11f, 0.10f}, {0.28f, 0.26f, 0.24f}, 6, {1, 1}, 0.06f, 0.85f},
    {"grass", {0.06f, 0.06f, 0.025f}, {0.10f, 0.15f, 0.045f}, 24, {1, 1}, 0.03f, 0.95f},
    {"sand", {0.28f, 0.22f, 0.14f}, {0.42f, 0.34f, 0.22f}, 8, {1, 3}, 0.02f, 0.9f},
    {"strata", {0.16f, 0.10f, 0.07f}, {0.36f, 0.27f, 0.19f}, 4, {1, 6}, 0.06f, 0.88f},
    {"snow", {0.74f, 0.78f, 0.84f}, {0.86f, 0.88f, 0.92f}, 3, {1, 1}, 0.02f, 0.6f},
    {"ceiling", {0.05f, 0.045f, 0.04f}, {0.14f, 0.125f, 0.11f}, 7, {1, 1}, 0.07f, 0.55f},
};

}  // namespace

bool is_sample_material(std::string_view name) {
  return std::any_of(std::begin(kEntries), std::end(kEntries),
                     [&](const Entry& e) { return e.name == name; });
}

MaterialImage make_sample_material(std::string_view name, int side) {
  const Entry& entry =
      *std::find_if(std::begin(kEntries), std::end(kEntries), [&](const Entry& e) { return e.name == name; });
  MaterialImage image(std::max(side, kLeastMade));
  for (int j = 0; j < image.side; ++j) {
    for (int i = 0; i < image.side; ++i) {
      const glm::vec2 p((static_cast<float>(i) + 0.5f) / static_cast<float>(image.side),
                        (static_cast<float>(j) + 0.5f) / static_cast<float>(image.side));
      const float n = tile_fbm(p, entry.period * entry.stretch, 5, 1);
      const float h = std::clamp(0.5f + 0.5f * n, 0.0f, 1.0f);
      const std::size_t at = image.at(i, j);
      image.height[at] = h;
      image.albedo[at] = entry.low + h * (entry.high - entry.low);
      image.roughness[at] = entry.roughness;
    }
  }
  image.derive_slopes(entry.relief);
  while (image.side > side) image = image.halved();
  return image;
}

}  // namespace karst::bake
