// SPDX-License-Identifier: MIT
// Passes into the shadow maps: one texture array, a layer a cascade. Both sides of the surface are drawn,
// because a world is open at its sides and below: light that comes in there must not pass through the ground
// from within.
#pragma once

#include "karst/status.h"
#include "renderer/gl/gl_device.h"
#include "renderer/input/settings.h"
#include "renderer/input/view_input.h"
#include "renderer/passes/programs.h"

namespace karst::core {

// index: one of the settings' cascades. Leaves the map bound, and state to be reset.
Status draw_shadow_map(const GlDevice& device, const RendererSettings& settings, const Programs& programs,
                       int index, const CascadeInput& input, FrameCounts& counts);

}  // namespace karst::core
