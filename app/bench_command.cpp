// SPDX-License-Identifier: MIT
// karst bench: what a world costs.
#include <cstdio>
#include <string>

#include "app/bench_core.h"
#include "app/commands.h"
#include "app/common/arguments.h"
#include "app/common/mapped_file.h"
#include "app/status_text.h"
#include "terrain/world/world_file.h"

namespace karst::app {
namespace {

constexpr const char* kHelp =
    R"(usage: karst bench WORLD [--suite core] [--rounds N] [--json]

Measures the core on a world and prints the results beside those of the paper it follows.

      --suite core  extraction, adjacency, vertices and packing of all patches, on one core
      --rounds N    medians are over so many rounds, 1 to 1000 (9)
      --json        for programs

  karst bench canyon.karst
)";

constexpr Option kOptions[] = {{"suite"}, {"rounds"}, {"json", 0, false}, {"help", 'h', false}};

std::string parse(std::span<const char* const> words, Arguments& arguments, std::int64_t& rounds) {
  if (std::string error = arguments.parse(words, kOptions); !error.empty()) return error;
  if (arguments.has("help")) return {};
  if (arguments.positional().size() != 1) return "takes one WORLD";
  if (const auto suite = arguments.value("suite").value_or("core"); suite != "core") {
    return "--suite: '" + std::string(suite) + "' is not core";
  }
  if (const auto text = arguments.value("rounds")) return parse_integer(*text, "--rounds", 1, 1000, rounds);
  return {};
}

}  // namespace

int run_bench(std::span<const char* const> words) {
  Arguments arguments;
  CoreSuiteOptions options;
  std::int64_t rounds = options.rounds;
  if (const std::string usage = parse(words, arguments, rounds); !usage.empty()) {
    print_error("karst bench", usage);
    return kExitUsage;
  }
  if (arguments.has("help")) {
    std::fputs(kHelp, stdout);
    return kExitOk;
  }
  options.rounds = static_cast<int>(rounds);
  options.json = arguments.has("json");
  const std::string path(arguments.positional()[0]);
  MappedFile file;
  std::string error = file.open(path);
  WorldInfo info;
  if (error.empty()) {
    if (const Status status = read_world_info(file.bytes(), info); !status.ok())
      error = status_text(path, status);
  }
  if (!error.empty()) {
    print_error("karst bench", error);
    return kExitFailure;
  }
  return run_core_suite(file.bytes(), options);
}

}  // namespace karst::app
