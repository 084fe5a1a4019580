// SPDX-License-Identifier: MIT
// Sources: EGL 1.5; EGL_KHR_platform_gbm, EGL_EXT_platform_base, EGL_EXT_create_context_robustness.
#include "platform/kms/gbm/gbm_context.h"

#include <array>
#include <string>
#include <string_view>

namespace karst {
namespace {

constexpr EGLint kMostConfigs = 256;

}  // namespace

Error GbmContext::failure(const char* function) const {
  return std::string(function) + ": " + egl_error_name(egl_.get_error());
}

Error GbmContext::open(gbm_device* device, std::uint32_t format) {
  close();
  const char* client = egl_.query_string(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (!has_extension(client, "EGL_KHR_platform_gbm") && !has_extension(client, "EGL_MESA_platform_gbm")) {
    return "libEGL cannot draw for GBM (EGL_KHR_platform_gbm)";
  }
  // The function of EGL 1.5 differs only in the type of attributes, of which none are passed.
  auto* get_display =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(egl_.get_proc_address("eglGetPlatformDisplayEXT"));
  if (get_display == nullptr) {
    get_display =
        reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(egl_.get_proc_address("eglGetPlatformDisplay"));
  }
  if (get_display == nullptr) return "libEGL has no eglGetPlatformDisplay";
  display_ = get_display(EGL_PLATFORM_GBM_KHR, device, nullptr);
  if (display_ == EGL_NO_DISPLAY) return failure("eglGetPlatformDisplay");
  EGLint major = 0;
  EGLint minor = 0;
  Error error;
  if (egl_.initialize(display_, &major, &minor) == EGL_FALSE) {
    error = failure("eglInitialize");
    display_ = EGL_NO_DISPLAY;
    return error;
  }
  const char* extensions = egl_.query_string(display_, EGL_EXTENSIONS);
  surfaceless_ = has_extension(extensions, "EGL_KHR_surfaceless_context");
  if (egl_.bind_api(EGL_OPENGL_ES_API) == EGL_FALSE) error = failure("eglBindAPI");
  if (error.ok()) error = choose_config(format);
  if (error.ok()) {
    constexpr EGLint kPlain[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE};
    constexpr EGLint kRobust[] = {EGL_CONTEXT_MAJOR_VERSION, 3,
                                  EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY_EXT,
                                  EGL_LOSE_CONTEXT_ON_RESET_EXT, EGL_NONE};
    if (has_extension(extensions, "EGL_EXT_create_context_robustness")) {
      context_ = egl_.create_context(display_, config_, EGL_NO_CONTEXT, kRobust);
    }
    // Drivers that list the extension may still refuse such a context.
    if (context_ == EGL_NO_CONTEXT) {
      context_ = egl_.create_context(display_, config_, EGL_NO_CONTEXT, kPlain);
    }
    if (context_ == EGL_NO_CONTEXT) error = failure("eglCreateContext for OpenGL ES 3");
  }
  if (error.ok() && surfaceless_) error = make_current();
  if (!error.ok()) close();
  return error;
}

Error GbmContext::choose_config(std::uint32_t format) {
  const EGLint attributes[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT, EGL_SURFACE_TYPE, EGL_WINDOW_BIT,
                               EGL_NONE};
  std::array<EGLConfig, kMostConfigs> configs{};
  EGLint count = 0;
  if (egl_.choose_config(display_, attributes, configs.data(), kMostConfigs, &count) == EGL_FALSE) {
    return failure("eglChooseConfig");
  }
  // EGL sorts by colour depth; the screen needs exactly this format.
  for (EGLint i = 0; i < count; ++i) {
    EGLint visual = 0;
    config_ = configs[static_cast<std::size_t>(i)];
    if (egl_.get_config_attrib(display_, config_, EGL_NATIVE_VISUAL_ID, &visual) == EGL_TRUE &&
        static_cast<std::uint32_t>(visual) == format) {
      return {};
    }
  }
  return "eglChooseConfig: OpenGL ES 3 cannot draw in the screen's colour format";
}

void GbmContext::close() {
  if (display_ == EGL_NO_DISPLAY) return;
  egl_.make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  if (surface_ != EGL_NO_SURFACE) egl_.destroy_surface(display_, surface_);
  if (context_ != EGL_NO_CONTEXT) egl_.destroy_context(display_, context_);
  egl_.terminate(display_);
  surface_ = EGL_NO_SURFACE;
  context_ = EGL_NO_CONTEXT;
  display_ = EGL_NO_DISPLAY;
}

Error GbmContext::set_surface(gbm_surface* surface) {
  drop_surface();
  surface_ =
      egl_.create_window_surface(display_, config_, reinterpret_cast<EGLNativeWindowType>(surface), nullptr);
  if (surface_ == EGL_NO_SURFACE) return failure("eglCreateWindowSurface");
  return make_current();
}

void GbmContext::drop_surface() {
  if (surface_ == EGL_NO_SURFACE) return;
  egl_.make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, surfaceless_ ? context_ : EGL_NO_CONTEXT);
  egl_.destroy_surface(display_, surface_);
  surface_ = EGL_NO_SURFACE;
}

Error GbmContext::make_current() {
  if (egl_.make_current(display_, surface_, surface_, context_) == EGL_FALSE)
    return failure("eglMakeCurrent");
  return {};
}

GbmContext::Swapped GbmContext::swap(Error& error) {
  if (egl_.swap_buffers(display_, surface_) == EGL_TRUE) return Swapped::done;
  const EGLint code = egl_.get_error();
  error = std::string("eglSwapBuffers: ") + egl_error_name(code);
  return code == EGL_CONTEXT_LOST ? Swapped::context_lost : Swapped::failed;
}

}  // namespace karst
