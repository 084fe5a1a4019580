// SPDX-License-Identifier: MIT
#include "renderer/gl/gl.h"

namespace karst::core {

Status load_gl(const GlLoader& loader, bool desktop, Gl& gl) {
  const char* missing = nullptr;
#define KARST_GL_LOAD(name)                                                            \
  gl.name = reinterpret_cast<decltype(gl.name)>(loader.load(loader.user, "gl" #name)); \
  if (gl.name == nullptr && missing == nullptr) missing = "gl" #name;
  KARST_GL_CORE_FUNCTIONS(KARST_GL_LOAD)
#undef KARST_GL_LOAD
#define KARST_GL_LOAD(member, type, es_name, desktop_name) \
  gl.member = reinterpret_cast<type>(loader.load(loader.user, desktop ? desktop_name : es_name));
  KARST_GL_EXTENSION_FUNCTIONS(KARST_GL_LOAD)
#undef KARST_GL_LOAD
  if (missing == nullptr) return {};
  return {StatusCode::unsupported, "the driver lacks a function of OpenGL ES 3.0", missing};
}

GLenum take_gl_errors(const Gl& gl) {
  const GLenum first = gl.GetError();
  // Errors are flags, one a kind: a handful at most. A lost context gives errors without end.
  for (int i = 0; first != GL_NO_ERROR && i < 16 && gl.GetError() != GL_NO_ERROR;) ++i;
  return first;
}

}  // namespace karst::core
