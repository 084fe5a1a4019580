// SPDX-License-Identifier: MIT
// The one home of knowledge about the device: limits, extensions, and what to do about them. Nothing else
// asks the driver what it can do, and nothing asks during a frame.
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

  bool desktop = false;     // OpenGL instead of OpenGL ES
  std::int32_t number = 0;  // 10 times the version: 30, 32, 45

  std::int32_t max_texture_size = 0;      // texels; at least 2048 in ES 3.0
  std::int32_t max_viewport[2] = {0, 0};  // pixels
  std::int64_t max_element_index = 0;     // at least 2^24 - 1 in ES 3.0
  std::int32_t max_texture_units = 0;     // of all stages; at least 32 in ES 3.0
  std::int32_t max_uniform_bindings = 0;  // at least 24 in ES 3.0

  bool software = false;     // a processor renders
  bool debug = false;        // KHR_debug: labels, groups, messages
  bool timer_query = false;  // EXT_disjoint_timer_query
  // Places at most that a lookup mixes along a pixel's longer side, EXT_texture_filter_anisotropic; 1:
  // without.
  std::int32_t max_anisotropy = 1;

  // State that OpenGL ES 3.0 does not have and a host may have set.
  bool clip_control = false;            // EXT_clip_control
  bool depth_clamp = false;             // EXT_depth_clamp
  bool srgb_switch = false;             // EXT_sRGB_write_control
  bool polygon_mode = false;            // NV_polygon_mode
  bool multisample_switch = false;      // EXT_multisample_compatibility
  bool sample_mask = false;             // ES 3.1
  bool sample_shading = false;          // ES 3.2
  std::int32_t max_clip_distances = 0;  // EXT_clip_cull_distance, APPLE_clip_distance

  // Bugs. Each has a test in tests/gl/driver_bugs_test.cpp that tells when it is gone.
  //
  // llvmpipe of Mesa 22.3: the first timer query of a context in which something is drawn gives the time
  // since the machine's start. A query that nobody looks at takes that result.
  bool first_timer_result_is_wrong = false;
  // llvmpipe: of a run of triangles some of which are clipped, back faces are dropped by their corners as
  // they are, and pixels are covered by corners that are rounded to its grid. What faces the eye by those
  // alone is lost, and no neighbour covers its pixels: a hole of one.
  bool culls_unrounded = false;
};

// Needs a current context. unsupported where it is not OpenGL ES 3.0 or later, or, with desktop, not OpenGL
// 4.3 or later with ARB_ES3_compatibility.
Status query_gl_caps(const Gl& gl, bool desktop, GlCaps& caps);

}  // namespace karst::core
