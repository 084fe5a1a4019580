// SPDX-License-Identifier: MIT
#include "renderer/resources/object_table.h"

#include <algorithm>
#include <bit>

#include "renderer/resources/ground_objects.h"
#include "renderer/resources/material_textures.h"
#include "renderer/resources/variation_texture.h"
#include "renderer/resources/vertex_pages.h"
#include "terrain/lod/morph.h"

namespace karst::core {
namespace {

using Settings = RendererSettings;

ObjectShape buffer(std::size_t bytes, GLenum usage) {
  return {.wanted = bytes > 0, .bytes = bytes, .usage = usage};
}

ObjectShape image(GLenum format, int width, int height, GLenum filter = GL_NEAREST) {
  return {.wanted = width > 0,
          .format = format,
          .width = width,
          .height = height,
          .min_filter = filter,
          .mag_filter = filter};
}

ObjectShape nothing_but_a_name(bool wanted) {
  return {.wanted = wanted};
}

template <int n>
ObjectShape cascade_block(const Settings& s) {
  return buffer(n < s.cascades ? sizeof(shader::FrameBlock) : 0, GL_DYNAMIC_DRAW);
}

template <int n>
ObjectShape air_block(const Settings& s) {
  return buffer(n < s.air_blocks ? sizeof(shader::KarstAir) : 0, GL_DYNAMIC_DRAW);
}

template <int n>
ObjectShape shadow_target(const Settings& s) {
  return nothing_but_a_name(n < s.cascades);
}

ObjectShape drape(const Settings& s) {
  ObjectShape shape = image(GL_RGBA8, s.drape_width, s.drape_height, GL_LINEAR);
  shape.levels =
      static_cast<int>(std::bit_width(static_cast<unsigned>(std::max(s.drape_width, s.drape_height))));
  // One level a pixel: half the texels of trilinear filtering.
  shape.min_filter = GL_LINEAR_MIPMAP_NEAREST;
  shape.wrap = GL_REPEAT;
  shape.anisotropy = s.anisotropy;
  return shape;
}

template <TextureArray array>
ObjectShape materials(const Settings& s) {
  const bool plain = s.material_count == 0;
  const int side = plain ? 1 : static_cast<int>(texture_side(s.material_side, array));
  return {.target = GL_TEXTURE_2D_ARRAY,
          .format = gl_format(plain ? TextureFormat::rgba8 : texture_format(s.material_format, array)),
          .levels = plain ? 1 : texture_levels(s.material_side, array),
          .width = side,
          .height = side,
          .depth = plain ? 1 : static_cast<int>(s.material_count),
          .min_filter = GL_LINEAR_MIPMAP_LINEAR,
          .mag_filter = GL_LINEAR,
          .wrap = GL_REPEAT,
          .anisotropy = s.anisotropy};
}

ObjectShape variation(const Settings& /*settings*/) {
  return {.target = GL_TEXTURE_3D,
          .format = GL_R8,
          .width = kVariationSide,
          .height = kVariationSide,
          .depth = kVariationSide,
          .min_filter = GL_LINEAR,
          .mag_filter = GL_LINEAR,
          .wrap = GL_REPEAT};
}

ObjectShape blend_map(const Settings& s) {
  ObjectShape shape =
      image(GL_RGBA8, static_cast<int>(s.blend_width), static_cast<int>(s.blend_depth), GL_LINEAR);
  shape.levels =
      std::min(kMostBlendLevels, static_cast<int>(std::bit_width(std::max(s.blend_width, s.blend_depth))));
  shape.min_filter = GL_LINEAR_MIPMAP_NEAREST;  // weights are smooth: a level is as good as two
  shape.anisotropy = s.anisotropy;
  return shape;
}

ObjectShape image_tiles(const Settings& s) {
  return {.wanted = s.image_layers > 0,
          .target = GL_TEXTURE_2D_ARRAY,
          .format = gl_format(s.image_format),
          .levels = kImageLevels,
          .width = kImageSide,
          .height = kImageSide,
          .depth = static_cast<int>(s.image_layers),
          .min_filter = GL_LINEAR_MIPMAP_LINEAR,
          .mag_filter = GL_LINEAR};
}

ObjectShape image_table(const Settings& s) {
  return image(GL_R16UI, kImageWindow * static_cast<int>(s.image_views), kImageWindow * kImageSizes);
}

ObjectShape sky_visibility(const Settings& s) {
  return {.target = GL_TEXTURE_3D,
          .format = GL_R8,
          .width = s.sky.cells.x,
          .height = s.sky.cells.z,
          .depth = s.sky.cells.y,
          .min_filter = GL_LINEAR,
          .mag_filter = GL_LINEAR};
}

// Linear: the hardware mixes the results of four comparisons.
ObjectShape shadow_maps(const Settings& s) {
  return {.wanted = s.cascades > 0,
          .target = GL_TEXTURE_2D_ARRAY,
          .format = s.shadow_bits == 16 ? GLenum{GL_DEPTH_COMPONENT16} : GLenum{GL_DEPTH_COMPONENT24},
          .width = s.shadow_size,
          .height = s.shadow_size,
          .depth = s.cascades,
          .min_filter = GL_LINEAR,
          .mag_filter = GL_LINEAR,
          .compare = true};
}

ObjectShape geometry(const Settings& s, GLenum format) {
  ObjectShape shape = image(format, s.deferred_width, s.deferred_height);
  shape.wanted = s.deferred();
  return shape;
}

Status fill_entries(const Gl& gl, const Settings& /*settings*/, const GlObjects& /*objects*/) {
  std::uint8_t entries[kEntryRowTexels * kEntryRows] = {};
  static_cast<void>(build_morph_entries(kMaxLevel, entries));  // fails for wrong sizes only
  build_family_entries(entries);
  gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, kEntryRowTexels, kEntryRows, GL_RED_INTEGER, GL_UNSIGNED_BYTE,
                   entries);
  return {};
}

// GL takes offsets into buffers as pointers.
const void* buffer_offset(std::size_t bytes) {
  return reinterpret_cast<const void*>(bytes);
}

Status fill_terrain_array(const Gl& gl, const Settings& /*settings*/, const GlObjects& objects) {
  constexpr GLsizei kStride = sizeof(GpuVertex);
  gl.BindBuffer(GL_ARRAY_BUFFER, objects[row_of(Object::vertices)]);
  gl.VertexAttribIPointer(KARST_LOCATION_POSITION, 4, GL_SHORT, kStride, buffer_offset(0));
  gl.VertexAttribIPointer(KARST_LOCATION_MORPH, 4, GL_SHORT, kStride, buffer_offset(kStride / 2));
  gl.EnableVertexAttribArray(KARST_LOCATION_POSITION);
  gl.EnableVertexAttribArray(KARST_LOCATION_MORPH);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, objects[row_of(Object::stream_indices)]);
  return {};
}

