// SPDX-License-Identifier: MIT
// For programs without windows. One that has them is linked with the objects of sdl_window.cpp, which then
// answer instead.
#include "platform/window/window_display.h"

namespace karst {

std::unique_ptr<Display> open_window_display(Display::Size /*size*/, const char* /*title*/, Error& error) {
  error = "--window: this program is for bare screens; karst-window has windows (KARST_WINDOW in CMake)";
  return nullptr;
}

}  // namespace karst
