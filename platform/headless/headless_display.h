// SPDX-License-Identifier: MIT
// A GLES 3.0 context without a screen: through EGL_MESA_platform_surfaceless, else through the first device
// of EGL_EXT_platform_device that gives one.
#pragma once

#include <memory>
#include <string>

#include "platform/display.h"
#include "platform/egl_api.h"

namespace karst {

struct HeadlessOptions {
  // Asks for a debug context (EGL 1.5 or EGL_KHR_create_context), in which a driver reports more through
  // KHR_debug.
  bool debug = false;
};

// The context is current on the calling thread on success. On failure returns null, and error is one line
// that names everything that was tried and why each failed.
std::unique_ptr<Display> open_headless_display(const HeadlessOptions& options, Error& error,
                                               const EglApi& egl = linked_egl());

}  // namespace karst
