// SPDX-License-Identifier: MIT
// A window of the desktop (X11 or Wayland), through SDL2: an optional component (window/, KARST_WINDOW in
// CMake) that the program karst-window has. In karst, the board program, this fails and says so.
#pragma once

#include <memory>
#include <string>

#include "platform/display.h"
#include "platform/input.h"

namespace karst {

// On failure returns null, and error is one line.
std::unique_ptr<Display> open_window_display(Display::Size size, const char* title, Error& error);

}  // namespace karst
