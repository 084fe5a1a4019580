// SPDX-License-Identifier: MIT
// Shades what the G-buffer holds, into the framebuffer of a view.
#pragma once

#include "renderer/gl/gl_device.h"
#include "renderer/input/view_input.h"
#include "renderer/passes/programs.h"

namespace karst::core {

// What screen.frag needs to know of the view in the target.
void set_screen(const ViewInput& input, const DrawTarget& target, shader::FrameBlock& block);

// After draw_geometry(), with the target's framebuffer bound; counts what it did.
void draw_screen(const GlDevice& device, const RendererSettings& settings, const Programs& programs,
                 const ViewInput& input, const DrawTarget& target, FrameCounts& counts);

}  // namespace karst::core
