// SPDX-License-Identifier: MIT
// `karst-bench WORLD --suite queries`: what questions about the surface cost one thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace karst::bench {

struct QuerySuiteOptions {
  int rounds = 9;               // medians are over these; at least 1
  int level = 3;                // of the surface, 1..6; cut to the world's
  std::uint32_t patches = 0;    // that are kept ready; 0: all of the world's
  std::uint32_t rays = 65'536;  // of a batch, 1024..2^24
};

// Prints to stdout. file: a valid world file (WorldReader::verify has accepted it).
// Returns the exit code; errors go to stderr.
int run_query_suite(std::span<const std::byte> file, const QuerySuiteOptions& options);

}  // namespace karst::bench
