// SPDX-License-Identifier: MIT
#include "tests/bench/bench.h"

#include <cstdio>
#include <cstring>

namespace karst::core::bench {

std::vector<Bench>& all() {
  static std::vector<Bench> benches;
  return benches;
}

}  // namespace karst::core::bench

int main(int argc, char** argv) {
  using karst::core::bench::Bench;
  bool smoke = false;
  std::vector<const char*> names;
  for (int n = 1; n < argc; ++n) {
    if (std::strcmp(argv[n], "--smoke") == 0) {
      smoke = true;
    } else {
      names.push_back(argv[n]);
    }
  }
  for (const char* name : names) {
    const auto same = [&](const Bench& b) { return std::strcmp(b.name, name) == 0; };
    const auto& benches = karst::core::bench::all();
    if (std::any_of(benches.begin(), benches.end(), same)) continue;
    std::fprintf(stderr, "karst_bench_core: no benchmark named '%s'\n", name);
    return 2;
  }
  int result = 0;
  for (const Bench& bench : karst::core::bench::all()) {
    const auto same = [&](const char* name) { return std::strcmp(bench.name, name) == 0; };
    if (names.empty() || std::any_of(names.begin(), names.end(), same)) result |= bench.run(smoke);
  }
  return result;
}
