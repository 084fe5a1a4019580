// SPDX-License-Identifier: MIT
// All buffers, textures, vertex arrays and framebuffers of the renderer, each once; and which texture unit
// each texture is looked up in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "renderer/gl/gl_device.h"
#include "renderer/input/settings.h"

namespace karst::core {

enum class Object : std::uint8_t {
  vertices,
  stream_indices,
  rim,
  frame_block,
  material_block,
  cascade_block_0,
  cascade_block_1,
  cascade_block_2,
  air_block_0,  // to air_block_0 + RendererSettings::kMostAirBlocks - 1
  page_table = air_block_0 + RendererSettings::kMostAirBlocks,
  morph_entries,
  morph_rows,
  far_textures,
  near_textures,
  variation,
  sky_visibility,
  blend_map,
  image_tiles,
  image_table,
  drape,
  shadow_maps,
  geometry,         // the G-buffer, gles_shaders/geometry.glsl
  geometry_depth,   // and its depth
  geometry_voxels,  // and materials of voxels (gles_shaders/voxel_materials.glsl)
  terrain_array,
  rim_array,
  no_attributes,  // vertex array of full-screen passes
  shadow_target_0,
  shadow_target_1,
  shadow_target_2,
  geometry_target,
  count
};

constexpr std::size_t row_of(Object object) {
  return static_cast<std::size_t>(object);
}
// The n-th of objects that stand side by side.
constexpr Object nth(Object first, int n) {
  return static_cast<Object>(static_cast<int>(first) + n);
}
inline GLuint name_of(const GlDevice& device, Object object) {
  return device.objects[row_of(object)];
}

// By Object.
std::span<const ObjectRow> object_rows();

// Binds all textures to their units, and no samplers; or nothing. Afterwards texture unit 0 is active.
void bind_textures(const GlDevice& device);
void unbind_textures(const GlDevice& device);

// Binds a uniform block to the settings' binding point for it, KARST_BINDING_..., and writes it unless it is
// empty.
void use_block(const GlDevice& device, Object buffer, GLuint binding, std::span<const std::byte> block);
template <class Block>
std::span<const std::byte> as_bytes(const Block& block) {
  return std::as_bytes(std::span(&block, 1));
}

}  // namespace karst::core
