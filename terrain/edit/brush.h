// SPDX-License-Identifier: MIT
// What a brush of heights reaches, and how strongly. Plain IEEE operations alone, so that the same edit gives
// the same bits anywhere.
#pragma once

#include <glm/vec3.hpp>

#include "terrain/base/simd.h"
#include "terrain/edit/edit.h"

namespace karst::core {

// The share of a brush's strength at a share of its radius, 1 in the middle and 0 from the radius on: K's
// tanh((r - d delta) s) (K equation 5.1), with (r - d delta) s going from kBrushSteepness to 0 between the
// part that `hardness` says and the radius, over its value in the middle. K's own stays below 1 there.
inline constexpr double kBrushSteepness = 3;
double brush_profile(double share, double hardness);

// The same at a place, voxels. Of a box the largest of the shares along its axes counts, of a cylinder the
// distance from its axis alone. Precondition: the shape is not a voxel.
double brush_weight(const Edit& edit, const glm::dvec3& place);
// Of two places, by axis; the same bits.
simd::Double2 brush_weights(const Edit& edit, const simd::Double2 (&place)[3]);

struct BrushBox {
  glm::dvec3 low, high;
};
// Nothing outside has a weight. Of a cylinder without ends.
BrushBox brush_box(const Edit& edit);

// 3D simplex noise (K. Perlin, "Noise hardware", 2001) with gradients from an integer hash; of a place in
// wave lengths, less than 2^50 from 0; -1..1, 0 in the mean, continuous with its slope.
double simplex_noise(const glm::dvec3& place, std::uint32_t seed);
// Of two places, by axis; the same bits.
simd::Double2 simplex_noise(const simd::Double2 (&place)[3], std::uint32_t seed);

}  // namespace karst::core
