// SPDX-License-Identifier: MIT
// karst-ig: an image generator that a simulator drives by CIGI.
#include <cstdio>
#include <span>
#include <string>
#include <string_view>

#include "app/command_line/help.h"
#include "app/command_line/manual.h"
#include "app/common/arguments.h"
#include "ig/program/generator.h"
#include "platform/base/clock.h"

namespace karst::ig {
namespace {

// All that this program says while it runs goes through here.
app::Messages& messages() {
  static app::Messages all([](const std::string& line) {
    app::print_error("karst-ig", line);
    std::fflush(stderr);
  });
  return all;
}

int run(std::span<const char* const> words) {
  if (!words.empty() && std::string_view(words[0]) == "--print-manual") {
    static constexpr const app::CommandSpec* kCommands[] = {&kIgSpec};
    return app::print_manual({"karst-ig", kIgSpec.brief, "", kCommands}, words.subspan(1));
  }
  app::CommandLine line;
  IgOptions options;
  if (const Error usage = parse_ig_options(words, line, options); !usage.ok()) {
    app::print_error("karst-ig", usage.text());
    return app::kExitUsage;
  }
  if (line.wants_help()) {
    std::fputs(app::help_text(kIgSpec).c_str(), stdout);
    return app::kExitOk;
  }
  if (line.has("version")) {
    std::puts("karst-ig " KARST_VERSION);
    return app::kExitOk;
  }
  const LogLine say = [](const std::string& text) { messages().say(text, now_ns()); };
  if (options.list_outputs) return print_outputs(options, say);
  ConsoleState own;
  ConsoleState* console = &own;
  if (const int code = supervise_screen(options, say, console); code >= 0) return code;
  if (const Error error = Generator(std::move(options), *console, messages()).run(); !error.ok()) {
    app::print_error("karst-ig", error.text());
    return app::kExitFailure;
  }
  return app::kExitOk;
}

}  // namespace
}  // namespace karst::ig

int main(int argc, char** argv) {
  return karst::app::run_program("karst-ig", argc, argv, karst::ig::run);
}
