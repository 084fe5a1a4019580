// SPDX-License-Identifier: MIT
// All tests of a GoogleTest program, to the end: where one crashes or hangs, it is noted and the rest is run
// without it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/device/run/child.h"

namespace karst::device {

struct NotedTest {
  std::string name;
  std::string message;  // what it printed, cut to fit: why it failed or was skipped
};

struct GtestResult {
  std::vector<std::string> passed;
  std::vector<NotedTest> failed, skipped;
  std::vector<std::string> not_run;  // because the program could not be brought to run them
  std::string problem;               // of the program as a whole; empty: none
  double seconds = 0;
  std::uint64_t peak_bytes = 0;
  bool ok() const { return failed.empty() && not_run.empty() && problem.empty(); }
};

// words: the program and its arguments, --gtest_filter included. on_test is told of each test that begins:
// how many ended before it, of how many.
using OnTest = std::function<void(const std::string& test, std::size_t done, std::size_t all)>;
GtestResult run_gtest(const std::vector<std::string>& words, const std::vector<std::string>& environment,
                      const ChildLimits& limits, const OnTest& on_test);

}  // namespace karst::device