Status fill_rim_array(const Gl& gl, const Settings& /*settings*/, const GlObjects& objects) {
  gl.BindBuffer(GL_ARRAY_BUFFER, objects[row_of(Object::rim)]);
  gl.VertexAttribIPointer(KARST_LOCATION_POSITION, 4, GL_INT, sizeof(RimVertex), buffer_offset(0));
  gl.EnableVertexAttribArray(KARST_LOCATION_POSITION);
  return {};
}

template <int n>
Status fill_shadow_target(const Gl& gl, const Settings& /*settings*/, const GlObjects& objects) {
  gl.FramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, objects[row_of(Object::shadow_maps)], 0, n);
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return {};
  return {StatusCode::limit_reached, "the driver could not make a shadow map of this size", "shadow_size"};
}

Status fill_geometry_target(const Gl& gl, const Settings& settings, const GlObjects& objects) {
  const auto attach = [&](GLenum point, Object texture) {
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, point, GL_TEXTURE_2D, objects[row_of(texture)], 0);
  };
  attach(GL_COLOR_ATTACHMENT0, Object::geometry);
  attach(GL_DEPTH_ATTACHMENT, Object::geometry_depth);
  if (settings.has_geometry_voxels()) {
    attach(GL_COLOR_ATTACHMENT1, Object::geometry_voxels);
    constexpr GLenum kBoth[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    gl.DrawBuffers(2, kBoth);
  }
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return {};
  return {StatusCode::limit_reached, "the driver could not make a G-buffer of this size", "deferred_width"};
}

using Consumer = GpuConsumer;
using Kind = ObjectKind;

