// SPDX-License-Identifier: MIT
// The programs, one a line of variants.def, compiled when the renderer is created: never during a frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "gles_shaders/shader_texts.h"
#include "karst/status.h"
#include "renderer/gl/gl.h"

namespace karst::core {

struct ProgramSettings {
  int materials = 1;            // 1..kMostMaterials
  int detail = 2;               // KARST_DETAIL_...
  int anisotropy = 1;           // KARST_ANISOTROPY
  bool high_precision = false;  // all of a pixel in 32 bits
  bool drape = false;           // what is there is all that is needed of these
  bool deferred = false;
  bool water = false;            // the world has some
  bool curved = false;           // its ground lies on a curved basis
  bool blend_map = false;        // and one of these
  bool imagery = false;          // and images over it
  bool voxel_materials = false;  // meshes of isosurfaces have materials
  bool edges = false;            // the screen pass smooths silhouettes
  bool share_depth = false;      // and writes no depth: the G-buffer's is the target's
  bool shadows = false;
  bool cull_pixels = false;       // back faces are thrown away by pixels (gles_shaders/cull.glsl)
  std::uint32_t first_unit = 0;   // added to interface.glsl's texture units
  std::uint32_t first_block = 0;  // and to its binding points
  bool label = false;             // with KHR_debug
};

class Programs {
 public:
  // Compiles and links what the settings need and connects samplers and blocks to the units and bindings of
  // interface.glsl. On failure nothing is left, and log holds, zero-terminated and cut to fit, the program's
  // name, its stage and what the driver said about it.
  Status create(const Gl& gl, const ProgramSettings& settings, std::span<char> log);
  void destroy(const Gl& gl);
  // The context is gone, and the programs with it.
  void forget();

  GLuint operator[](ShaderVariant variant) const { return programs_[static_cast<std::size_t>(variant)]; }
  // Location of show_levels' uniform.
  GLint shown_level() const { return shown_level_; }

 private:
  Status link_all(const Gl& gl, const ProgramSettings& settings, std::span<char> log);

  GLuint programs_[kShaderVariants] = {};
  GLint shown_level_ = -1;
  char defines_[384] = {};  // GLSL lines after the variant's macros
};

}  // namespace karst::core
