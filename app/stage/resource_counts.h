// SPDX-License-Identifier: MIT
// Counts what must not happen once a scene is ready: heap calls of karst and new GL objects.
#pragma once

#include <cstdint>

#include "karst/types.h"

namespace karst::app {

// Calls of operator new on this thread so far. The program's operator new is replaced for it; drivers share
// it, so differences mean something only where no GL is called between.
std::uint64_t heap_calls();

// A loader whose functions that make buffers, textures, framebuffers, renderbuffers, vertex arrays, shaders
// and programs count what they make. One context a program is counted: the last one. loader is borrowed.
GlLoader counting_loader(const GlLoader& loader);
// Objects made through counting loaders, since the program began.
std::uint64_t gl_objects_made();

}  // namespace karst::app
