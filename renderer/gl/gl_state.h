// SPDX-License-Identifier: MIT
// The state contract with a host, in whose context karst is a guest: what GL's state is on entry does not
// matter, and what karst changes is left behind as GL has it initially (renderer.h lists it). Nothing here
// asks GL what its state is.
#pragma once

#include "karst/types.h"
#include "renderer/gl/gl_device.h"

namespace karst::core {

struct DrawState {
  Rect viewport;
  bool cull = true;       // back faces
  bool mirrored = false;  // front faces are clockwise
  GLenum depth_func = GL_LESS;
  bool depth_writes = true;
  bool colour_writes = true;
  bool depth_zero_to_one = false;  // clip space's depth; needs caps.clip_control
  bool linear = false;             // colours are light: an sRGB framebuffer encodes them
};

// All state that a draw call or a clear depends on; depth is tested, and what DrawState does not say is off.
void enter_draw(const GlDevice& device, const DrawState& state);
// All state that enter_draw() and enter_upload() set, as it is initially, but for the viewport. Program,
// vertex array, array, uniform and pixel unpack buffers and karst's uniform blocks are unbound; active is
// texture unit 0.
void reset_state(const GlDevice& device);

// How texels are read from memory, as it is initially: rows of whole 4 bytes, no pixel unpack buffer. Active
// is the first of karst's texture units, until leave_upload().
void enter_upload(const GlDevice& device);
void leave_upload(const GlDevice& device);

}  // namespace karst::core
