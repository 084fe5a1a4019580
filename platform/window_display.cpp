// SPDX-License-Identifier: MIT
#include "platform/window_display.h"

namespace karst {

#ifndef KARST_WINDOW
std::unique_ptr<Display> open_window_display(Display::Size /*size*/, const char* /*title*/,
                                             std::string& error) {
  error = "--window: this program was built without windows (KARST_WINDOW)";
  return nullptr;
}
#endif

}  // namespace karst
