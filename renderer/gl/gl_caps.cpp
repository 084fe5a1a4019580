// SPDX-License-Identifier: MIT
#include "renderer/gl/gl_caps.h"

#include <cstddef>
#include <cstdio>
#include <cstring>

namespace karst::core {
namespace {

template <std::size_t size>
void copy_string(const Gl& gl, GLenum name, char (&out)[size]) {
  const GLubyte* text = gl.GetString(name);
  std::snprintf(out, size, "%s", text == nullptr ? "" : reinterpret_cast<const char*>(text));
}

// "OpenGL ES 3.2 Mesa 22.3.6": ES 3.0 prescribes the prefix, and a context of ES 2.0 or of desktop GL has
// another. It is asked before anything that only ES 3.0 knows.
bool is_es3(const char* version) {
  constexpr const char* kPrefix = "OpenGL ES ";
  const std::size_t length = std::strlen(kPrefix);
  return std::strncmp(version, kPrefix, length) == 0 && version[length] >= '3' && version[length] <= '9';
}

}  // namespace

Status query_gl_caps(const Gl& gl, GlCaps& caps) {
  copy_string(gl, GL_VENDOR, caps.vendor);
  copy_string(gl, GL_RENDERER, caps.renderer);
  copy_string(gl, GL_VERSION, caps.version);
  if (!is_es3(caps.version)) return {StatusCode::unsupported, "the context is not OpenGL ES 3", "GL_VERSION"};

  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &caps.max_texture_size);
  gl.GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &caps.max_renderbuffer_size);
  gl.GetIntegerv(GL_MAX_VIEWPORT_DIMS, caps.max_viewport);
  GLint64 index = 0;
  gl.GetInteger64v(GL_MAX_ELEMENT_INDEX, &index);
  caps.max_element_index = index;

  GLint count = 0;
  gl.GetIntegerv(GL_NUM_EXTENSIONS, &count);
  for (GLint i = 0; i < count; ++i) {
    const GLubyte* text = gl.GetStringi(GL_EXTENSIONS, static_cast<GLuint>(i));
    if (text == nullptr) continue;
    const char* name = reinterpret_cast<const char*>(text);
    if (std::strcmp(name, "GL_KHR_debug") == 0) caps.debug = true;
    if (std::strcmp(name, "GL_EXT_disjoint_timer_query") == 0) caps.timer_query = true;
  }
  // An extension that is advertised and has no functions is none.
  caps.debug = caps.debug && gl.DebugMessageCallbackKHR != nullptr && gl.DebugMessageControlKHR != nullptr &&
               gl.ObjectLabelKHR != nullptr && gl.PushDebugGroupKHR != nullptr &&
               gl.PopDebugGroupKHR != nullptr;
  caps.timer_query = caps.timer_query && gl.GenQueriesEXT != nullptr && gl.DeleteQueriesEXT != nullptr &&
                     gl.BeginQueryEXT != nullptr && gl.EndQueryEXT != nullptr &&
                     gl.GetQueryObjectuivEXT != nullptr && gl.GetQueryObjectui64vEXT != nullptr;
  caps.first_timer_result_is_wrong = std::strncmp(caps.renderer, "llvmpipe", 8) == 0;
  return {};
}

}  // namespace karst::core
