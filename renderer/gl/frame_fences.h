// SPDX-License-Identifier: MIT
// Keeps at most kFramesInFlight frames under way: before anything of frame n is uploaded or drawn, frame n -
// kFramesInFlight is complete.
#pragma once

#include <cstdint>

#include "renderer/gl/gl.h"
#include "terrain/base/config.h"

namespace karst::core {

class FrameFences {
 public:
  // Before the first upload or pass of a frame; later calls do nothing.
  void wait(const Gl& gl) {
    GLsync& fence = fences_[frame_ % kFramesInFlight];
    if (fence == nullptr) return;
    constexpr GLuint64 kHangs = 1'000'000'000;  // ns; a GPU that takes longer is reset by its driver
    gl.ClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, kHangs);
    gl.DeleteSync(fence);
    fence = nullptr;
  }
  void end_frame(const Gl& gl) {
    wait(gl);  // a frame in which nothing was done
    fences_[frame_++ % kFramesInFlight] = gl.FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  }
  void destroy(const Gl& gl) {
    for (const GLsync fence : fences_) {
      if (fence != nullptr) gl.DeleteSync(fence);
    }
    forget();
  }
  void forget() {
    for (GLsync& fence : fences_) fence = nullptr;
  }

 private:
  std::uint64_t frame_ = 0;
  GLsync fences_[kFramesInFlight] = {};  // of the last frames, by frame
};

}  // namespace karst::core
