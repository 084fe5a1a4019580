// SPDX-License-Identifier: MIT
// The GL functions that karst calls, as a table. All of OpenGL ES 3.0 core; what extensions add is null where
// the driver has none and is used only where gl_caps.h says so. Tests put counting functions that draw
// nothing in it.
#pragma once

#include <GLES3/gl3.h>
// gl2ext.h holds the extensions of ES 2 and later; gl3.h must come first.
#include <GLES2/gl2ext.h>

#include "karst/status.h"

#define KARST_GL_CORE_FUNCTIONS(X) \
  X(ActiveTexture)                 \
  X(AttachShader)                  \
  X(BindBuffer)                    \
  X(BindBufferBase)                \
  X(BindFramebuffer)               \
  X(BindRenderbuffer)              \
  X(BindTexture)                   \
  X(BindVertexArray)               \
  X(BlitFramebuffer)               \
  X(BufferData)                    \
  X(BufferSubData)                 \
  X(CheckFramebufferStatus)        \
  X(Clear)                         \
  X(ClearColor)                    \
  X(ClientWaitSync)                \
  X(CompileShader)                 \
  X(CreateProgram)                 \
  X(CreateShader)                  \
  X(CullFace)                      \
  X(DeleteBuffers)                 \
  X(DeleteFramebuffers)            \
  X(DeleteProgram)                 \
  X(DeleteRenderbuffers)           \
  X(DeleteShader)                  \
  X(DeleteSync)                    \
  X(DeleteTextures)                \
  X(DeleteVertexArrays)            \
  X(DepthFunc)                     \
  X(DepthMask)                     \
  X(Disable)                       \
  X(DrawArrays)                    \
  X(DrawElements)                  \
  X(Enable)                        \
  X(EnableVertexAttribArray)       \
  X(FenceSync)                     \
  X(Finish)                        \
  X(FlushMappedBufferRange)        \
  X(FramebufferRenderbuffer)       \
  X(FramebufferTexture2D)          \
  X(FramebufferTextureLayer)       \
  X(GenBuffers)                    \
  X(GenFramebuffers)               \
  X(GenRenderbuffers)              \
  X(GenTextures)                   \
  X(GenVertexArrays)               \
  X(GenerateMipmap)                \
  X(GetError)                      \
  X(GetInteger64v)                 \
  X(GetIntegerv)                   \
  X(GetProgramInfoLog)             \
  X(GetProgramiv)                  \
  X(GetShaderInfoLog)              \
  X(GetShaderiv)                   \
  X(GetString)                     \
  X(GetStringi)                    \
  X(GetUniformBlockIndex)          \
  X(GetUniformLocation)            \
  X(InvalidateFramebuffer)         \
  X(LinkProgram)                   \
  X(MapBufferRange)                \
  X(PixelStorei)                   \
  X(ReadPixels)                    \
  X(RenderbufferStorage)           \
  X(ShaderSource)                  \
  X(TexParameteri)                 \
  X(TexStorage2D)                  \
  X(TexStorage3D)                  \
  X(TexSubImage3D)                 \
  X(CompressedTexSubImage3D)       \
  X(TexSubImage2D)                 \
  X(Uniform1i)                     \
  X(UniformBlockBinding)           \
  X(UnmapBuffer)                   \
  X(UseProgram)                    \
  X(VertexAttribIPointer)          \
  X(Viewport)

// KHR_debug and EXT_disjoint_timer_query.
#define KARST_GL_EXTENSION_FUNCTIONS(X)                        \
  X(BeginQueryEXT, PFNGLBEGINQUERYEXTPROC)                     \
  X(DebugMessageCallbackKHR, PFNGLDEBUGMESSAGECALLBACKKHRPROC) \
  X(DebugMessageControlKHR, PFNGLDEBUGMESSAGECONTROLKHRPROC)   \
  X(DeleteQueriesEXT, PFNGLDELETEQUERIESEXTPROC)               \
  X(EndQueryEXT, PFNGLENDQUERYEXTPROC)                         \
  X(GenQueriesEXT, PFNGLGENQUERIESEXTPROC)                     \
  X(GetQueryObjectui64vEXT, PFNGLGETQUERYOBJECTUI64VEXTPROC)   \
  X(GetQueryObjectuivEXT, PFNGLGETQUERYOBJECTUIVEXTPROC)       \
  X(ObjectLabelKHR, PFNGLOBJECTLABELKHRPROC)                   \
  X(PopDebugGroupKHR, PFNGLPOPDEBUGGROUPKHRPROC)               \
  X(PushDebugGroupKHR, PFNGLPUSHDEBUGGROUPKHRPROC)

namespace karst::core {

// Gives the address of a GL function, or null.
struct GlLoader {
  using Function = void (*)();
  Function (*load)(const void* context, const char* name) = nullptr;
  const void* context = nullptr;
};

struct Gl {
#define KARST_GL_MEMBER(name) decltype(&::gl##name) name = nullptr;
  KARST_GL_CORE_FUNCTIONS(KARST_GL_MEMBER)
#undef KARST_GL_MEMBER
#define KARST_GL_MEMBER(name, type) type name = nullptr;
  KARST_GL_EXTENSION_FUNCTIONS(KARST_GL_MEMBER)
#undef KARST_GL_MEMBER
};

// unsupported, with the function in field(), where the loader has no address for a core function.
Status load_gl(const GlLoader& loader, Gl& gl);

}  // namespace karst::core
