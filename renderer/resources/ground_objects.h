// SPDX-License-Identifier: MIT
// What is of the whole world: its sky visibility, the image that may be laid over it from above, image tiles,
// and the wall around it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "renderer/gl/gl_device.h"
#include "renderer/input/settings.h"
#include "terrain/field/sky_visibility.h"
#include "terrain/imagery/image_view.h"

namespace karst::core {

// ObjectRow::fill: open sky everywhere.
Status fill_sky(const Gl& gl, const RendererSettings& settings, const GlObjects& objects);

// Renderer::upload_sky and upload_drape.
Status upload_sky(const GlDevice& device, const RendererSettings& settings, const SkyVisibility& sky,
                  std::size_t place);
Status upload_drape(const GlDevice& device, const RendererSettings& settings,
                    std::span<const std::uint8_t> rgba);

// Renderer::upload_image and upload_image_table.
GLenum gl_format(ImageFormat format);
Status upload_image(const GlDevice& device, const RendererSettings& settings, std::uint32_t layer,
                    std::span<const std::byte> texels);
Status upload_image_table(const GlDevice& device, const RendererSettings& settings, std::uint32_t view,
                          int size, std::span<const std::uint16_t> part);

// The wall between a world's rim and the plain that it stands on (surroundings.h) is a strip, two vertices a
// point of the rim, below and on it, and the first point's once more at the end.
struct RimVertex {
  glm::ivec3 position{0};       // lattice steps from the octree's minimum corner
  std::int32_t normal_yaw = 0;  // of the wall, outwards: 2^16 a turn, from +x to +z
};
static_assert(sizeof(RimVertex) == 16);

// Of the buffer, for as many points as a world of this extent may have.
std::size_t rim_bytes(const RendererSettings& settings);

// rim: at most most_rim_points(); plain_steps: height of the plain. Returns how many vertices were written.
// invalid_argument ("rim") where there is no room.
Status upload_rim(const GlDevice& device, const RendererSettings& settings, std::span<const glm::ivec3> rim,
                  std::int32_t plain_steps, std::uint32_t& vertices);

}  // namespace karst::core
