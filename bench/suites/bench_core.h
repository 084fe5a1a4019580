// SPDX-License-Identifier: MIT
// `karst-bench WORLD --suite core`: what the CPU side costs, beside K's tables 5.6 - 5.9.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace karst::bench {

struct CoreSuiteOptions {
  int rounds = 9;    // medians are over these; at least 1
  std::string json;  // file for programs, "-": printed in place of the table; empty: none
};

// Prints to stdout. file: a world file that WorldReader::verify() has accepted.
// Returns the exit code; errors go to stderr.
int run_core_suite(std::span<const std::byte> file, const CoreSuiteOptions& options);

}  // namespace karst::bench
