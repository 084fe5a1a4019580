// SPDX-License-Identifier: MIT
// Entities in karst's picture, in its light and air: boxes, all of a view in one instanced draw.
#pragma once

#include <GLES3/gl3.h>

#include <cstdint>
#include <vector>

#include "app/common/gl/function_table.h"
#include "ig/state/entities.h"
#include "karst/renderer.h"

#define KARST_BOXES_FUNCTIONS(X) \
  X(ActiveTexture)               \
  X(AttachShader)                \
  X(BindBuffer)                  \
  X(BindBufferBase)              \
  X(BindTexture)                 \
  X(BindVertexArray)             \
  X(BlendFunc)                   \
  X(BlendFuncSeparate)           \
  X(BufferData)                  \
  X(CompileShader)               \
  X(CreateProgram)               \
  X(CreateShader)                \
  X(DeleteBuffers)               \
  X(DeleteProgram)               \
  X(DeleteShader)                \
  X(DeleteVertexArrays)          \
  X(DepthFunc)                   \
  X(DepthRangef)                 \
  X(Disable)                     \
  X(DrawArraysInstanced)         \
  X(Enable)                      \
  X(EnableVertexAttribArray)     \
  X(FrontFace)                   \
  X(GenBuffers)                  \
  X(GenVertexArrays)             \
  X(GetProgramiv)                \
  X(GetUniformBlockIndex)        \
  X(GetUniformLocation)          \
  X(LinkProgram)                 \
  X(ShaderSource)                \
  X(Uniform1i)                   \
  X(UniformBlockBinding)         \
  X(UniformMatrix4fv)            \
  X(UseProgram)                  \
  X(VertexAttribDivisor)         \
  X(VertexAttribPointer)

namespace karst::ig {

class Boxes {
 public:
  // Of GPU memory.
  static constexpr std::uint64_t kBytes = Entities::kMost * 64;

  Boxes();
  Boxes(const Boxes&) = delete;
  Boxes& operator=(const Boxes&) = delete;
  ~Boxes() { destroy(); }

  // In the context that is current in all calls. unsupported: a function or a shader.
  Status create(const GlLoader& loader);
  void destroy();
  void forget();  // instead, where the context is lost

  // Entities that are seen, into the bound framebuffer, behind karst's own draw of the view. two_ranges: as
  // karst::Target had it.
  void draw(const Entities& entities, glm::dvec3 half_m, const ViewState& view, const Air& air,
            bool two_ranges);

 private:
  struct Functions {
    KARST_BOXES_FUNCTIONS(KARST_GL_MEMBER)
    void(GL_APIENTRY* ClipControlEXT)(GLenum origin, GLenum depth) = nullptr;  // may be missing
  };
  // Columns along the box's half sides and to its middle, from the eye; their fourth numbers are the colour.
  struct Instance {
    float columns[4][4];
  };
  struct Order {
    double distance2 = 0;
    bool opaque = true;
    std::uint32_t entity = 0;
  };

  std::size_t list(const Entities& entities, glm::dvec3 half_m, const ViewState& view);

  Functions gl_;
  bool created_ = false;
  GLuint program_ = 0, array_ = 0, buffer_ = 0;
  GLint clip_from_eye_ = -1;
  std::vector<Instance> instances_;
  std::vector<Order> order_;
};

}  // namespace karst::ig
