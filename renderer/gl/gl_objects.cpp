// SPDX-License-Identifier: MIT
#include "renderer/gl/gl_objects.h"

#include <algorithm>
#include <cassert>

namespace karst::core {
namespace {

std::size_t image_bytes(GLenum format, std::size_t width, std::size_t height) {
  switch (format) {
    case GL_R8:
    case GL_R8UI:
      return width * height;
    case GL_R16F:
    case GL_R16UI:
    case GL_RGBA4:
    case GL_DEPTH_COMPONENT16:
      return width * height * 2;
    case GL_RG32UI:
      return width * height * 8;
    case GL_RGBA32UI:
      return width * height * 16;
    case GL_COMPRESSED_SRGB8_ETC2:
      return ((width + 3) / 4) * ((height + 3) / 4) * 8;
    case GL_COMPRESSED_SRGB8_ALPHA8_ETC2_EAC:
    case GL_COMPRESSED_RGBA8_ETC2_EAC:
      return ((width + 3) / 4) * ((height + 3) / 4) * 16;
    default:  // RGBA8, SRGB8_ALPHA8, and DEPTH_COMPONENT24, which takes 32 bits
      return width * height * 4;
  }
}

std::size_t texture_bytes(const ObjectShape& shape) {
  std::size_t bytes = 0;
  for (int level = 0; level < shape.levels; ++level) {
    const auto side = [level](int whole) { return static_cast<std::size_t>(std::max(whole >> level, 1)); };
    const std::size_t layers =
        shape.target == GL_TEXTURE_3D ? side(shape.depth) : static_cast<std::size_t>(shape.depth);
    bytes += image_bytes(shape.format, side(shape.width), side(shape.height)) * layers;
  }
  return bytes;
}

void specify_texture(const Gl& gl, const ObjectShape& shape) {
  if (shape.target == GL_TEXTURE_2D) {
    gl.TexStorage2D(shape.target, shape.levels, shape.format, shape.width, shape.height);
  } else {
    gl.TexStorage3D(shape.target, shape.levels, shape.format, shape.width, shape.height, shape.depth);
  }
  const auto set = [&](GLenum name, GLenum value) {
    gl.TexParameteri(shape.target, name, static_cast<GLint>(value));
  };
  set(GL_TEXTURE_MIN_FILTER, shape.min_filter);
  set(GL_TEXTURE_MAG_FILTER, shape.mag_filter);
  set(GL_TEXTURE_WRAP_S, shape.wrap);
  set(GL_TEXTURE_WRAP_T, shape.wrap);
  if (shape.target == GL_TEXTURE_3D) set(GL_TEXTURE_WRAP_R, shape.wrap);
  if (shape.anisotropy > 1) gl.TexParameteri(shape.target, GL_TEXTURE_MAX_ANISOTROPY_EXT, shape.anisotropy);
  if (!shape.compare) return;
  set(GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  set(GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
}

GLenum label_kind(ObjectKind kind) {
  switch (kind) {
    case ObjectKind::buffer:
      return GL_BUFFER_KHR;
    case ObjectKind::texture:
      return GL_TEXTURE;
    case ObjectKind::vertex_array:
      return GL_VERTEX_ARRAY_KHR;
    case ObjectKind::framebuffer:
      return GL_FRAMEBUFFER;
  }
  return GL_NONE;
}

// A name is no object before it is bound for the first time.
GLuint make_bound(const Gl& gl, ObjectKind kind, const ObjectShape& shape) {
  GLuint name = 0;
  switch (kind) {
    case ObjectKind::buffer:
      gl.GenBuffers(1, &name);
      gl.BindBuffer(GL_ARRAY_BUFFER, name);
      gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(shape.bytes), nullptr, shape.usage);
      break;
    case ObjectKind::texture:
      gl.GenTextures(1, &name);
      gl.BindTexture(shape.target, name);
      specify_texture(gl, shape);
      break;
    case ObjectKind::vertex_array:
      gl.GenVertexArrays(1, &name);
      gl.BindVertexArray(name);
      break;
    case ObjectKind::framebuffer:
      gl.GenFramebuffers(1, &name);
      gl.BindFramebuffer(GL_FRAMEBUFFER, name);
      break;
  }
  return name;
}

void unbind(const Gl& gl, ObjectKind kind, const ObjectShape& shape) {
  switch (kind) {
    case ObjectKind::buffer:
      gl.BindBuffer(GL_ARRAY_BUFFER, 0);
      break;
    case ObjectKind::texture:
      gl.BindTexture(shape.target, 0);
      break;
    case ObjectKind::vertex_array:
      gl.BindVertexArray(0);
      gl.BindBuffer(GL_ARRAY_BUFFER, 0);
      break;
    case ObjectKind::framebuffer:
      gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
      break;
  }
}

void delete_object(const Gl& gl, ObjectKind kind, const GLuint& name) {
  switch (kind) {
    case ObjectKind::buffer:
      gl.DeleteBuffers(1, &name);
      break;
    case ObjectKind::texture:
      gl.DeleteTextures(1, &name);
      break;
    case ObjectKind::vertex_array:
      gl.DeleteVertexArrays(1, &name);
      break;
    case ObjectKind::framebuffer:
      gl.DeleteFramebuffers(1, &name);
      break;
  }
}

}  // namespace

std::size_t object_bytes(const ObjectRow& row, const RendererSettings& settings) {
  const ObjectShape shape = row.shape(settings);
  if (!shape.wanted) return 0;
  if (row.kind == ObjectKind::buffer) return shape.bytes;
  return row.kind == ObjectKind::texture ? texture_bytes(shape) : 0;
}

void add_objects(std::span<const ObjectRow> rows, const RendererSettings& settings, Budget& budget) {
  for (const ObjectRow& row : rows) budget.add(row.consumer, object_bytes(row, settings));
}

Status GlObjects::create(const Gl& gl, std::span<const ObjectRow> rows, const RendererSettings& settings,
                         bool label) {
  assert(rows.size() <= kMost);
  rows_ = rows;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const ObjectRow& row = rows[i];
    const ObjectShape shape = row.shape(settings);
    if (!shape.wanted) continue;
    names_[i] = make_bound(gl, row.kind, shape);
    bytes_[i] = object_bytes(row, settings);
    const Status status = row.fill != nullptr ? row.fill(gl, settings, *this) : Status();
    if (label) gl.ObjectLabelKHR(label_kind(row.kind), names_[i], -1, row.label);
    unbind(gl, row.kind, shape);
    if (!status.ok()) return status;
  }
  return {};
}

void GlObjects::destroy(const Gl& gl) {
  // The last ones first: framebuffers before what they draw into.
  for (std::size_t i = rows_.size(); i-- > 0;) {
    if (names_[i] != 0) delete_object(gl, rows_[i].kind, names_[i]);
  }
  forget();
}

void GlObjects::forget() {
  rows_ = {};
  std::fill(std::begin(names_), std::end(names_), 0u);
  std::fill(std::begin(bytes_), std::end(bytes_), std::size_t{0});
}

std::size_t GlObjects::total_bytes() const {
  std::size_t total = 0;
  for (const std::size_t bytes : bytes_) total += bytes;
  return total;
}

}  // namespace karst::core
