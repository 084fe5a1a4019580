// SPDX-License-Identifier: MIT
// Where pictures go: a GLES 3.0 context and, on a display with a screen, the way to show a frame.
//
// A display with a screen comes and goes: monitors are unplugged, other programs take the screen, the machine
// sleeps. The program calls dispatch() whenever a descriptor of poll_fds() is readable or deadline_ns() has
// come, draws when ready() says so, and makes its GL objects anew when it is told that they are gone.
#pragma once

#include <poll.h>

#include <cstdint>
#include <span>
#include <string>

#include "platform/base/error.h"
#include "platform/frame_times.h"
#include "platform/input.h"

namespace karst {

class Display {
 public:
  struct Size {
    int width = 0;  // pixels; 0 x 0: the display has no framebuffer of its own, draw into an object
    int height = 0;
    friend bool operator==(const Size&, const Size&) = default;
  };
  using GlFunction = void (*)();

  // What dispatch() found. All of it may be set at once.
  struct Changes {
    bool rebuild = false;  // the size or the context is new: GL objects made before are of no use
    bool redraw = false;   // the screen does not show the last picture any more
    bool quit = false;     // the user closed the window
  };

  static constexpr std::int64_t kNever = INT64_MAX;

  Display() = default;
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;
  virtual ~Display() = default;

  // Makes the context current on the calling thread.
  virtual Error make_current() = 0;
  virtual Size size() const = 0;
  // Shows what framebuffer 0 holds; without a screen there is nothing to do. Takes 100 ms at most beyond the
  // driver's own work. Where the screen is lost just now it does nothing: dispatch() tells what comes next.
  virtual Error present() = 0;
  // Address of a GL function, null where the driver has none. Any name may be asked for: what an extension
  // adds is only usable where the extension is advertised, whatever address this gives.
  virtual GlFunction gl_function(const char* name) const = 0;
  // How the context was reached, for reports: "surfaceless", "EGL device 0".
  virtual const std::string& name() const = 0;

  // Handles what has arrived; never blocks.
  virtual Changes dispatch() { return {}; }
  // Whether a frame that is drawn now can be shown: there is a context, an output and a free buffer.
  virtual bool ready() const { return true; }
  // Writes the descriptors to wait for; returns how many (kMostFds at most, and no more than out holds).
  static constexpr std::size_t kMostFds = 8;
  virtual std::size_t poll_fds(std::span<pollfd> /*out*/) const { return 0; }
  // When dispatch() must be called at the latest, on the clock of now_ns().
  virtual std::int64_t deadline_ns() const { return kNever; }
  // Counter-clockwise turns by 90 degrees that the picture must be drawn with to stand upright on the screen.
  virtual int quarter_turns() const { return 0; }
  // Time between two refreshes of the screen; 0 where it is not known.
  virtual std::int64_t refresh_ns() const { return 0; }
  // What is typed and pointed at in a window; null for displays that have no input of their own.
  virtual Input* input() { return nullptr; }
  // The program saw that the context is lost: everything is made anew at the next dispatch().
  virtual void context_lost() {}

  // Latency is counted from here: call it before reading the inputs that the frame shows.
  void begin_frame(std::int64_t now) { times_.begin(now); }
  const FrameTimes& times() const { return times_; }

 protected:
  FrameTimes times_;
};

}  // namespace karst
