// SPDX-License-Identifier: MIT
// The command line of karst-bench: takes the words behind the program's name and returns the exit code.
#pragma once

#include <span>

namespace karst::bench {

int run_bench(std::span<const char* const> words);

}  // namespace karst::bench
