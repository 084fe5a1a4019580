// SPDX-License-Identifier: MIT
// karst-bench: what worlds and frames cost on this machine.
#include "app/common/arguments.h"
#include "bench/command/bench_command.h"

int main(int argc, char** argv) {
  return karst::app::run_program("karst-bench", argc, argv, karst::bench::run_bench);
}
