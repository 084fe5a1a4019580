// SPDX-License-Identifier: MIT
// karst, the board program: draws worlds that karst-bake made.
#include <cstdio>
#include <exception>
#include <span>
#include <string>
#include <string_view>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "app/commands.h"
#include "app/common/arguments.h"

namespace karst::app {
namespace {

constexpr const char* kHelp =
    R"(usage: karst COMMAND ...

  view WORLD     show a world on a display or in a window
  render WORLD   draw pictures of a world
  info WORLD     say what a world file holds
  budget         say what memory a world takes

karst COMMAND --help tells more; karst --version prints the version.

  karst-bake --sample canyon -o canyon.karst
  karst render canyon.karst -o canyon.png
)";

struct Command {
  std::string_view name;
  int (*run)(std::span<const char* const> words);
};
constexpr Command kCommands[] = {
    {"view", run_view}, {"render", run_render}, {"info", run_info}, {"budget", run_budget}};

// A software driver takes a frame's working memory from the heap and frees it when the frame is drawn. By
// default glibc gives the end of the heap back to the kernel each time, and the next frame faults it in page
// by page. Memory that was once needed is kept instead; the most that is ever used does not change.
void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_TRIM_THRESHOLD, 256 << 20);  // bytes
  mallopt(M_MMAP_THRESHOLD, 4 << 20);    // far above what a frame takes at once, below what is taken to stay
#endif
}

int run(std::span<const char* const> words) {
  if (words.empty()) {
    std::fputs(kHelp, stderr);
    return kExitUsage;
  }
  const std::string_view name = words[0];
  if (name == "--help" || name == "-h" || name == "help") {
    std::fputs(kHelp, stdout);
    return kExitOk;
  }
  if (name == "--version") {
    std::puts("karst " KARST_VERSION);
    return kExitOk;
  }
  for (const Command& command : kCommands) {
    if (command.name == name) return command.run(words.subspan(1));
  }
  print_error("karst", "unknown command '" + std::string(name) + "'; see karst --help");
  return kExitUsage;
}

}  // namespace
}  // namespace karst::app

int main(int argc, char** argv) {
  using namespace karst::app;
  keep_freed_memory();
  try {
    const std::span<char* const> all(argv, static_cast<std::size_t>(argc));
    const std::span<const char* const> words(all.empty() ? nullptr : all.data() + 1,
                                             all.empty() ? 0 : all.size() - 1);
    const int code = run(words);
    // Results that did not reach their reader are a failure (a full disk, a closed pipe).
    if (std::fflush(stdout) != 0 && code == kExitOk) {
      print_error("karst", "standard output: cannot write");
      return kExitFailure;
    }
    return code;
  } catch (const std::exception& e) {  // of the standard library: no memory
    print_error("karst", e.what());
    return kExitFailure;
  }
}
