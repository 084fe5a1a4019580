// SPDX-License-Identifier: MIT
// The terrain of a view: its materials, an image over it, or how the picture is made.
#pragma once

#include "karst/status.h"
#include "renderer/gl/gl_device.h"
#include "renderer/input/settings.h"
#include "renderer/input/view_input.h"
#include "renderer/passes/programs.h"
#include "terrain/view/depth_ranges.h"

namespace karst::core {

// What the shaders need to know of the view in the target.
shader::FrameBlock make_view_block(const RendererSettings& settings, const ViewInput& input,
                                   const DrawTarget& target);
// How many ranges its depth has, 1 or 2.
DepthRanges ranges_of(const ViewInput& input, const DrawTarget& target);
// For drawing what lies in one of two: the block, bound, and where depth goes. Returns what may be in it.
ViewInput enter_range(const GlDevice& device, const DepthRanges& ranges, int range, const ViewInput& input,
                      shader::FrameBlock block);
// Depth goes everywhere again.
void leave_ranges(const GlDevice& device);

// Bits of Shading: what any pixel of the view needs.
unsigned frame_shading(const ViewInput& input);

// Clears the G-buffer, which is bound.
void clear_geometry(const GlDevice& device, const ViewInput& input);
// Draws the terrain into it, with the state, the block and the textures that are set; counts what it did.
// invalid_argument names what is wrong with the items.
Status draw_geometry(const GlDevice& device, const RendererSettings& settings, const Programs& programs,
                     const ViewInput& input, FrameCounts& counts);

// Draws with the state, the block and the textures that are set; counts what it did. invalid_argument names
// what is wrong with the items.
Status draw_terrain(const GlDevice& device, const RendererSettings& settings, const Programs& programs,
                    const ViewInput& input, const DrawTarget& target, FrameCounts& counts);

}  // namespace karst::core
