// SPDX-License-Identifier: MIT
#include "platform/egl_api.h"

namespace karst {

EglApi linked_egl() {
  return {.get_proc_address = eglGetProcAddress,
          .query_string = eglQueryString,
          .get_error = eglGetError,
          .initialize = eglInitialize,
          .terminate = eglTerminate,
          .bind_api = eglBindAPI,
          .choose_config = eglChooseConfig,
          .create_context = eglCreateContext,
          .destroy_context = eglDestroyContext,
          .create_pbuffer_surface = eglCreatePbufferSurface,
          .destroy_surface = eglDestroySurface,
          .make_current = eglMakeCurrent,
          .get_config_attrib = eglGetConfigAttrib,
          .create_window_surface = eglCreateWindowSurface,
          .swap_buffers = eglSwapBuffers};
}

bool has_extension(const char* list, std::string_view extension) {
  std::string_view rest = list == nullptr ? std::string_view() : std::string_view(list);
  while (!rest.empty()) {
    const std::size_t end = rest.find(' ');
    if (rest.substr(0, end) == extension) return true;
    if (end == std::string_view::npos) return false;
    rest.remove_prefix(end + 1);
  }
  return false;
}

const char* egl_error_name(EGLint error) {
  switch (error) {
    case EGL_SUCCESS:
      return "EGL_SUCCESS";
    case EGL_NOT_INITIALIZED:
      return "EGL_NOT_INITIALIZED";
    case EGL_BAD_ACCESS:
      return "EGL_BAD_ACCESS";
    case EGL_BAD_ALLOC:
      return "EGL_BAD_ALLOC";
    case EGL_BAD_ATTRIBUTE:
      return "EGL_BAD_ATTRIBUTE";
    case EGL_BAD_CONTEXT:
      return "EGL_BAD_CONTEXT";
    case EGL_BAD_CONFIG:
      return "EGL_BAD_CONFIG";
    case EGL_BAD_CURRENT_SURFACE:
      return "EGL_BAD_CURRENT_SURFACE";
    case EGL_BAD_DISPLAY:
      return "EGL_BAD_DISPLAY";
    case EGL_BAD_SURFACE:
      return "EGL_BAD_SURFACE";
    case EGL_BAD_MATCH:
      return "EGL_BAD_MATCH";
    case EGL_BAD_PARAMETER:
      return "EGL_BAD_PARAMETER";
    case EGL_BAD_NATIVE_PIXMAP:
      return "EGL_BAD_NATIVE_PIXMAP";
    case EGL_BAD_NATIVE_WINDOW:
      return "EGL_BAD_NATIVE_WINDOW";
    case EGL_CONTEXT_LOST:
      return "EGL_CONTEXT_LOST";
    default:
      return "an unknown EGL error";
  }
}

}  // namespace karst
