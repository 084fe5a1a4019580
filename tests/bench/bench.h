// SPDX-License-Identifier: MIT
// The core's benchmarks: each file in this folder registers what it measures, bench_main.cpp runs them.
//   karst_bench_core [--smoke] [NAME...]    --smoke: small sizes, once, to see that they run
#pragma once

#include <time.h>

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

namespace karst::core::bench {

struct Bench {
  const char* name;
  int (*run)(bool smoke);  // prints its numbers; 0, or 1 where a result is wrong
};

std::vector<Bench>& all();

// Registers at program start: static const Register r{{"view", run_view}};
struct Register {
  explicit Register(Bench bench) { all().push_back(bench); }
};

struct Times {
  double median_ms = 0.0;
  double least_ms = 0.0;
};

// Calls work `repeats` (at least 1) times and times each call.
template <class Work>
Times measure(int repeats, Work&& work) {
  std::vector<double> ms;
  for (int n = 0; n < repeats; ++n) {
    const auto start = std::chrono::steady_clock::now();
    work();
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  std::sort(ms.begin(), ms.end());
  return {ms[ms.size() / 2], ms.front()};
}

// The thread's time on a core, which other programs take none of.
inline double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

// Of times that were taken apart.
inline Times times_of(std::vector<double> ms) {
  std::sort(ms.begin(), ms.end());
  return {ms[ms.size() / 2], ms.front()};
}

// As measure(), by time on a core.
template <class Work>
Times measure_cpu(int repeats, Work&& work) {
  std::vector<double> ms;
  for (int n = 0; n < repeats; ++n) {
    const double start = cpu_ms();
    work();
    ms.push_back(cpu_ms() - start);
  }
  return times_of(std::move(ms));
}

}  // namespace karst::core::bench
