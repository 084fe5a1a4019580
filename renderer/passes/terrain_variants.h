// SPDX-License-Identifier: MIT
// Which of the programs in variants.def shades pixels of patches that need a given shading.
#pragma once

#include <cstdint>

#include "gles_shaders/shader_texts.h"
#include "terrain/shading/shading.h"

namespace karst::core {

// There are so many from ShaderVariant::terrain on, and from ShaderVariant::screen on.
inline constexpr int kShadingVariants = 12;

// shading: bits of Shading. 0..kShadingVariants - 1; lamps light what kShadeCave says may be lit by them.
constexpr int shading_variant(unsigned shading) {
  const int lit = (shading & kShadeCave) == 0 ? 0 : (shading & kShadeLamps) == 0 ? 1 : 2;
  return static_cast<int>(shading & kShadeBlend) + ((shading & kShadeShadows) != 0 ? 2 : 0) + 4 * lit;
}

// Its inverse.
constexpr unsigned shading_of(int variant) {
  constexpr unsigned kLit[] = {0, kShadeCave, kShadeCave | kShadeLamps};
  constexpr unsigned kShadowed[] = {0, kShadeShadows};
  return static_cast<unsigned>(variant & 1) | kShadowed[variant >> 1 & 1] | kLit[variant >> 2];
}

// first: ShaderVariant::terrain or ShaderVariant::screen.
constexpr ShaderVariant variant_for(ShaderVariant first, unsigned shading) {
  return static_cast<ShaderVariant>(static_cast<int>(first) + shading_variant(shading));
}
static_assert(kShadeBlend == 1);
static_assert(variant_for(ShaderVariant::terrain, kShadeAll) == ShaderVariant::terrain_blend_lamps_shadowed);
static_assert(variant_for(ShaderVariant::screen, kShadeCave) == ShaderVariant::screen_cave);

}  // namespace karst::core
