// SPDX-License-Identifier: MIT
// What is around the ground in a view: the wall between its rim and the plain, and the sky.
#pragma once

#include <cstdint>

#include "renderer/gl/gl_device.h"
#include "renderer/input/settings.h"
#include "renderer/input/view_input.h"
#include "renderer/passes/programs.h"

namespace karst::core {

// Whether the wall may be seen: by an eye outside of the world. vertices: of Object::rim.
bool sees_edge(const RendererSettings& settings, const ViewInput& input, std::uint32_t vertices);

// The wall, with the state of the terrain's pass. variant: one of ShaderVariant::edge and those after it.
void draw_edge(const GlDevice& device, const Programs& programs, ShaderVariant variant,
               std::uint32_t vertices, FrameCounts& counts);

// After all else, where depth still is that of the far plane: 1, or 0 with reversed depth.
void draw_sky(const GlDevice& device, const Programs& programs, bool reversed_depth, FrameCounts& counts);

}  // namespace karst::core
