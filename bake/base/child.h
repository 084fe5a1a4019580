// SPDX-License-Identifier: MIT
// Work on bytes that nobody can trust, by libraries that do not bound what they take: in a process of its own
// with a limit on memory and on time. What goes wrong there is an error here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "platform/base/error.h"

namespace karst::bake {

struct ChildLimits {
  std::uint64_t memory_bytes = 256u << 20;  // that the work may take on top of what this process has
  unsigned cpu_seconds = 30;                // and four times as long where it does nothing
  std::size_t result_bytes = 0;             // the most that comes back
};

// Fills result, or tells why not. Runs in the child, whose standard error goes nowhere.
using ChildWork = std::function<Error(std::vector<std::byte>& result)>;

// Runs work in a copy of this process and waits for it; result is what it filled, empty on an error. subject:
// the file, for messages of a child that died; those of work are handed on as they are. To be called while
// this process has one thread. Under AddressSanitizer and ThreadSanitizer, whose shadow is larger than any
// limit, memory has none.
Error run_in_child(const std::string& subject, const ChildLimits& limits, const ChildWork& work,
                   std::vector<std::byte>& result);

}  // namespace karst::bake
