// SPDX-License-Identifier: MIT
// Which of the programs in variants.def draws patches that need a given shading.
#pragma once

#include <cstdint>

#include "gles_shaders/shader_texts.h"
#include "terrain/shading/shading.h"

namespace karst::core {

// shading: bits of Shading.
constexpr ShaderVariant terrain_variant(std::uint8_t shading) {
  using V = ShaderVariant;
  static_assert(kShadeBlend == 1 && kShadeCave == 2 && kShadeShadows == 4);
  constexpr V kVariants[kShadeAll + 1] = {V::terrain,
                                          V::terrain_blend,
                                          V::terrain_cave,
                                          V::terrain_blend_cave,
                                          V::terrain_shadowed,
                                          V::terrain_blend_shadowed,
                                          V::terrain_cave_shadowed,
                                          V::terrain_blend_cave_shadowed};
  return kVariants[shading & kShadeAll];
}

}  // namespace karst::core
