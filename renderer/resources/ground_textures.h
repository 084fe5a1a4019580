// SPDX-License-Identifier: MIT
// Textures over the whole world, seen from above: its sky-line and the image that may be laid over it.
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "renderer/gl/gl_device.h"
#include "renderer/input/settings.h"
#include "terrain/field/octree.h"

namespace karst::core {

// ObjectRow::fill: no cave anywhere.
Status fill_sky_line(const Gl& gl, const RendererSettings& settings, const GlObjects& objects);

// Renderer::upload_sky_line and upload_drape.
void upload_sky_line(const GlDevice& device, const RendererSettings& settings, const Octree& octree);
Status upload_drape(const GlDevice& device, const RendererSettings& settings,
                    std::span<const std::uint8_t> rgba);

}  // namespace karst::core
