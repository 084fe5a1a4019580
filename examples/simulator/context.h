// SPDX-License-Identifier: MIT
// The simulator's own OpenGL ES context and framebuffer, without a window.
#pragma once

namespace simulator {

class Context {
 public:
  // False, with a line on standard error, where there is no EGL display or OpenGL ES 3.0.
  [[nodiscard]] bool open(int width, int height);
  // Binds the framebuffer for drawing and clears colour and depth.
  void begin(const float (&rgb)[3]) const;
  // Writes what was drawn as a PPM picture.
  [[nodiscard]] bool write(const char* path) const;

  // For karst::GlLoader.
  static void (*load(void* user, const char* name))();

 private:
  int width_ = 0, height_ = 0;
  unsigned framebuffer_ = 0;
};

}  // namespace simulator
