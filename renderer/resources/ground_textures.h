// SPDX-License-Identifier: MIT
// Textures over the whole world: its sky visibility, and the image that may be laid over it from above.
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "renderer/gl/gl_device.h"
#include "renderer/input/settings.h"
#include "terrain/field/sky_visibility.h"

namespace karst::core {

// ObjectRow::fill: open sky everywhere.
Status fill_sky(const Gl& gl, const RendererSettings& settings, const GlObjects& objects);

// Renderer::upload_sky and upload_drape.
Status upload_sky(const GlDevice& device, const RendererSettings& settings, const SkyVisibility& sky);
Status upload_drape(const GlDevice& device, const RendererSettings& settings,
                    std::span<const std::uint8_t> rgba);

}  // namespace karst::core
