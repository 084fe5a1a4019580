// SPDX-License-Identifier: MIT
// Clocks of the system in milliseconds; only differences mean something.
#pragma once

#include <ctime>

namespace karst::bench {

// clock: CLOCK_MONOTONIC, CLOCK_THREAD_CPUTIME_ID, CLOCK_PROCESS_CPUTIME_ID, CLOCK_BOOTTIME.
inline double clock_ms(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

}  // namespace karst::bench
