// SPDX-License-Identifier: MIT
// Draws an OverlayMesh in the context of a picture (OpenGL ES 3.0). Its state is left as OpenGL has it
// initially, as karst leaves it; the framebuffer and the viewport stay.
#pragma once

#include <GLES3/gl3.h>

#include <cstdint>

#include "app/common/gl/function_table.h"
#include "app/overlay/overlay_mesh.h"
#include "karst/status.h"
#include "karst/types.h"

#define KARST_OVERLAY_FUNCTIONS(X) \
  X(ActiveTexture)                 \
  X(AttachShader)                  \
  X(BindBuffer)                    \
  X(BindTexture)                   \
  X(BindVertexArray)               \
  X(BlendFunc)                     \
  X(BlendFuncSeparate)             \
  X(BufferData)                    \
  X(CompileShader)                 \
  X(CreateProgram)                 \
  X(CreateShader)                  \
  X(DeleteBuffers)                 \
  X(DeleteProgram)                 \
  X(DeleteShader)                  \
  X(DeleteTextures)                \
  X(DeleteVertexArrays)            \
  X(DepthFunc)                     \
  X(DepthMask)                     \
  X(DepthRangef)                   \
  X(Disable)                       \
  X(DrawArrays)                    \
  X(Enable)                        \
  X(EnableVertexAttribArray)       \
  X(GenBuffers)                    \
  X(GenTextures)                   \
  X(GenVertexArrays)               \
  X(GetProgramiv)                  \
  X(GetUniformLocation)            \
  X(LinkProgram)                   \
  X(PixelStorei)                   \
  X(ShaderSource)                  \
  X(TexParameteri)                 \
  X(TexStorage2D)                  \
  X(TexSubImage2D)                 \
  X(Uniform1f)                     \
  X(UseProgram)                    \
  X(VertexAttribPointer)

namespace karst::app {

class Overlay {
 public:
  Overlay() = default;
  Overlay(const Overlay&) = delete;
  Overlay& operator=(const Overlay&) = delete;
  ~Overlay() { destroy(); }

  // Of GPU memory, that create() takes.
  static constexpr std::uint64_t bytes() { return OverlayMesh::kMostVertices * sizeof(OverlayVertex) + 8192; }

  // unsupported where the driver lacks a function or rejects a shader.
  Status create(const GlLoader& loader);
  void destroy();
  void forget();  // instead, where the context is lost

  // Into the bound framebuffer, whose depth is the terrain's: two_ranges as its Target had it. Lines that
  // rock hides shine through faintly.
  void draw(const OverlayMesh& mesh, const ViewState& view, bool two_ranges);

 private:
  struct Functions {
    KARST_OVERLAY_FUNCTIONS(KARST_GL_MEMBER)
  };
  void draw_vertices(std::span<const OverlayVertex> vertices, float opacity);

  Functions gl_;
  bool created_ = false;
  GLuint program_ = 0, buffer_ = 0, array_ = 0, font_ = 0;
  GLint opacity_ = -1;
};

}  // namespace karst::app
