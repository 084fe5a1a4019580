// SPDX-License-Identifier: MIT
// The EGL functions that displays call, as a table: what libEGL offers differs between boards, and tests put
// their own functions in it to see every way of failing.
#pragma once

#include <string_view>

#include <EGL/egl.h>
#include <EGL/eglext.h>

namespace karst {

struct EglApi {
  decltype(&eglGetProcAddress) get_proc_address = nullptr;
  decltype(&eglQueryString) query_string = nullptr;
  decltype(&eglGetError) get_error = nullptr;
  decltype(&eglInitialize) initialize = nullptr;
  decltype(&eglTerminate) terminate = nullptr;
  decltype(&eglBindAPI) bind_api = nullptr;
  decltype(&eglChooseConfig) choose_config = nullptr;
  decltype(&eglCreateContext) create_context = nullptr;
  decltype(&eglDestroyContext) destroy_context = nullptr;
  decltype(&eglCreatePbufferSurface) create_pbuffer_surface = nullptr;
  decltype(&eglDestroySurface) destroy_surface = nullptr;
  decltype(&eglMakeCurrent) make_current = nullptr;
  decltype(&eglGetConfigAttrib) get_config_attrib = nullptr;
  decltype(&eglCreateWindowSurface) create_window_surface = nullptr;
  decltype(&eglSwapBuffers) swap_buffers = nullptr;
};

// The functions of the libEGL that the program is linked with.
EglApi linked_egl();

// Whether the space-separated list names the extension; list may be null.
bool has_extension(const char* list, std::string_view extension);

// "EGL_BAD_MATCH" for 0x3009 and so on.
const char* egl_error_name(EGLint error);

}  // namespace karst
