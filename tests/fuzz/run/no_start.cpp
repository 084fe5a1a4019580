// SPDX-License-Identifier: MIT
// Of targets that work in their own process.
#include "tests/fuzz/run/fuzz_target.h"

namespace karst {

void start_target(std::span<char* const>) {}

}  // namespace karst
