// SPDX-License-Identifier: MIT
// Indices of what is drawn, written anew for each pass.
#pragma once

#include "karst/status.h"
#include "renderer/gl/gl_device.h"
#include "renderer/input/frame_counts.h"
#include "terrain/draw/expand_indices.h"

namespace karst::core {

// Draws the items with the program in use, in as many calls as the stream is too short for; counts what it
// did. expand.out is filled in here. invalid_argument names what is wrong with the items; limit_reached where
// the driver cannot map the stream.
Status draw_items(const GlDevice& device, ExpandIndices expand, int max_level, FrameCounts& counts);

}  // namespace karst::core
