// SPDX-License-Identifier: MIT
#include "renderer/resources/material_textures.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "renderer/gl/gl_state.h"
#include "renderer/resources/object_table.h"
#include "renderer/resources/variation_texture.h"

namespace karst::core {
namespace {

Status invalid(const char* what, const char* field, std::uint64_t value = 0) {
  return {StatusCode::invalid_argument, what, field, value};
}

// smoothstep(low - soft, low + soft, v) and 1 - smoothstep(high - soft, high + soft, v), before smoothing.
// last: what shares a number with them.
glm::vec4 limits(float low, float high, float soft, float last) {
  const float factor = 0.5f / soft;
  return {factor, 0.5f - low * factor, 0.5f + high * factor, last};
}

// Scales beyond the first two: as long as a repeat is not much wider than the world.
int more_scales(int repeat_log2, glm::ivec3 extent) {
  const auto most = static_cast<unsigned>(std::max({extent.x, extent.y, extent.z}));
  const int widest = static_cast<int>(std::bit_width(most));
  return std::max(0, (widest - repeat_log2) / KARST_SCALE_LOG2 - 1);
}

// How much the normal's y counts for what plane is looked up. A material that no level ground has is one of
// walls, whose images have a top and a bottom: the level plane, which knows neither, is left to its ceilings.
// So it has no share up to 35 degrees from upright, and half of one at 70.
float level_share(const Material& material) {
  constexpr float kLevelGround = 0.75f;
  return material.slope_high > kLevelGround ? 1.0f : 0.35f;
}

// What a near texel, 0..1, stands for: factors and offsets.
glm::vec4 near_decoding(TextureFormat format, const Material& material) {
  const NearCodes codes = near_codes(format);
  const float factor = static_cast<float>(codes.most) / static_cast<float>(codes.steps);
  const float offset = static_cast<float>(codes.middle) / static_cast<float>(codes.steps);
  return {material.brightness_span * factor, 1.0f - material.brightness_span * offset,
          material.slope_span * factor, -material.slope_span * offset};
}

// What stands for materials where there are none: pale stone, level and rough. sRGB and roughness; and the
// same as materials' averages are, as the shader decodes it (decode_albedo()).
constexpr std::uint8_t kPlain[4] = {148, 140, 128, 230};
glm::vec4 plain_average() {
  glm::vec4 average;
  for (int c = 0; c < 3; ++c) {
    const float s = static_cast<float>(kPlain[c]) / 255.0f;
    average[c] = s * (s * (s * 0.305306011f + 0.682171111f) + 0.012522878f);
  }
  average.w = static_cast<float>(kPlain[3]) / 255.0f;
  return average;
}

Status fill_plain(const Gl& gl, const RendererSettings& settings, const std::uint8_t (&texel)[4]) {
  if (settings.material_count > 0) return {};
  gl.TexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, 1, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, texel);
  return {};
}

}  // namespace

// Albedo is sRGB, which the shader decodes (materials.glsl): once for all planes instead of at each of a
// lookup's eight texels, where llvmpipe spends most of a frame.
GLenum gl_format(TextureFormat format) {
  switch (format) {
    case TextureFormat::etc2:
      return GL_COMPRESSED_RGBA8_ETC2_EAC;
    case TextureFormat::rgba4:
      return GL_RGBA4;
    case TextureFormat::rgba8:
      break;
  }
  return GL_RGBA8;
}

shader::MaterialBlock make_material_block(const MaterialSet& materials, glm::ivec3 extent,
                                          const BlendSpan& span) {
  shader::MaterialBlock block{};
  const float levels = materials.count == 0 ? 0.0f : std::log2(static_cast<float>(materials.side));
  block.material_scale = {std::exp2(-levels), levels - static_cast<float>(materials.repeat_log2), 0.0f, 0.0f};
  block.material_repeat = {materials.repeat_log2, more_scales(materials.repeat_log2, extent), 0, 0};
  block.material_average[0] = plain_average();
  block.material_tint[0] = {1.0f, 1.0f, 1.0f, 1.0f};
  block.material_near[0] = near_decoding(TextureFormat::rgba8, Material());
  const BlendMap& map = materials.blend_map;
  const glm::vec2 place = 1.0f / glm::vec2(span.size), low = glm::vec2(span.low);
  block.material_blend_place = {place.x, place.y, -low.x * place.x, -low.y * place.y};
  if (map.exists()) {
    block.material_scale.z =
        std::log2(std::max(static_cast<float>(map.width) * place.x, static_cast<float>(map.depth) * place.y));
  }
  for (int channel = 0; channel < 4; ++channel) {
    const std::uint8_t material = map.materials[channel];
    if (material != 0) block.material_blend[material - 1][channel] = 1.0f;
  }
  for (std::uint32_t m = 0; m < materials.count; ++m) {
    const Material& material = materials.materials[m];
    // Noise moves a limit by fray times soft, which is half of the way through it.
    block.material_slope[m] =
        limits(material.slope_low, material.slope_high, material.slope_soft, 0.5f * material.fray);
    block.material_height[m] =
        limits(material.height_low, material.height_high, material.height_soft, material.cave);
    block.material_average[m] = {material.average[0], material.average[1], material.average[2],
                                 material.roughness};
    block.material_tint[m] = {material.tint[0], material.tint[1], material.tint[2], level_share(material)};
    block.material_near[m] = near_decoding(texture_format(materials.format, TextureArray::near), material);
  }
  return block;
}

