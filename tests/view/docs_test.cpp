// SPDX-License-Identifier: MIT
// Commands that the pages on kiosks and boards show are commands of the program.
#include <regex>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/process.h"

namespace karst::core {
namespace {

// Every option behind "karst COMMAND" in an indented or quoted line of the page is in that command's help.
void check_page(const std::string& page, int least) {
  const std::string text = test::read_text(std::string(KARST_SOURCE_DIR) + "/" + page);
  const std::regex command("karst (view|budget|render) ([^#\n|`]*)");
  int options = 0;
  for (std::sregex_iterator m(text.begin(), text.end(), command), end; m != end; ++m) {
    const std::string help = test::run_process(KARST_APP_PATH, {(*m)[1].str(), "--help"}).out;
    const std::string words = (*m)[2].str();
    const std::regex option("--[a-z-]+");
    for (std::sregex_iterator o(words.begin(), words.end(), option); o != end; ++o) {
      EXPECT_NE(help.find(o->str()), std::string::npos) << page << ": karst " << (*m)[1] << " " << o->str();
      ++options;
    }
  }
  EXPECT_GE(options, least) << page;
}

TEST(Docs, OptionsExist) {
  check_page("docs/kiosk.md", 10);
  check_page("docs/boards.md", 5);
}

// The unit starts the program with options that exist, and the page installs what is in the repository.
TEST(Docs, TheKioskPageNamesFilesThatExist) {
  const std::string text = test::read_text(KARST_SOURCE_DIR "/docs/kiosk.md");
  EXPECT_NE(text.find("boards/kiosk/karst-kiosk.service"), std::string::npos);
  const std::string unit = test::read_text(KARST_SOURCE_DIR "/boards/kiosk/karst-kiosk.service");
  EXPECT_NE(unit.find("ExecStart=/usr/bin/karst view $KARST_WORLD $KARST_OPTIONS"), std::string::npos);
  for (const char* name : {"KARST_WORLD=", "KARST_OPTIONS="}) EXPECT_NE(text.find(name), std::string::npos);
}

}  // namespace
}  // namespace karst::core
