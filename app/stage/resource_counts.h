// SPDX-License-Identifier: MIT
// Counts what must not happen once a scene is ready: heap calls of karst and new GL objects.
#pragma once

#include <cstdint>

#include "karst/types.h"

namespace karst::app {

// Calls of operator new on this thread so far. The program's operator new is replaced for it; drivers share
// it, so differences mean something only where no GL is called between.
std::uint64_t heap_calls();

// A loader whose functions that make and delete buffers, textures, framebuffers, renderbuffers, vertex
// arrays, queries, shaders and programs count what they do. One context a program is counted: the last one.
// loader is borrowed.
GlLoader counting_loader(const GlLoader& loader);
// Objects made through counting loaders, since the program began.
std::uint64_t gl_objects_made();
// Of them those that were not deleted. A lost context takes its objects with it.
std::uint64_t gl_objects_alive();
void gl_objects_lost();

// Files, sockets and the like that this process has open; 0 where the system does not tell.
std::uint64_t open_descriptors();

}  // namespace karst::app
