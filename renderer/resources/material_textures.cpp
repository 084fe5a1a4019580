// SPDX-License-Identifier: MIT
// The materials' textures, their rules as a uniform block, and the noise between them.
#include <algorithm>

#include "renderer/renderer.h"
#include "renderer/resources/variation_texture.h"

namespace karst::core {
namespace {

Status invalid(const char* what, const char* field, std::uint64_t value = 0) {
  return {StatusCode::invalid_argument, what, field, value};
}

// Albedo is sRGB, which the shader decodes (materials.glsl): once for all planes instead of at each of a
// lookup's eight texels, where llvmpipe spends most of a frame.
GLenum texture_format(TextureFormat format) {
  return format == TextureFormat::etc2 ? GL_COMPRESSED_RGBA8_ETC2_EAC : GL_RGBA8;
}

GLenum texture_unit(TextureArray array) {
  return GL_TEXTURE0 +
         (array == TextureArray::albedo_height ? KARST_UNIT_ALBEDO_HEIGHT : KARST_UNIT_NORMAL_ROUGHNESS);
}

constexpr TextureArray kArrays[kTextureArrays] = {TextureArray::albedo_height,
                                                  TextureArray::normal_roughness};

}  // namespace

void Renderer::create_materials() {
  const bool plain = settings_.material_count == 0;
  const auto set = [&](GLenum target, GLenum name, GLenum value) {
    gl_.TexParameteri(target, name, static_cast<GLint>(value));
  };
  for (const TextureArray array : kArrays) {
    GLuint& texture = material_arrays_[static_cast<std::size_t>(array)];
    gl_.GenTextures(1, &texture);
    gl_.ActiveTexture(texture_unit(array));
    gl_.BindTexture(GL_TEXTURE_2D_ARRAY, texture);
    const GLsizei side = plain ? 1 : static_cast<GLsizei>(settings_.material_side);
    gl_.TexStorage3D(GL_TEXTURE_2D_ARRAY, plain ? 1 : texture_levels(settings_.material_side),
                     plain ? texture_format(TextureFormat::rgba8) : texture_format(settings_.material_format),
                     side, side, plain ? 1 : static_cast<GLsizei>(settings_.material_count));
    set(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    set(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    set(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_S, GL_REPEAT);
    set(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_T, GL_REPEAT);
    if (!plain) continue;
    // Pale stone, level and rough.
    constexpr std::uint8_t kStone[4] = {148, 140, 128, 128};
    constexpr std::uint8_t kLevel[4] = {230, 128, 230, 128};
    gl_.TexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, 1, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE,
                      array == TextureArray::albedo_height ? kStone : kLevel);
  }
  gl_.GenBuffers(1, &material_buffer_);
  gl_.BindBuffer(GL_UNIFORM_BUFFER, material_buffer_);
  const shader::MaterialBlock block = make_material_block(MaterialSet());
  gl_.BufferData(GL_UNIFORM_BUFFER, sizeof block, &block, GL_STATIC_DRAW);
  gl_.BindBufferBase(GL_UNIFORM_BUFFER, KARST_BINDING_MATERIALS, material_buffer_);

  gl_.GenTextures(1, &variation_);
  gl_.ActiveTexture(GL_TEXTURE0 + KARST_UNIT_VARIATION);
  gl_.BindTexture(GL_TEXTURE_3D, variation_);
  gl_.TexStorage3D(GL_TEXTURE_3D, 1, GL_R8, kVariationSide, kVariationSide, kVariationSide);
  set(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  set(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  set(GL_TEXTURE_3D, GL_TEXTURE_WRAP_S, GL_REPEAT);
  set(GL_TEXTURE_3D, GL_TEXTURE_WRAP_T, GL_REPEAT);
  set(GL_TEXTURE_3D, GL_TEXTURE_WRAP_R, GL_REPEAT);
  // One material has no borders: what the texture holds is never seen.
  if (plain) return;
  std::uint8_t layer[kVariationSide * kVariationSide];
  for (int z = 0; z < kVariationSide; ++z) {
    variation_layer(z, layer);
    gl_.TexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, z, kVariationSide, kVariationSide, 1, GL_RED, GL_UNSIGNED_BYTE,
                      layer);
  }
}

Status Renderer::set_materials(const MaterialSet& materials) {
  if (materials.count != settings_.material_count) {
    return invalid("not the settings' material_count", "materials", materials.count);
  }
  if (materials.count > 0 &&
      (materials.side != settings_.material_side || materials.format != settings_.material_format)) {
    return invalid("not the settings' material_side and material_format", "materials", materials.side);
  }
  const shader::MaterialBlock block = make_material_block(materials);
  gl_.BindBuffer(GL_UNIFORM_BUFFER, material_buffer_);
  gl_.BufferSubData(GL_UNIFORM_BUFFER, 0, sizeof block, &block);
  return {};
}

Status Renderer::upload_textures(TextureArray array, int level, int first_layer, int layers,
                                 std::span<const std::byte> bytes) {
  if (level < 0 || level >= texture_levels(settings_.material_side)) return invalid("not a level", "level");
  const auto count = static_cast<int>(settings_.material_count);
  if (first_layer < 0 || layers < 1 || first_layer > count - layers) return invalid("not layers", "layers");
  const std::size_t needed = texture_image_bytes(settings_.material_format, settings_.material_side, level) *
                             static_cast<std::size_t>(layers);
  if (bytes.size() != needed) return invalid("of another size than the layers", "bytes", bytes.size());
  gl_.ActiveTexture(texture_unit(array));
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
  const auto side = static_cast<GLsizei>(settings_.material_side >> level);
  if (settings_.material_format == TextureFormat::etc2) {
    gl_.CompressedTexSubImage3D(GL_TEXTURE_2D_ARRAY, level, 0, 0, first_layer, side, side, layers,
                                texture_format(settings_.material_format), static_cast<GLsizei>(needed),
                                bytes.data());
  } else {
    gl_.TexSubImage3D(GL_TEXTURE_2D_ARRAY, level, 0, 0, first_layer, side, side, layers, GL_RGBA,
                      GL_UNSIGNED_BYTE, bytes.data());
  }
  return {};
}

}  // namespace karst::core
