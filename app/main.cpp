// SPDX-License-Identifier: MIT
// karst, the board program: draws worlds that karst-bake made.
#include <cstdio>
#include <span>
#include <string>
#include <string_view>

#include "app/commands.h"
#include "app/common/arguments.h"
#include "platform/base/text.h"

namespace karst::app {
namespace {

struct Command {
  const CommandSpec* spec;
  int (*run)(std::span<const char* const> words);
};
constexpr Command kCommands[] = {
#ifndef KARST_NO_VIEW  // tests/device: no libraries of screens and seats
    {&kViewSpec, run_view},
#endif
    {&kRenderSpec, run_render},
    {&kInfoSpec, run_info},
    {&kEditSpec, run_edit},
    {&kBudgetSpec, run_budget}};

// The command's own word: "view" of "karst view".
std::string_view word_of(const Command& command) {
  return std::string_view(command.spec->name).substr(std::string_view("karst ").size());
}

void print_help(std::FILE* file) {
  std::fputs("usage: karst COMMAND ...\n\n", file);
  for (const Command& command : kCommands)
    std::fprintf(file, "  %-12.12s %s\n", std::string(word_of(command)).c_str(), command.spec->brief);
  std::fputs(R"(
karst COMMAND --help tells more; karst --version prints the version.

  karst-bake --sample canyon -o canyon.karst
  karst render canyon.karst -o canyon.png
)",
             file);
}

int run(std::span<const char* const> words) {
  if (words.empty()) {
    print_help(stderr);
    return kExitUsage;
  }
  const std::string_view name = words[0];
  if (name == "--help" || name == "-h" || name == "help") {
    print_help(stdout);
    return kExitOk;
  }
  if (name == "--version") {
    std::puts("karst " KARST_VERSION);
    return kExitOk;
  }
  for (const Command& command : kCommands) {
    if (word_of(command) == name) return command.run(words.subspan(1));
  }
  print_error("karst", "unknown command " + quote(name) + "; see karst --help");
  return kExitUsage;
}

}  // namespace
}  // namespace karst::app

int main(int argc, char** argv) {
  return karst::app::run_program("karst", argc, argv, karst::app::run);
}
