// SPDX-License-Identifier: MIT
// The materials' textures, their rules as a uniform block, and the noise between them.
#pragma once

#include <cstddef>
#include <span>

#include "karst/status.h"
#include "renderer/gl/gl_device.h"
#include "renderer/input/settings.h"
#include "renderer/input/shader_interface.h"
#include "terrain/shading/materials.h"
#include "terrain/shading/painted_texels.h"

namespace karst::core {

// The internal format of images.
GLenum gl_format(TextureFormat format);

// What stays the same for a world of this extent in voxels. materials.count 0: one material that is
// everywhere.
shader::MaterialBlock make_material_block(const MaterialSet& materials, glm::ivec3 extent = {1, 1, 1},
                                          const BlendSpan& span = {});

// ObjectRow::fill: what is seen where a world has no materials; and the noise.
Status fill_material_block(const Gl& gl, const RendererSettings& settings, const GlObjects& objects);
Status fill_far_textures(const Gl& gl, const RendererSettings& settings, const GlObjects& objects);
Status fill_near_textures(const Gl& gl, const RendererSettings& settings, const GlObjects& objects);
Status fill_variation(const Gl& gl, const RendererSettings& settings, const GlObjects& objects);

// Renderer::set_materials and upload_textures.
Status set_materials(const GlDevice& device, const RendererSettings& settings, const MaterialSet& materials);
Status upload_textures(const GlDevice& device, const RendererSettings& settings, TextureArray array,
                       int level, int first_layer, int layers, std::span<const std::byte> bytes);

// Renderer::upload_blend_texels and finish_blend_map.
Status upload_blend_texels(const GlDevice& device, const RendererSettings& settings, const TexelRect& texels,
                           std::span<const std::byte> bytes);
void finish_blend_map(const GlDevice& device);

}  // namespace karst::core
