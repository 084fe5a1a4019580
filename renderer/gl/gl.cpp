// SPDX-License-Identifier: MIT
#include "renderer/gl/gl.h"

namespace karst::core {

Status load_gl(const GlLoader& loader, Gl& gl) {
  const char* missing = nullptr;
#define KARST_GL_LOAD(name)                                                               \
  gl.name = reinterpret_cast<decltype(gl.name)>(loader.load(loader.context, "gl" #name)); \
  if (gl.name == nullptr && missing == nullptr) missing = "gl" #name;
  KARST_GL_CORE_FUNCTIONS(KARST_GL_LOAD)
#undef KARST_GL_LOAD
#define KARST_GL_LOAD(name, type) gl.name = reinterpret_cast<type>(loader.load(loader.context, "gl" #name));
  KARST_GL_EXTENSION_FUNCTIONS(KARST_GL_LOAD)
#undef KARST_GL_LOAD
  if (missing != nullptr)
    return {StatusCode::unsupported, "the driver lacks a function of OpenGL ES 3.0", missing};
  return {};
}

}  // namespace karst::core
