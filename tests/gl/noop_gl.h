// SPDX-License-Identifier: MIT
// A driver that draws nothing and counts: GL objects, their bytes, and calls. With it, everything that a
// frame allocates is karst's own, or the host's that draws into a target.
#pragma once

#include <cstdint>

#include "renderer/gl/gl.h"

namespace karst::test {
using namespace core;

struct NoopGl {
  std::uint64_t objects_made = 0;
  std::uint64_t objects_deleted = 0;
  std::uint64_t object_bytes = 0;  // of buffers, textures and renderbuffers as they were specified
  std::uint64_t draws = 0;
  std::uint64_t questions = 0;        // calls of glGet..., glIs... and glCheck...
  std::uint64_t uploads_bytes = 0;    // BufferSubData, and ranges flushed
  std::uint64_t texture_uploads = 0;  // TexSubImage2D
  std::uint64_t fences = 0;           // made and not deleted
  std::uint64_t most_fences = 0;
  std::uint64_t waits = 0;
  std::uint64_t mapped = 0;  // buffers mapped and not unmapped

  // What a driver may say; tests change it.
  const char* version = "OpenGL ES 3.0 no-op";
  std::int32_t max_texture_size = 2048;
  std::int32_t max_renderbuffer_size = 2048;
  std::int64_t max_element_index = (1 << 24) - 1;
  // KHR_debug, EXT_disjoint_timer_query and EXT_texture_filter_anisotropic
  bool extensions = true;
  std::int32_t max_anisotropy = 16;
  std::int32_t anisotropy = 0;             // the highest that a texture was given
  std::uint32_t anisotropic_textures = 0;  // how many were given one
  bool loses_vertices = false;             // says so when the vertex buffer is unmapped
  bool compiles = true;
  bool framebuffers_complete = true;
  std::uint32_t error = 0;     // what GetError gives, once
  bool out_of_memory = false;  // says so when a buffer gets its memory

  // The one that the functions below count into.
  static NoopGl& get();
  // Counts from zero, as a driver of the least that ES 3.0 allows.
  static Gl reset();
  // Of the same functions, and of those that draw into a target.
  static GlLoader loader();
};

}  // namespace karst::test
