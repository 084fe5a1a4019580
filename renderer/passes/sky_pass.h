// SPDX-License-Identifier: MIT
// The sky of a view, where nothing was drawn.
#pragma once

#include "renderer/gl/gl_device.h"
#include "renderer/input/view_input.h"
#include "renderer/passes/programs.h"

namespace karst::core {

// After draw_terrain(), where depth still is that of the far plane: 1, or 0 with reversed depth.
void draw_sky(const GlDevice& device, const Programs& programs, bool reversed_depth, FrameCounts& counts);

}  // namespace karst::core
