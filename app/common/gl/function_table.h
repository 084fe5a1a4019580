// SPDX-License-Identifier: MIT
// Tables of OpenGL functions, each with those that it needs: FUNCTIONS(X) calls X(Name) for all of them.
//
//   struct Functions { FUNCTIONS(KARST_GL_MEMBER) };
//   const char* missing = nullptr;  FUNCTIONS(KARST_GL_LOAD)   // into gl_, from loader
//   if (missing != nullptr) return lacks_function(missing);
#pragma once

#include "karst/status.h"

#define KARST_GL_MEMBER(name) decltype(&::gl##name) name = nullptr;
#define KARST_GL_LOAD(name)                                                              \
  gl_.name = reinterpret_cast<decltype(gl_.name)>(loader.load(loader.user, "gl" #name)); \
  if (gl_.name == nullptr) missing = "gl" #name;

namespace karst::app {

inline Status lacks_function(const char* name) {
  return {StatusCode::unsupported, "the driver lacks a function of OpenGL ES 3.0", name};
}

}  // namespace karst::app
