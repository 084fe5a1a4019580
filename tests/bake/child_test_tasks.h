// SPDX-License-Identifier: MIT
// What children of these tests do, well and badly. A request is a number.
#pragma once

#include <cstdint>
#include <span>

#include "bake/base/child.h"

namespace karst::bake {

extern const ChildTask kTellProcess;  // its process
extern const ChildTask kCount;        // so many bytes, k % 251
extern const ChildTask kFail;         // with an error of its own
extern const ChildTask kThrow;        // what libraries may throw
extern const ChildTask kRaise;        // that signal, of itself
extern const ChildTask kLeave;        // as if all were well, without a word
extern const ChildTask kSpin;         // for ever
extern const ChildTask kTake;         // so many MiB, and hands back 64 bytes
extern const ChildTask kTellLimits;   // ToldLimits

struct ToldLimits {
  std::uint64_t cpu_seconds = 0;    // more than it had used when the task began, rounded
  std::uint64_t clock_seconds = 0;  // until it is ended
};

std::span<const ChildTask> child_test_tasks();

}  // namespace karst::bake
