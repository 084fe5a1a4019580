// SPDX-License-Identifier: MIT
// Commands that the documents show are commands of the programs.
#include <filesystem>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/process.h"

namespace karst::core {
namespace {

struct Command {
  const char* program;
  std::string name;  // of karst
  friend auto operator<=>(const Command&, const Command&) = default;
};

std::string help_of(const Command& command) {
  static std::map<Command, std::string> known;
  std::string& help = known[command];
  if (!help.empty()) return help;
  std::vector<std::string> words = {"--help"};
  if (!command.name.empty()) words.insert(words.begin(), command.name);
  help = test::run_process(command.program, words).out;
  return help;
}

// Every option behind "karst COMMAND", "karst-bake" or "karst-bench" on a line of the page is in its help.
int check_page(const std::string& page, const std::string& text) {
  std::map<std::string, const char*> programs = {{"karst", KARST_APP_PATH}};
#ifdef KARST_BAKE_PATH
  programs["karst-bake"] = KARST_BAKE_PATH;
#endif
#ifdef KARST_BENCH_PATH
  programs["karst-bench"] = KARST_BENCH_PATH;
#endif
  const std::regex command("\\b(karst(?:-bake|-bench)?) (?:(view|budget|render|info) )?([^#\n|`]*)");
  const std::regex option("(?:^| )(--[a-z][a-z-]*)");
  int options = 0;
  for (std::sregex_iterator m(text.begin(), text.end(), command), end; m != end; ++m) {
    const auto program = programs.find((*m)[1].str());
    const bool names_command = (*m)[2].matched;
    if (program == programs.end() || (program->first == "karst") != names_command) continue;
    const std::string words = (*m)[3].str();
    for (std::sregex_iterator o(words.begin(), words.end(), option); o != end; ++o) {
      const std::string help = help_of({program->second, (*m)[2].str()});
      EXPECT_NE(help.find((*o)[1].str()), std::string::npos) << page << ": " << (*m)[0];
      ++options;
    }
  }
  return options;
}

TEST(Docs, OptionsExist) {
  int options = check_page("README.md", test::read_text(KARST_SOURCE_DIR "/README.md"));
  for (const auto& entry : std::filesystem::recursive_directory_iterator(KARST_SOURCE_DIR "/docs")) {
    if (entry.path().extension() != ".md") continue;
    options += check_page(entry.path().filename().string(), test::read_text(entry.path().string()));
  }
  EXPECT_GE(options, 40);
}

// The unit starts the program with options that exist, and the page installs what is in the repository.
TEST(Docs, TheKioskPageNamesFilesThatExist) {
  const std::string text = test::read_text(KARST_SOURCE_DIR "/docs/kiosk.md");
  EXPECT_NE(text.find("boards/kiosk/karst-kiosk.service"), std::string::npos);
  const std::string unit = test::read_text(KARST_SOURCE_DIR "/boards/kiosk/karst-kiosk.service");
  EXPECT_NE(unit.find("exec /usr/bin/karst view \"$$KARST_WORLD\" --seat direct --stats "),
            std::string::npos);
  EXPECT_NE(unit.find("RuntimeDirectory=karst"), std::string::npos);
  EXPECT_NE(text.find("/run/karst/view.json"), std::string::npos);
  EXPECT_NE(unit.find("--stats /run/karst/view.json"), std::string::npos);
  for (const char* name : {"KARST_WORLD=", "KARST_OPTIONS="}) EXPECT_NE(text.find(name), std::string::npos);
}

}  // namespace
}  // namespace karst::core
