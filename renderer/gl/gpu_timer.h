// SPDX-License-Identifier: MIT
// GPU time of one pass a frame, with EXT_disjoint_timer_query. Results arrive some frames late; nothing waits
// for them.
#pragma once

#include <cstdint>

#include "renderer/gl/gl.h"
#include "renderer/gl/gl_caps.h"

namespace karst::core {

class GpuTimer {
 public:
  // Without the extension all calls do nothing. Needs a complete framebuffer with depth to be bound.
  void create(const Gl& gl, const GlCaps& caps);
  void destroy(const Gl& gl);
  void begin(const Gl& gl);
  void end(const Gl& gl);
  // Of the newest pass whose result is there, in milliseconds; NaN where none is.
  double latest_ms(const Gl& gl);

 private:
  // Frames that a GPU may lag behind; a frame that finds no free query is not timed.
  static constexpr std::uint32_t kQueries = 4;

  void collect(const Gl& gl);

  GLuint queries_[kQueries] = {};
  std::uint64_t begun_ = 0;      // passes timed so far
  std::uint64_t collected_ = 0;  // of these, passes whose result was read
  double latest_ms_ = -1;        // negative: none
  bool supported_ = false;
  bool running_ = false;
};

}  // namespace karst::core
