// SPDX-License-Identifier: MIT
// What all parts of the renderer share: the functions, what the device can do, the objects, and which texture
// units and uniform blocks of the host's context are karst's.
#pragma once

#include <cstdint>

#include "renderer/gl/gl.h"
#include "renderer/gl/gl_caps.h"
#include "renderer/gl/gl_objects.h"

namespace karst::core {

struct GlDevice {
  Gl gl;
  GlCaps caps;
  GlObjects objects;
  std::uint32_t first_unit = 0;
  std::uint32_t first_block = 0;

  // For debuggers that show calls.
  void push_group(const char* name) const {
    if (caps.debug) gl.PushDebugGroupKHR(GL_DEBUG_SOURCE_APPLICATION_KHR, 0, -1, name);
  }
  void pop_group() const {
    if (caps.debug) gl.PopDebugGroupKHR();
  }
};

}  // namespace karst::core
