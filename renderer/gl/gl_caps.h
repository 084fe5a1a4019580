// SPDX-License-Identifier: MIT
// The one home of knowledge about the device: limits, extensions, and what to do about them. Nothing else
// asks the driver what it can do.
#pragma once

#include <cstdint>

#include "karst/status.h"
#include "renderer/gl/gl.h"

namespace karst::core {

struct GlCaps {
  // Strings of the driver, cut to fit.
  char vendor[64] = {};
  char renderer[128] = {};
  char version[128] = {};

  std::int32_t max_texture_size = 0;       // texels; at least 2048 in ES 3.0
  std::int32_t max_renderbuffer_size = 0;  // pixels
  std::int32_t max_viewport[2] = {0, 0};   // pixels
  std::int64_t max_element_index = 0;      // at least 2^24 - 1 in ES 3.0

  bool debug = false;        // KHR_debug: labels, groups, messages
  bool timer_query = false;  // EXT_disjoint_timer_query

  // Bugs. Each has a test in tests/gl/driver_bugs_test.cpp that tells when it is gone.
  //
  // llvmpipe of Mesa 22.3: the first timer query of a context in which something is drawn gives the time
  // since the machine's start. A query that nobody looks at takes that result.
  bool first_timer_result_is_wrong = false;
};

// unsupported where the context is not OpenGL ES 3.0 or later. Needs a current context.
Status query_gl_caps(const Gl& gl, GlCaps& caps);

}  // namespace karst::core
