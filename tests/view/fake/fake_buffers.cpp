// SPDX-License-Identifier: MIT
// The fake card's libgbm and libEGL; see fake_kms.cpp.
#include "tests/view/fake/fake_kms.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GLES3/gl3.h>
#include <drm_fourcc.h>
#include <gbm.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

using namespace karst::fake;

static std::map<std::uint32_t, gbm_bo*>& buffers() {
  static std::map<std::uint32_t, gbm_bo*> all;
  return all;
}

gbm_bo* karst::fake::buffer_of(std::uint32_t handle) {
  const auto found = buffers().find(handle);
  return found != buffers().end() ? found->second : nullptr;
}

extern "C" {

// --- libgbm

static void make_buffer(gbm_bo& bo, std::uint32_t width, std::uint32_t height) {
  bo.width = width;
  bo.height = height;
  bo.taken = false;
  bo.handle = make_id();
  bo.rgba.resize(std::size_t{width} * height * 4);
  buffers()[bo.handle] = &bo;
}

gbm_device* gbm_create_device(int fd) {
  FAIL_NULL();
  return new gbm_device{fd};
}
void gbm_device_destroy(gbm_device* device) {
  delete device;
}
gbm_surface* gbm_surface_create(gbm_device*, std::uint32_t width, std::uint32_t height, std::uint32_t,
                                std::uint32_t) {
  FAIL_NULL();
  auto* surface = new gbm_surface{};
  surface->width = width;
  surface->height = height;
  for (gbm_bo& bo : surface->buffers) make_buffer(bo, width, height);
  return surface;
}
gbm_surface* gbm_surface_create_with_modifiers2(gbm_device* device, std::uint32_t width, std::uint32_t height,
                                                std::uint32_t format, const std::uint64_t*, unsigned,
                                                std::uint32_t use) {
  gbm_surface* surface = gbm_surface_create(device, width, height, format, use);
  if (surface != nullptr) surface->modifiers = true;
  return surface;
}
void gbm_surface_destroy(gbm_surface* surface) {
  for (gbm_bo& bo : surface->buffers) buffers().erase(bo.handle);
  delete surface;
}
gbm_bo* gbm_surface_lock_front_buffer(gbm_surface* surface) {
  FAIL_NULL();
  if (surface->front == nullptr) return nullptr;
  surface->front->taken = true;
  return surface->front;
}
void gbm_surface_release_buffer(gbm_surface*, gbm_bo* bo) {
  if (!bo->taken) {
    std::fprintf(stderr, "fake: a buffer is released twice\n");
    abort();
  }
  bo->taken = false;
}
int gbm_surface_has_free_buffers(gbm_surface* surface) {
  for (const gbm_bo& bo : surface->buffers) {
    if (!bo.taken) return 1;
  }
  return 0;
}
gbm_bo* gbm_bo_create(gbm_device*, std::uint32_t width, std::uint32_t height, std::uint32_t, std::uint32_t) {
  FAIL_NULL();
  auto* bo = new gbm_bo{};
  make_buffer(*bo, width, height);
  return bo;
}
gbm_bo* gbm_bo_create_with_modifiers2(gbm_device* device, std::uint32_t width, std::uint32_t height,
                                      std::uint32_t format, const std::uint64_t*, unsigned,
                                      std::uint32_t use) {
  return gbm_bo_create(device, width, height, format, use);
}
void gbm_bo_destroy(gbm_bo* bo) {
  buffers().erase(bo->handle);
  delete bo;
}
int gbm_bo_get_plane_count(gbm_bo*) {
  return 1;
}
std::uint64_t gbm_bo_get_modifier(gbm_bo*) {
  return kModifier;
}
union gbm_bo_handle gbm_bo_get_handle_for_plane(gbm_bo* bo, int) {
  gbm_bo_handle handle{};
  handle.u32 = bo->handle;
  return handle;
}
union gbm_bo_handle gbm_bo_get_handle(gbm_bo* bo) {
  return gbm_bo_get_handle_for_plane(bo, 0);
}
std::uint32_t gbm_bo_get_stride_for_plane(gbm_bo* bo, int) {
  return bo->width * 4;
}
std::uint32_t gbm_bo_get_stride(gbm_bo* bo) {
  return bo->width * 4;
}
std::uint32_t gbm_bo_get_offset(gbm_bo*, int) {
  return 0;
}
std::uint32_t gbm_bo_get_width(gbm_bo* bo) {
  return bo->width;
}
std::uint32_t gbm_bo_get_height(gbm_bo* bo) {
  return bo->height;
}

// --- libEGL: the GBM platform is the surfaceless one, and its windows are pbuffers

static gbm_surface* current_window = nullptr;
static std::uint32_t window_format = DRM_FORMAT_XRGB8888;

static EGLDisplay fake_platform_display(EGLenum platform, void* native, const EGLint* attributes) {
  const auto get = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(
      real<decltype(&eglGetProcAddress)>("eglGetProcAddress")("eglGetPlatformDisplayEXT"));
  if (platform == EGL_PLATFORM_GBM_KHR)
    return get(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  return get(platform, native, attributes);
}
static GLenum fake_reset_status() {
  return state().reset ? GL_OUT_OF_MEMORY : GL_NO_ERROR;
}

__eglMustCastToProperFunctionPointerType eglGetProcAddress(const char* name) {
  if (strcmp(name, "eglGetPlatformDisplayEXT") == 0) {
    return reinterpret_cast<__eglMustCastToProperFunctionPointerType>(fake_platform_display);
  }
  if (strcmp(name, "glGetGraphicsResetStatusKHR") == 0) {
    return reinterpret_cast<__eglMustCastToProperFunctionPointerType>(fake_reset_status);
  }
  return real<decltype(&eglGetProcAddress)>("eglGetProcAddress")(name);
}
const char* eglQueryString(EGLDisplay display, EGLint name) {
  static std::string client;
  const char* text = real<decltype(&eglQueryString)>("eglQueryString")(display, name);
  if (display != EGL_NO_DISPLAY || name != EGL_EXTENSIONS) return text;
  client = std::string(text != nullptr ? text : "") + " EGL_KHR_platform_gbm";
  return client.c_str();
}
EGLBoolean eglChooseConfig(EGLDisplay display, const EGLint* attributes, EGLConfig* configs, EGLint size,
                           EGLint* count) {
  std::vector<EGLint> changed;
  for (; *attributes != EGL_NONE; attributes += 2) {
    changed.push_back(attributes[0]);
    changed.push_back(attributes[0] == EGL_SURFACE_TYPE ? EGL_PBUFFER_BIT : attributes[1]);
  }
  for (const EGLint more : {EGL_RED_SIZE, 8, EGL_GREEN_SIZE, 8, EGL_BLUE_SIZE, 8, EGL_NONE})
    changed.push_back(more);
  return real<decltype(&eglChooseConfig)>("eglChooseConfig")(display, changed.data(), configs, size, count);
}
EGLBoolean eglGetConfigAttrib(EGLDisplay display, EGLConfig config, EGLint name, EGLint* value) {
  if (name != EGL_NATIVE_VISUAL_ID) {
    return real<decltype(&eglGetConfigAttrib)>("eglGetConfigAttrib")(display, config, name, value);
  }
  if (state().format565) window_format = DRM_FORMAT_RGB565;
  *value = static_cast<EGLint>(window_format);
  return EGL_TRUE;
}
EGLSurface eglCreateWindowSurface(EGLDisplay display, EGLConfig config, EGLNativeWindowType window,
                                  const EGLint*) {
  auto* surface = reinterpret_cast<gbm_surface*>(window);
  current_window = surface;
  const EGLint attributes[] = {EGL_WIDTH, static_cast<EGLint>(surface->width), EGL_HEIGHT,
                               static_cast<EGLint>(surface->height), EGL_NONE};
  return eglCreatePbufferSurface(display, config, attributes);
}
EGLBoolean eglSwapBuffers(EGLDisplay, EGLSurface) {
  gbm_bo* next = nullptr;
  for (gbm_bo& bo : current_window->buffers) {
    if (!bo.taken && next == nullptr) next = &bo;
  }
  if (next == nullptr) return EGL_FALSE;
  current_window->front = next;
  const std::size_t row = std::size_t{next->width} * 4;
  std::vector<std::uint8_t> pixels(next->rgba.size());
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glReadPixels(0, 0, static_cast<GLsizei>(next->width), static_cast<GLsizei>(next->height), GL_RGBA,
               GL_UNSIGNED_BYTE, pixels.data());
  for (std::uint32_t y = 0; y < next->height; ++y) {
    std::copy_n(pixels.begin() + static_cast<std::ptrdiff_t>((next->height - 1 - y) * row), row,
                next->rgba.begin() + static_cast<std::ptrdiff_t>(y * row));
  }
  return EGL_TRUE;
}

}  // extern "C"