Status fill_material_block(const Gl& gl, const RendererSettings& /*settings*/, const GlObjects& /*objects*/) {
  const shader::MaterialBlock block = make_material_block(MaterialSet());
  gl.BufferSubData(GL_ARRAY_BUFFER, 0, sizeof block, &block);
  return {};
}

Status fill_far_textures(const Gl& gl, const RendererSettings& settings, const GlObjects& /*objects*/) {
  return fill_plain(gl, settings, kPlain);
}
Status fill_near_textures(const Gl& gl, const RendererSettings& settings, const GlObjects& /*objects*/) {
  return fill_plain(gl, settings, {128, 128, 128, 128});
}

Status fill_variation(const Gl& gl, const RendererSettings& settings, const GlObjects& /*objects*/) {
  // One material has no borders: what the texture holds is never seen.
  if (settings.material_count == 0) return {};
  std::uint8_t layer[kVariationSide * kVariationSide];
  for (int z = 0; z < kVariationSide; ++z) {
    variation_layer(z, layer);
    gl.TexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, z, kVariationSide, kVariationSide, 1, GL_RED, GL_UNSIGNED_BYTE,
                     layer);
  }
  return {};
}

Status set_materials(const GlDevice& device, const RendererSettings& settings, const MaterialSet& materials) {
  if (materials.count != settings.material_count) {
    return invalid("not the settings' material_count", "materials", materials.count);
  }
  if (materials.count > 0 &&
      (materials.side != settings.material_side || materials.format != settings.material_format)) {
    return invalid("not the settings' material_side and material_format", "materials", materials.side);
  }
  if (materials.blend_map.width != settings.blend_width || materials.blend_map.depth != settings.blend_depth)
    return invalid("not the settings' blend_width and blend_depth", "materials", materials.blend_map.width);
  const shader::MaterialBlock block = make_material_block(materials, settings.extent, settings.blend_span);
  device.gl.BindBuffer(GL_UNIFORM_BUFFER, name_of(device, Object::material_block));
  device.gl.BufferSubData(GL_UNIFORM_BUFFER, 0, sizeof block, &block);
  device.gl.BindBuffer(GL_UNIFORM_BUFFER, 0);
  return {};
}

Status upload_textures(const GlDevice& device, const RendererSettings& settings, TextureArray array,
                       int level, int first_layer, int layers, std::span<const std::byte> bytes) {
  if (level < 0 || level >= texture_levels(settings.material_side, array))
    return invalid("not a level", "level");
  const auto count = static_cast<int>(settings.material_count);
  if (first_layer < 0 || layers < 1 || first_layer > count - layers) return invalid("not layers", "layers");
  const std::size_t needed =
      texture_image_bytes(settings.material_format, settings.material_side, array, level) *
      static_cast<std::size_t>(layers);
  if (bytes.size() != needed) return invalid("of another size than the layers", "bytes", bytes.size());
  const Gl& gl = device.gl;
  enter_upload(device);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY,
                 name_of(device, array == TextureArray::far ? Object::far_textures : Object::near_textures));
  const auto side = static_cast<GLsizei>(texture_side(settings.material_side, array) >> level);
  const TextureFormat format = texture_format(settings.material_format, array);
  if (format == TextureFormat::etc2) {
    gl.CompressedTexSubImage3D(GL_TEXTURE_2D_ARRAY, level, 0, 0, first_layer, side, side, layers,
                               gl_format(format), static_cast<GLsizei>(needed), bytes.data());
  } else {
    const bool small = format == TextureFormat::rgba4;
    // Images of one texel have no gaps between them.
    if (small) gl.PixelStorei(GL_UNPACK_ALIGNMENT, 2);
    gl.TexSubImage3D(GL_TEXTURE_2D_ARRAY, level, 0, 0, first_layer, side, side, layers, GL_RGBA,
                     small ? GL_UNSIGNED_SHORT_4_4_4_4 : GL_UNSIGNED_BYTE, bytes.data());
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
  }
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, 0);
  leave_upload(device);
  return {};
}

Status upload_blend_texels(const GlDevice& device, const RendererSettings& settings, const TexelRect& texels,
                           std::span<const std::byte> bytes) {
  if (!texels.exists() || texels.high.x > settings.blend_width || texels.high.y > settings.blend_depth)
    return invalid("not of the map", "texels");
  const glm::uvec2 size = texels.high - texels.low;
  if (bytes.size() != std::size_t{size.x} * size.y * kBlendTexelBytes)
    return invalid("of another size than the texels", "bytes", bytes.size());
  enter_upload(device);
  device.gl.BindTexture(GL_TEXTURE_2D, name_of(device, Object::blend_map));
  device.gl.TexSubImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(texels.low.x),
                          static_cast<GLint>(texels.low.y), static_cast<GLsizei>(size.x),
                          static_cast<GLsizei>(size.y), GL_RGBA, GL_UNSIGNED_BYTE, bytes.data());
  device.gl.BindTexture(GL_TEXTURE_2D, 0);
  leave_upload(device);
  return {};
}

void finish_blend_map(const GlDevice& device) {
  enter_upload(device);
  device.gl.BindTexture(GL_TEXTURE_2D, name_of(device, Object::blend_map));
  device.gl.GenerateMipmap(GL_TEXTURE_2D);
  device.gl.BindTexture(GL_TEXTURE_2D, 0);
  leave_upload(device);
}

}  // namespace karst::core