constexpr ObjectRow kRows[] = {
    {"vertices", Kind::buffer, Consumer::vertices,
     [](const Settings& s) { return buffer(s.all_pages() * kPageBytes, GL_DYNAMIC_DRAW); }, nullptr},
    {"stream_indices", Kind::buffer, Consumer::stream_indices,
     [](const Settings& s) { return buffer(std::size_t{s.stream_indices} * 4, GL_STREAM_DRAW); }, nullptr},
    {"rim", Kind::buffer, Consumer::vertices,
     [](const Settings& s) { return buffer(rim_bytes(s), GL_STATIC_DRAW); }, nullptr},
    {"frame block", Kind::buffer, Consumer::uniforms,
     [](const Settings&) { return buffer(sizeof(shader::FrameBlock), GL_DYNAMIC_DRAW); }, nullptr},
    {"material block", Kind::buffer, Consumer::uniforms,
     [](const Settings&) { return buffer(sizeof(shader::MaterialBlock), GL_STATIC_DRAW); },
     fill_material_block},
    {"cascade block 0", Kind::buffer, Consumer::uniforms, cascade_block<0>, nullptr},
    {"cascade block 1", Kind::buffer, Consumer::uniforms, cascade_block<1>, nullptr},
    {"cascade block 2", Kind::buffer, Consumer::uniforms, cascade_block<2>, nullptr},
    {"air block 0", Kind::buffer, Consumer::uniforms, air_block<0>, nullptr},
    {"air block 1", Kind::buffer, Consumer::uniforms, air_block<1>, nullptr},
    {"air block 2", Kind::buffer, Consumer::uniforms, air_block<2>, nullptr},
    {"air block 3", Kind::buffer, Consumer::uniforms, air_block<3>, nullptr},
    {"air block 4", Kind::buffer, Consumer::uniforms, air_block<4>, nullptr},
    {"air block 5", Kind::buffer, Consumer::uniforms, air_block<5>, nullptr},
    {"air block 6", Kind::buffer, Consumer::uniforms, air_block<6>, nullptr},
    {"air block 7", Kind::buffer, Consumer::uniforms, air_block<7>, nullptr},
    {"page_table", Kind::texture, Consumer::page_table,
     [](const Settings& s) { return image(GL_RGBA32UI, kPageRowTexels, page_table_rows(s)); }, nullptr},
    {"morph_entries", Kind::texture, Consumer::textures,
     [](const Settings&) { return image(GL_R8UI, kEntryRowTexels, kEntryRows); }, fill_entries},
    {"morph_rows", Kind::texture, Consumer::morph_rows,
     [](const Settings& s) {
       return image(GL_R16F, kPatchesPerRow * kMorphRow, morph_texture_rows(s.all_rows()));
     },
     nullptr},
    {"far_textures", Kind::texture, Consumer::materials, materials<TextureArray::far>, fill_far_textures},
    {"near_textures", Kind::texture, Consumer::materials, materials<TextureArray::near>, fill_near_textures},
    {"variation", Kind::texture, Consumer::textures, variation, fill_variation},
    {"sky_visibility", Kind::texture, Consumer::textures, sky_visibility, fill_sky},
    {"blend_map", Kind::texture, Consumer::materials, blend_map, nullptr},
    {"image_tiles", Kind::texture, Consumer::imagery, image_tiles, nullptr},
    {"image_table", Kind::texture, Consumer::imagery, image_table, nullptr},
    {"drape", Kind::texture, Consumer::textures, drape, nullptr},
    {"shadow_maps", Kind::texture, Consumer::shadow_maps, shadow_maps, nullptr},
    {"geometry", Kind::texture, Consumer::g_buffer, [](const Settings& s) { return geometry(s, GL_RG32UI); },
     nullptr},
    {"geometry depth", Kind::texture, Consumer::g_buffer,
     [](const Settings& s) { return geometry(s, GL_DEPTH_COMPONENT32F); }, nullptr},
    {"geometry voxels", Kind::texture, Consumer::g_buffer,
     [](const Settings& s) {
       ObjectShape shape = geometry(s, GL_R16UI);
       shape.wanted = s.has_geometry_voxels();
       return shape;
     },
     nullptr},
    {"terrain", Kind::vertex_array, Consumer::vertices,
     [](const Settings&) { return nothing_but_a_name(true); }, fill_terrain_array},
    {"rim", Kind::vertex_array, Consumer::vertices,
     [](const Settings& s) { return nothing_but_a_name(s.has_rim()); }, fill_rim_array},
    {"no attributes", Kind::vertex_array, Consumer::vertices,
     [](const Settings&) { return nothing_but_a_name(true); }, nullptr},
    {"shadow map 0", Kind::framebuffer, Consumer::shadow_maps, shadow_target<0>, fill_shadow_target<0>},
    {"shadow map 1", Kind::framebuffer, Consumer::shadow_maps, shadow_target<1>, fill_shadow_target<1>},
    {"shadow map 2", Kind::framebuffer, Consumer::shadow_maps, shadow_target<2>, fill_shadow_target<2>},
    {"geometry target", Kind::framebuffer, Consumer::g_buffer,
     [](const Settings& s) { return nothing_but_a_name(s.deferred()); }, fill_geometry_target}};
