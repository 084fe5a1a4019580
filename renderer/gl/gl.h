// SPDX-License-Identifier: MIT
// The GL functions that karst calls, as a table: of OpenGL ES 3.0, which OpenGL 4.3 with
// ARB_ES3_compatibility has under the same names. What extensions and OpenGL add is null where the driver has
// none and is used only where gl_caps.h says so. Tests put counting functions that draw nothing in it.
#pragma once

#include <GLES3/gl3.h>
// gl2ext.h holds the extensions of ES 2 and later; gl3.h must come first.
#include <GLES2/gl2ext.h>

#include "karst/status.h"
#include "karst/types.h"

#define KARST_GL_CORE_FUNCTIONS(X) \
  X(ActiveTexture)                 \
  X(AttachShader)                  \
  X(BindBuffer)                    \
  X(BindBufferBase)                \
  X(BindFramebuffer)               \
  X(BindSampler)                   \
  X(BindTexture)                   \
  X(BindVertexArray)               \
  X(BufferData)                    \
  X(BufferSubData)                 \
  X(CheckFramebufferStatus)        \
  X(ClearBufferfv)                 \
  X(ClearBufferuiv)                \
  X(ClientWaitSync)                \
  X(ColorMask)                     \
  X(CompileShader)                 \
  X(CompressedTexSubImage3D)       \
  X(CreateProgram)                 \
  X(CreateShader)                  \
  X(CullFace)                      \
  X(DeleteBuffers)                 \
  X(DeleteFramebuffers)            \
  X(DeleteProgram)                 \
  X(DeleteShader)                  \
  X(DeleteSync)                    \
  X(DeleteTextures)                \
  X(DeleteVertexArrays)            \
  X(DepthFunc)                     \
  X(DepthMask)                     \
  X(DepthRangef)                   \
  X(Disable)                       \
  X(DrawArrays)                    \
  X(DrawBuffers)                   \
  X(DrawElements)                  \
  X(Enable)                        \
  X(EnableVertexAttribArray)       \
  X(FenceSync)                     \
  X(Finish)                        \
  X(FlushMappedBufferRange)        \
  X(FramebufferTexture2D)          \
  X(FramebufferTextureLayer)       \
  X(FrontFace)                     \
  X(GenBuffers)                    \
  X(GenFramebuffers)               \
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
  X(LinkProgram)                   \
  X(MapBufferRange)                \
  X(PixelStorei)                   \
  X(ShaderSource)                  \
  X(TexParameteri)                 \
  X(TexStorage2D)                  \
  X(TexStorage3D)                  \
  X(TexSubImage2D)                 \
  X(TexSubImage3D)                 \
  X(Uniform1i)                     \
  X(UniformBlockBinding)           \
  X(UnmapBuffer)                   \
  X(UseProgram)                    \
  X(VertexAttribIPointer)          \
  X(Viewport)

// Member, type, name in OpenGL ES, name in OpenGL: KHR_debug, EXT_disjoint_timer_query, EXT_clip_control, and
// two functions that OpenGL ES 3.0 has no state for.
#define KARST_GL_EXTENSION_FUNCTIONS(X)                                                                   \
  X(BeginQueryEXT, PFNGLBEGINQUERYEXTPROC, "glBeginQueryEXT", "glBeginQuery")                             \
  X(ClipControlEXT, PFNGLCLIPCONTROLEXTPROC, "glClipControlEXT", "glClipControl")                         \
  X(DebugMessageCallbackKHR, PFNGLDEBUGMESSAGECALLBACKKHRPROC, "glDebugMessageCallbackKHR",               \
    "glDebugMessageCallback")                                                                             \
  X(DebugMessageControlKHR, PFNGLDEBUGMESSAGECONTROLKHRPROC, "glDebugMessageControlKHR",                  \
    "glDebugMessageControl")                                                                              \
  X(DeleteQueriesEXT, PFNGLDELETEQUERIESEXTPROC, "glDeleteQueriesEXT", "glDeleteQueries")                 \
  X(EndQueryEXT, PFNGLENDQUERYEXTPROC, "glEndQueryEXT", "glEndQuery")                                     \
  X(GenQueriesEXT, PFNGLGENQUERIESEXTPROC, "glGenQueriesEXT", "glGenQueries")                             \
  X(GetQueryObjectui64vEXT, PFNGLGETQUERYOBJECTUI64VEXTPROC, "glGetQueryObjectui64vEXT",                  \
    "glGetQueryObjectui64v")                                                                              \
  X(GetQueryObjectuivEXT, PFNGLGETQUERYOBJECTUIVEXTPROC, "glGetQueryObjectuivEXT", "glGetQueryObjectuiv") \
  X(ObjectLabelKHR, PFNGLOBJECTLABELKHRPROC, "glObjectLabelKHR", "glObjectLabel")                         \
  X(PolygonModeNV, PFNGLPOLYGONMODENVPROC, "glPolygonModeNV", "glPolygonMode")                            \
  X(PopDebugGroupKHR, PFNGLPOPDEBUGGROUPKHRPROC, "glPopDebugGroupKHR", "glPopDebugGroup")                 \
  X(ProvokingVertex, ::karst::core::GlProvokingVertex, "glProvokingVertex", "glProvokingVertex")          \
  X(PushDebugGroupKHR, PFNGLPUSHDEBUGGROUPKHRPROC, "glPushDebugGroupKHR", "glPushDebugGroup")

namespace karst::core {

using GlProvokingVertex = void(GL_APIENTRYP)(GLenum mode);

struct Gl {
#define KARST_GL_MEMBER(name) decltype(&::gl##name) name = nullptr;
  KARST_GL_CORE_FUNCTIONS(KARST_GL_MEMBER)
#undef KARST_GL_MEMBER
#define KARST_GL_MEMBER(member, type, es_name, desktop_name) type member = nullptr;
  KARST_GL_EXTENSION_FUNCTIONS(KARST_GL_MEMBER)
#undef KARST_GL_MEMBER
};

// desktop: the context is one of OpenGL. unsupported, with the function in field(), where the loader has no
// address for a core function.
Status load_gl(const GlLoader& loader, bool desktop, Gl& gl);

// Takes all errors that are pending; the first of them, GL_NO_ERROR where there was none. Not for frames:
// asking makes some drivers wait.
GLenum take_gl_errors(const Gl& gl);

}  // namespace karst::core
