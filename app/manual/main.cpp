// SPDX-License-Identifier: MIT
// karst-manual: man pages and bash completion of karst, printed while karst is built.
#include <span>

#include "app/command_line/manual.h"
#include "app/commands.h"

int main(int argc, char** argv) {
  using namespace karst::app;
  static constexpr const CommandSpec* kCommands[] = {&kViewSpec, &kRenderSpec, &kInfoSpec, &kEditSpec,
                                                     &kBudgetSpec};
  static constexpr ProgramSpec kProgram = {
      .name = "karst",
      .brief = "draws terrain with overhangs, arches and caves",
      .about =
          "Draws worlds that karst-bake(1) made from elevation models, on a board's screen, in a window or "
          "into pictures. A world's memory is known before any of it is taken.",
      .commands = kCommands};
  const std::span<char* const> all(argv, static_cast<std::size_t>(argc));
  return print_manual(kProgram, {all.data() + 1, all.empty() ? 0 : all.size() - 1});
}
