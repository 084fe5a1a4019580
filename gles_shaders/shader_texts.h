// SPDX-License-Identifier: MIT
// The shaders, embedded in the program: one entry a line of variants.def, in its order.
#pragma once

#include <cstddef>

namespace karst::core {

enum class ShaderVariant {
#define KARST_VARIANT(name, vertex, fragment, macros) name,
#include "gles_shaders/variants.def"
#undef KARST_VARIANT
  count
};

inline constexpr std::size_t kShaderVariants = static_cast<std::size_t>(ShaderVariant::count);

struct ShaderText {
  const char* name;     // as in variants.def
  const char* defines;  // lines that define the variant's macros; they go after the version line
  const char* vertex;   // beginning with its #version line
  const char* fragment;
};

extern const ShaderText kShaderTexts[kShaderVariants];

// Functions for shaders that are not karst's (air.glsl), without a version line.
extern const char* const kAirText;

}  // namespace karst::core
