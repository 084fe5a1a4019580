// SPDX-License-Identifier: MIT
#include "platform/base/clock.h"

#include <time.h>

namespace karst {

std::int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

}  // namespace karst
