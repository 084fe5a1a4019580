// SPDX-License-Identifier: MIT
// Counts what must not happen once a scene is ready: heap calls of the core and new GL objects.
#pragma once

#include <cstdint>

#include "renderer/gl/gl.h"

namespace karst::app {
using namespace core;

// Counts calls of operator new while it lives, on its thread. The program's operator new is replaced for it;
// drivers share it, so it is not to live while GL is called.
class HeapCount {
 public:
  // total: grows by what is counted.
  explicit HeapCount(std::uint64_t& total);
  HeapCount(const HeapCount&) = delete;
  HeapCount& operator=(const HeapCount&) = delete;
  ~HeapCount();

 private:
  std::uint64_t& total_;
  std::uint64_t before_;
};

// Replaces the functions that make buffers, textures, framebuffers, renderbuffers, vertex arrays, shaders,
// programs and queries by ones that count. One context a program is counted: the last one.
void count_gl_objects(Gl& gl);
// Objects made through tables that were given to count_gl_objects, since the program began.
std::uint64_t gl_objects_made();

}  // namespace karst::app
