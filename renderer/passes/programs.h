// SPDX-License-Identifier: MIT
// All programs, one a line of variants.def, compiled when the renderer is created: never during a frame.
#pragma once

#include <cstddef>
#include <span>

#include "gles_shaders/shader_texts.h"
#include "karst/status.h"
#include "renderer/gl/gl.h"

namespace karst::core {

struct ProgramSettings {
  int materials = 1;            // 1..kMostMaterials
  bool high_precision = false;  // all of a pixel in 32 bits
};

class Programs {
 public:
  // Compiles and links everything and connects samplers and blocks to the units and bindings of
  // interface.glsl. On failure nothing is left, and log holds, zero-terminated and cut to fit, the program's
  // name, its stage and what the driver said about it.
  Status create(const Gl& gl, const ProgramSettings& settings, std::span<char> log);
  void destroy(const Gl& gl);

  GLuint operator[](ShaderVariant variant) const { return programs_[static_cast<std::size_t>(variant)]; }

 private:
  Status link_all(const Gl& gl, std::span<char> log);

  GLuint programs_[kShaderVariants] = {};
  char defines_[80] = {};  // GLSL lines after the version
};

}  // namespace karst::core
