// SPDX-License-Identifier: MIT
// The display that options name, opened, watched and listed.
#pragma once

#include <memory>

#include "app/screen/screen_options.h"
#include "platform/base/error.h"
#include "platform/base/log.h"
#include "platform/display.h"

namespace karst::app {

// seat: of displays on a bare screen, which it must outlive; else null. window: the size of a window.
Error open_screen(const ScreenArguments& options, Display::Size window, const char* title,
                  ConsoleState& console, const LogLine& say, std::unique_ptr<Seat>& seat,
                  std::unique_ptr<Display>& display);

// Whether the context is lost, where the driver tells of it: GL_KHR_robustness. The address of its function
// alone says nothing; a driver without the extension gives none or one that always says that all is well.
class ContextWatch {
 public:
  // With the display's context current.
  void attach(const Display& display);
  bool is_lost() const { return status_ != nullptr && status_() != 0; }

 private:
  unsigned (*status_)() = nullptr;
};

// On a bare screen, and unless the options say no, the rest of the program runs in a process of its own
// (supervise()), and console is what both share. -1: go on; else the exit code.
int supervise_screen(const ScreenArguments& options, const LogLine& say, ConsoleState*& console);

// --list-outputs: prints connectors and modes; returns the exit code.
int print_outputs(const ScreenArguments& options, const LogLine& say);

}  // namespace karst::app
