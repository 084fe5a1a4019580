// SPDX-License-Identifier: MIT
// How often the functions of GL are called and how long the calls take, on this thread's clock: what a driver
// costs, function by function. A call is timed with two looks at the clock, about 50 ns.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "platform/display.h"

namespace karst::bench {

struct GlCallTimes {
  const char* name = "";  // without "gl"
  std::uint64_t calls = 0;
  double ms = 0;  // of all of them, by the clock
};

// Stands for a display and times what its functions of GL take. GL's functions have no context pointer, so
// the times are of all such displays. The display is borrowed and must outlive this.
class TimedDisplay final : public Display {
 public:
  explicit TimedDisplay(Display& display) : display_(display) {}
  Error make_current() override { return display_.make_current(); }
  Size size() const override { return display_.size(); }
  Error present() override { return display_.present(); }
  GlFunction gl_function(const char* name) const override;
  const std::string& name() const override { return display_.name(); }

 private:
  Display& display_;
};

// Forgets what was timed so far.
void reset_gl_times();
// Functions that were called since, those first that took longest.
std::vector<GlCallTimes> gl_times();

}  // namespace karst::bench
