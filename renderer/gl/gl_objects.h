// SPDX-License-Identifier: MIT
// GL objects that karst owns, from one table: a row says what an object is called, what it takes and how it
// is made, and from that follow the budget, making, labelling and deleting.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "renderer/gl/gl.h"
#include "terrain/base/budget.h"

namespace karst::core {

struct RendererSettings;
class GlObjects;

enum class ObjectKind : std::uint8_t { buffer, texture, vertex_array, framebuffer };

// What an object is with given settings.
struct ObjectShape {
  bool wanted = true;  // false: it is not made
  // Buffers.
  std::size_t bytes = 0;
  GLenum usage = GL_STATIC_DRAW;
  // Textures, which never change their shape. depth: layers of an array.
  GLenum target = GL_TEXTURE_2D;
  GLenum format = GL_RGBA8;
  int levels = 1, width = 1, height = 1, depth = 1;
  GLenum min_filter = GL_NEAREST, mag_filter = GL_NEAREST;
  GLenum wrap = GL_CLAMP_TO_EDGE;
  int anisotropy = 1;    // above 1: EXT_texture_filter_anisotropic is there
  bool compare = false;  // lookups compare: passes where the reference is not above the texel
};

struct ObjectRow {
  const char* label;
  ObjectKind kind;
  GpuConsumer consumer;  // of what buffers and textures take
  ObjectShape (*shape)(const RendererSettings& settings);
  // Fills it in while it is bound to its target (buffers: GL_ARRAY_BUFFER); objects of rows before it are
  // there. Null: its contents come later.
  Status (*fill)(const Gl& gl, const RendererSettings& settings, const GlObjects& objects);
};

// Bytes that an object takes with the settings; 0 where it is not made.
std::size_t object_bytes(const ObjectRow& row, const RendererSettings& settings);
// Adds what all of them take.
void add_objects(std::span<const ObjectRow> rows, const RendererSettings& settings, Budget& budget);

class GlObjects {
 public:
  static constexpr std::size_t kMost = 40;

  // rows: at most kMost; must outlive the objects. Pixels are unpacked as GL does it initially, and no pixel
  // unpack buffer is bound. Objects that were made have to be destroyed, after a failure too. Leaves the
  // framebuffer, array buffer, vertex array and textures of the active unit unbound.
  Status create(const Gl& gl, std::span<const ObjectRow> rows, const RendererSettings& settings, bool label);
  void destroy(const Gl& gl);
  // The context is gone, and the objects with it.
  void forget();

  // Name of a row's object, 0 where it was not made.
  GLuint operator[](std::size_t row) const { return names_[row]; }
  // Bytes that objects take which are there.
  std::size_t bytes(std::size_t row) const { return bytes_[row]; }
  std::size_t total_bytes() const;

 private:
  std::span<const ObjectRow> rows_;
  GLuint names_[kMost] = {};
  std::size_t bytes_[kMost] = {};
};

}  // namespace karst::core
