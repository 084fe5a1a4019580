// SPDX-License-Identifier: MIT
// A window of the desktop (X11 or Wayland), through SDL2. An optional component: KARST_WINDOW in CMake. Board
// builds leave it out, and open_window_display() then says so.
#pragma once

#include <memory>
#include <string>

#include "platform/display.h"
#include "platform/input.h"

namespace karst {

// On failure returns null, and error is one line. input: what is typed and pointed at in the window; lives as
// long as the display.
std::unique_ptr<Display> open_window_display(Display::Size size, const char* title, std::string& error);

}  // namespace karst
