// SPDX-License-Identifier: MIT
// Time for measuring: never set back by anyone.
#pragma once

#include <cstdint>

namespace karst {

// Nanoseconds of the monotonic clock; only differences mean something.
std::int64_t now_ns();

constexpr double ms_between(std::int64_t start_ns, std::int64_t end_ns) {
  return static_cast<double>(end_ns - start_ns) * 1e-6;
}

}  // namespace karst
