// SPDX-License-Identifier: MIT
// karst-bench: what worlds and frames cost on this machine.
#include <cstdio>
#include <exception>
#include <span>

#include "app/common/arguments.h"
#include "bench/command/bench_command.h"
#include "platform/base/freed_memory.h"

int main(int argc, char** argv) {
  using namespace karst;
  keep_freed_memory();
  try {
    const std::span<char* const> all(argv, static_cast<std::size_t>(argc));
    const std::span<const char* const> words(all.empty() ? nullptr : all.data() + 1,
                                             all.empty() ? 0 : all.size() - 1);
    const int code = bench::run_bench(words);
    if (std::fflush(stdout) != 0 && code == app::kExitOk) {
      app::print_error("karst-bench", "standard output: cannot write");
      return app::kExitFailure;
    }
    return code;
  } catch (const std::exception& e) {  // of the standard library: no memory
    app::print_error("karst-bench", e.what());
    return app::kExitFailure;
  }
}
