// SPDX-License-Identifier: MIT
// Where pictures go: a GLES 3.0 context and, on a display with a screen, the way to show a frame.
// Functions that can fail return an empty string on success, else one line for the user.
#pragma once

#include <string>

namespace karst {

class Display {
 public:
  struct Size {
    int width = 0;  // pixels; 0 x 0: the display has no framebuffer of its own, draw into an object
    int height = 0;
  };
  using GlFunction = void (*)();

  Display() = default;
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;
  virtual ~Display() = default;

  // Makes the context current on the calling thread.
  [[nodiscard]] virtual std::string make_current() = 0;
  virtual Size size() const = 0;
  // Shows what framebuffer 0 holds; without a screen there is nothing to do.
  [[nodiscard]] virtual std::string present() = 0;
  // Address of a GL function, null where the driver has none. Any name may be asked for: what an extension
  // adds is only usable where the extension is advertised, whatever address this gives.
  virtual GlFunction gl_function(const char* name) const = 0;
  // How the context was reached, for reports: "surfaceless", "EGL device 0".
  virtual const std::string& name() const = 0;
};

}  // namespace karst
