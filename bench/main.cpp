// SPDX-License-Identifier: MIT
// karst-bench: what worlds and frames cost on this machine.
#include <exception>
#include <span>

#include "app/common/arguments.h"
#include "bench/command/bench_command.h"
#include "platform/base/freed_memory.h"

int main(int argc, char** argv) {
  using namespace karst;
  app::keep_standard_files();
  keep_freed_memory();
  try {
    const std::span<char* const> all(argv, static_cast<std::size_t>(argc));
    const std::span<const char* const> words(all.empty() ? nullptr : all.data() + 1,
                                             all.empty() ? 0 : all.size() - 1);
    const int code = bench::run_bench(words);
    if (code != app::kExitOk) return code;
    if (const Error error = app::flush_output(); !error.ok()) {
      app::print_error("karst-bench", error.text());
      return app::kExitFailure;
    }
    return code;
  } catch (const std::exception& e) {  // of the standard library: no memory
    app::print_error("karst-bench", e.what());
    return app::kExitFailure;
  }
}
