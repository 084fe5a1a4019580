// SPDX-License-Identifier: MIT
// GPU time of a pass, with EXT_disjoint_timer_query or OpenGL's timer queries. Results arrive some frames
// late; nothing waits for them.
#pragma once

#include <cstdint>

#include "renderer/gl/gl.h"
#include "renderer/gl/gl_caps.h"

namespace karst::core {

class GpuTimer {
 public:
  // Without the extension all calls do nothing. Unbinds the framebuffer; needs state of enter_upload().
  void create(const Gl& gl, const GlCaps& caps);
  void destroy(const Gl& gl);
  // The context is gone, and the queries with it.
  void forget();
  // Of a pass. A pass that finds no free query is not timed: latest_ms() makes them free.
  void begin(const Gl& gl);
  void end(const Gl& gl);
  // Of the newest pass whose result is there, in milliseconds; NaN where none is. Asks the driver.
  double latest_ms(const Gl& gl);

 private:
  // Passes that a GPU may lag behind.
  static constexpr std::uint32_t kQueries = 4;

  void waste_result(const Gl& gl);
  void collect(const Gl& gl);

  GLuint queries_[kQueries] = {};
  std::uint64_t begun_ = 0;      // passes timed so far
  std::uint64_t collected_ = 0;  // of these, passes whose result was read
  double latest_ms_ = -1;        // negative: none
  bool desktop_ = false;
  bool supported_ = false;
  bool running_ = false;
};

}  // namespace karst::core
