// SPDX-License-Identifier: MIT
// Five layers of ground over the peers' scene: what they look like and where they lie, for OGRE and for
// karst.
#pragma once

#include <algorithm>
#include <cmath>

#include <peer_common.h>

namespace peer {

// A later layer hides the earlier ones where its cover is 1; the first lies everywhere. Limits as in a
// material file of karst (docs/materials.md); kNone: no limit.
constexpr double kNone = 1e9;
struct Layer {
  const char* name;
  double slope_low, slope_high;      // of the normal's y
  double height_low, height_high;    // metres
  double bump;                       // of the normals: height of white in repeats
  double specular;                   // 0..1
  double roughness;                  // 0..1
  unsigned char dark[3], bright[3];  // colours of low and high texels, sRGB
  int cells;                         // of the coarsest noise, a repeat
  int stretch;                       // cells down for one across: 1, or strata
};
constexpr double kSlopeSoft = 0.02, kHeightSoft = 12;  // metres
constexpr int kLayers = 5;
constexpr Layer kLayer[kLayers] = {
    {"rock", -kNone, kNone, -kNone, kNone, 0.05, 0.25, 0.70, {84, 78, 72}, {168, 160, 150}, 5, 1},
    {"grass", 0.955, kNone, -kNone, 130, 0.03, 0.10, 0.90, {52, 66, 28}, {124, 136, 70}, 12, 1},
    {"sand", 0.93, kNone, -kNone, 62, 0.015, 0.15, 0.85, {176, 150, 106}, {220, 200, 158}, 9, 1},
    {"strata", -kNone, 0.925, -kNone, kNone, 0.05, 0.20, 0.75, {120, 72, 50}, {206, 150, 112}, 3, 6},
    {"snow", 0.9, kNone, 138, kNone, 0.012, 0.50, 0.40, {214, 222, 232}, {250, 252, 255}, 7, 1},
};

inline double smooth(double low, double high, double v) {
  const double t = std::clamp((v - low) / (high - low), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}
inline double between(double low, double high, double soft, double v) {
  return smooth(low - soft, low + soft, v) * (1 - smooth(high - soft, high + soft, v));
}
// normal_y: of the ground, 0..1. height: metres.
inline double cover(const Layer& layer, double normal_y, double height) {
  return between(layer.slope_low, layer.slope_high, kSlopeSoft, normal_y) *
         between(layer.height_low, layer.height_high, kHeightSoft, height);
}
// Of the heightmap at a sample, by central differences.
inline double normal_y(const Heightmap& map, int i, int j) {
  const int i0 = std::max(i - 1, 0), i1 = std::min(i + 1, kN - 1);
  const int j0 = std::max(j - 1, 0), j1 = std::min(j + 1, kN - 1);
  const double x = (map.h(i1, j) - map.h(i0, j)) / ((i1 - i0) * kCell);
  const double z = (map.h(i, j1) - map.h(i, j0)) / ((j1 - j0) * kCell);
  return 1 / std::sqrt(1 + x * x + z * z);
}

}  // namespace peer