static_assert(std::size(kRows) == row_of(Object::count) && std::size(kRows) <= GlObjects::kMost);
static_assert(kMostCascades == 3 && RendererSettings::kMostAirBlocks == 8);

struct Unit {
  GLuint unit;
  GLenum target;
  Object object;
};
constexpr Unit kUnits[] = {{KARST_UNIT_PAGE_TABLE, GL_TEXTURE_2D, Object::page_table},
                           {KARST_UNIT_MORPH_ENTRIES, GL_TEXTURE_2D, Object::morph_entries},
                           {KARST_UNIT_MORPH_ROWS, GL_TEXTURE_2D, Object::morph_rows},
                           {KARST_UNIT_FAR_TEXTURES, GL_TEXTURE_2D_ARRAY, Object::far_textures},
                           {KARST_UNIT_SKY_VISIBILITY, GL_TEXTURE_3D, Object::sky_visibility},
                           {KARST_UNIT_VARIATION, GL_TEXTURE_3D, Object::variation},
                           {KARST_UNIT_DRAPE, GL_TEXTURE_2D, Object::drape},
                           {KARST_UNIT_SHADOW_MAPS, GL_TEXTURE_2D_ARRAY, Object::shadow_maps},
                           {KARST_UNIT_NEAR_TEXTURES, GL_TEXTURE_2D_ARRAY, Object::near_textures},
                           {KARST_UNIT_GEOMETRY, GL_TEXTURE_2D, Object::geometry},
                           {KARST_UNIT_BLEND_MAP, GL_TEXTURE_2D, Object::blend_map},
                           {KARST_UNIT_IMAGE_TILES, GL_TEXTURE_2D_ARRAY, Object::image_tiles},
                           {KARST_UNIT_IMAGE_TABLE, GL_TEXTURE_2D, Object::image_table},
                           {KARST_UNIT_GEOMETRY_VOXELS, GL_TEXTURE_2D, Object::geometry_voxels}};
static_assert(std::size(kUnits) == KARST_UNITS + 1);  // one for either of two

}  // namespace

std::span<const ObjectRow> object_rows() {
  return kRows;
}

void RendererSettings::add_to(Budget& budget) const {
  add_objects(kRows, *this, budget);
}

namespace {

void bind(const GlDevice& device, bool textures) {
  for (const Unit& unit : kUnits) {
    if (textures && unit.object == Object::geometry_voxels && name_of(device, unit.object) == 0) continue;
    device.gl.ActiveTexture(GL_TEXTURE0 + device.first_unit + unit.unit);
    device.gl.BindTexture(unit.target, textures ? name_of(device, unit.object) : 0);
    device.gl.BindSampler(device.first_unit + unit.unit, 0);
  }
  device.gl.ActiveTexture(GL_TEXTURE0);
}

}  // namespace

void bind_textures(const GlDevice& device) {
  bind(device, true);
}

void unbind_textures(const GlDevice& device) {
  bind(device, false);
}

void use_block(const GlDevice& device, Object buffer, GLuint binding, std::span<const std::byte> block) {
  const GLuint name = name_of(device, buffer);
  device.gl.BindBufferBase(GL_UNIFORM_BUFFER, device.first_block + binding, name);
  if (!block.empty()) {
    device.gl.BufferSubData(GL_UNIFORM_BUFFER, 0, static_cast<GLsizeiptr>(block.size()), block.data());
  }
}

}  // namespace karst::core
