// SPDX-License-Identifier: MIT
// A GLES 3.0 context on a GBM device, and the EGL surface over a GBM surface that comes and goes with the
// screen's mode.
#pragma once

#include <gbm.h>

#include <cstdint>

#include "platform/base/error.h"
#include "platform/egl_api.h"

namespace karst {

class GbmContext {
 public:
  explicit GbmContext(const EglApi& egl) : egl_(egl) {}
  GbmContext(const GbmContext&) = delete;
  GbmContext& operator=(const GbmContext&) = delete;
  ~GbmContext() { close(); }

  // format: of GBM_FORMAT_*, what the surfaces will have. Asks for a context that tells when it is lost,
  // where the driver has such.
  Error open(gbm_device* device, std::uint32_t format);
  void close();
  bool is_open() const { return context_ != EGL_NO_CONTEXT; }

  // Replaces the surface, and makes it and the context current.
  Error set_surface(gbm_surface* surface);
  // Before a GBM surface is destroyed. The context stays current where the driver allows that without a
  // surface.
  void drop_surface();
  Error make_current();

  enum class Swapped { done, context_lost, failed };
  // error is set unless it is done.
  Swapped swap(Error& error);
  // Address of a GL function, null where the driver has none.
  auto function(const char* name) const { return egl_.get_proc_address(name); }

 private:
  Error choose_config(std::uint32_t format);
  Error failure(const char* function) const;

  EglApi egl_;
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLConfig config_ = nullptr;
  EGLContext context_ = EGL_NO_CONTEXT;
  EGLSurface surface_ = EGL_NO_SURFACE;
  bool surfaceless_ = false;
};

}  // namespace karst
