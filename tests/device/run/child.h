// SPDX-License-Identifier: MIT
// Programs that may crash, hang or start others: run to an end in any case, line by line.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace karst::device {

struct ChildLimits {
  double silence_s = 600;  // without a line of output
  double total_s = 36000;
};

struct ChildResult {
  enum class End : std::uint8_t { exited, crashed, timed_out, interrupted, not_started };
  End end = End::not_started;
  int code = -1;  // exit code, or the signal's number
  double seconds = 0;
  std::uint64_t peak_bytes = 0;  // of memory, the largest of it and of what it started
  bool ok() const { return end == End::exited && code == 0; }
};

// "exit code 1", "crashed (signal 11)", ...; empty where ok().
std::string how_it_ended(const ChildResult& result);

// words[0] is the program. environment: "NAME=value", on top of this process's. Each line of its output and
// errors goes to on_line, without its newline. At a limit, or after interrupt_children(), it is killed with
// all that it started.
using OnLine = std::function<void(std::string_view line)>;
ChildResult run_child(const std::vector<std::string>& words, const std::vector<std::string>& environment,
                      const ChildLimits& limits, const OnLine& on_line);

// For signal handlers: ends the child that runs now and each that is started later.
void interrupt_children();
bool interrupted();

}  // namespace karst::device
